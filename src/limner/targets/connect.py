"""The text that names a machine, such as ``grbl:/dev/ttyUSB0``, goes in; the target behind it comes out."""

from __future__ import annotations

from dataclasses import dataclass

from limner.errors import BadInput
from limner.targets.ebb import Ebb, EbbSettings, Limits, Plan
from limner.targets.fake import FakeLink
from limner.targets.fake_ebb import FakeEbb
from limner.targets.fake_grbl import FakeGrbl
from limner.targets.gcode import GcodeSettings
from limner.targets.grbl import Grbl
from limner.targets.link import Link
from limner.targets.serial_link import SerialLink
from limner.targets.simulated import SimulatedPlotter, parse_pace
from limner.targets.target import Target

KINDS = ("grbl", "ebb", "fake", "sim")


@dataclass(frozen=True)
class Address:
    """Where a machine is.

    Attributes:
        kind: ``grbl``, ``ebb`` or ``sim``.
        port: the serial port; empty for a fake and for a simulated plotter.
        pace: of a simulated plotter, times the machine's own.
    """

    kind: str
    port: str
    pace: float = 1.0


@dataclass(frozen=True)
class Wiring:
    """All that a target may need to know.

    Attributes:
        home_mm: where the pen stands in the beginning, page frame.
        plan: the motion of a line, for a board that must be told it.
        limits: what that keeps.
        gcode: what lifts the pen of a GRBL plotter.
        ebb: pen and carriage of an AxiDraw.
        baud: of the serial port.
    """

    home_mm: tuple[float, float]
    plan: Plan
    limits: Limits
    gcode: GcodeSettings
    ebb: EbbSettings
    baud: int = 115_200


def parse_address(text: str) -> Address:
    """Kind and port from ``grbl:PORT``, ``ebb:PORT``, ``fake:``, ``fake:grbl``, ``fake:ebb``, ``sim:`` or ``sim:20``.

    Raises:
        BadInput: another kind, or no port.
    """
    kind, colon, port = text.partition(":")
    if kind == "fake" and colon and port in ("", "grbl", "ebb"):
        return Address(port or "grbl", "")
    if kind == "sim" and colon:
        return Address("sim", "", parse_pace(text))
    if kind in ("grbl", "ebb") and port:
        return Address(kind, port)
    if kind in ("ur", "rosbridge"):
        raise BadInput(f"--to {text}: an arm takes the motion that limner plan --robot writes; name it with --robot")
    raise BadInput(
        f"--to '{text}': expected grbl:PORT, ebb:PORT (such as grbl:/dev/ttyUSB0, ebb:COM3), sim: or fake:;"
        " an arm is named with --robot and reached by ur:HOST or rosbridge:ws://HOST:PORT/TOPIC"
    )


def connect(address: Address, wiring: Wiring) -> Target:
    """The target at an address; a serial port is opened, nothing is sent.

    Raises:
        DeviceFailed: the port cannot be opened.
        MissingExtra: a serial port needs pyserial.
        BadInput: the machine cannot move as fast as planned.
    """
    home = wiring.home_mm
    if address.kind == "sim":
        return SimulatedPlotter(wiring.plan, home, address.pace)
    if address.kind == "grbl":
        down = wiring.gcode.servo_down if wiring.gcode.pen == "servo" else wiring.gcode.z_down_mm
        fake = FakeGrbl(pen=wiring.gcode.pen, down_word=down)
        return Grbl(_link(address, wiring, fake), wiring.gcode, home)
    board = FakeEbb(home=home, steps_per_mm=wiring.ebb.steps_per_mm)
    return Ebb(_link(address, wiring, board), wiring.plan, wiring.ebb, home, wiring.limits)


def _link(address: Address, wiring: Wiring, fake: FakeGrbl | FakeEbb) -> Link:
    return SerialLink(address.port, wiring.baud) if address.port else FakeLink(fake)
