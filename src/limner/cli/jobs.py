"""A drawing for a plotter, or the motion of an arm, goes in; what ``limner send`` asks, shows and does comes out."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass

import numpy as np

from limner.cli import machines
from limner.errors import BadInput
from limner.motion.arm.legs import Legs, legs
from limner.motion.arm.robot import Robot
from limner.motion.arm.robots import load_robot
from limner.motion.cost import seconds, stroke_begins
from limner.motion.machine import Machine, load_machine
from limner.motion.pen import plan
from limner.pipeline import Settings
from limner.simulation.device import SimulatedArm
from limner.targets import joints, urscript
from limner.targets.bridge import parse_bridge
from limner.targets.connect import Wiring, connect, parse_address
from limner.targets.ebb import Limits
from limner.targets.fake_ur import FakeUr
from limner.targets.journal import Journal, Place
from limner.targets.rosbridge import Rosbridge
from limner.targets.send import Control, Watch, drive, send
from limner.targets.simulated import parse_pace
from limner.targets.target import Arm
from limner.targets.ur import Ur, parse_host
from limner.types import Drawing, Floats, PenPath

MACHINE_OF = {"grbl": "grbl", "ebb": "axidraw", "sim": "axidraw"}
"""The profile of a board, unless --machine says another."""

Run = Callable[[Journal, Control, Watch], Place]


@dataclass(frozen=True)
class Job:
    """Something to draw, and what draws it.

    Attributes:
        drawing: what the journal tells drawings apart by; its strokes are counted.
        begins_s: (strokes,) when each stroke begins, as planned.
        seconds: how long all takes.
        name: of the machine.
        ready: what must be so before it begins.
        run: draws from the journal's place on.
    """

    drawing: Drawing
    begins_s: Floats
    seconds: float
    name: str
    ready: str
    run: Run


def plotter(drawing: str, to: str, machine: str | None, shrink: bool, baud: int, settings: Settings) -> Job:
    """A file of a drawing for a plotter.

    Raises:
        BadInput: no address, machine or drawing.
        CannotDraw: it is larger than the machine.
    """
    address = parse_address(to)
    mover = load_machine(machine or MACHINE_OF[address.kind])
    placed = machines.placed(drawing, mover, shrink)
    wiring = _wiring(placed, mover, settings, baud)

    def run(journal: Journal, control: Control, watch: Watch) -> Place:
        return send(placed, connect(address, wiring), journal, control, watch)

    ready = f"The pen stands raised over the page's {mover.home.replace('-', ' ')} corner, the paper lies."
    if placed.changes().any():
        used = [placed.pens[k].name for k in sorted(set(placed.layer.tolist()))]
        ready += f" Pens: {', '.join(used)}; {used[0]} is in the machine."
    return Job(placed, stroke_begins(placed, mover), seconds(placed, mover), mover.name, ready, run)


def _wiring(drawing: Drawing, machine: Machine, settings: Settings, baud: int) -> Wiring:
    def motion(start_mm: Floats, line_mm: Floats) -> PenPath:
        return plan(Drawing((line_mm,), ("face",), np.ones(1), drawing.page, (drawing.pen,)), machine, start_mm, None)

    x, y = machine.home_mm(drawing.page).tolist()
    limits = Limits(max(machine.draw_mm_s, machine.travel_mm_s), machine.draw_mm_s**2 / (2 * machine.draw_mm_s2))
    return Wiring((x, y), motion, limits, machines.gcode_for(settings.gcode, machine), settings.ebb, baud)


def arm(motion: str, to: str, robot: str, settings: Settings) -> Job:
    """A file of the motion of an arm's joints.

    Raises:
        BadInput: no address, robot or motion, or the arm has not six joints.
        CannotDraw: the motion is not for this arm, or exceeds its limits.
    """
    make, mover = _arm_at(to), load_robot(robot)
    route = legs(joints.load(motion), mover, settings.arm.retime, settings.arm.allowed)
    if not to.startswith((_SIMULATED, _BRIDGED)):
        urscript.check_joints(mover.joints)

    def run(journal: Journal, control: Control, watch: Watch) -> Place:
        with make(route, mover, settings) as arm:
            return _drive(arm, route, journal, control, watch)

    listens = f"listens to {parse_bridge(to).topic}" if to.startswith(_BRIDGED) else "is in remote control"
    ready = (
        f"The arm {listens}, the sheet lies where it was planned; the arm first goes straight from where it stands to"
        " the pose that the motion begins with, and nothing is in its way."
    )
    each, lines = route.seconds(), route.lines_mm()
    drawn = Drawing(lines, ("face",) * len(lines), np.ones(len(lines)))
    return Job(drawn, np.cumsum(each) - each, float(each.sum()), mover.name, ready, run)


_SIMULATED, _BRIDGED = "sim:", "rosbridge:"

_Making = Callable[[Legs, Robot, Settings], AbstractContextManager[Arm]]


def _arm_at(to: str) -> _Making:
    """What makes the arm at an address, while it is drawn with.

    Raises:
        BadInput: no such address.
    """
    if to.startswith(_SIMULATED):
        pace = parse_pace(to)
        return lambda route, robot, settings: nullcontext(SimulatedArm(route, settings.simulation, pace))
    if to.startswith(_BRIDGED):
        bridge = parse_bridge(to)
        return lambda route, robot, settings: nullcontext(
            Rosbridge(bridge, route, settings.rosbridge, robot.joints, robot.base)
        )
    if to == "fake:":
        return _fake_ur
    host = parse_host(to)
    return lambda route, robot, settings: nullcontext(Ur(*host, route, settings.ur))


@contextmanager
def _fake_ur(route: Legs, robot: Robot, settings: Settings) -> Iterator[Arm]:
    with FakeUr(route.motion.q[0], robot.lower, robot.upper, robot.velocity) as fake:
        yield Ur("127.0.0.1", fake.port, route, settings.ur)


def _drive(arm: Arm, route: Legs, journal: Journal, control: Control, watch: Watch) -> Place:
    def draw(place: Place) -> Place:
        return Place(place.stroke + arm.draw(place.stroke, lambda: control.stop))

    return drive(arm, draw, len(route.ends), journal, control, watch)


def first_place(job: Job, resume: bool, first: int | None) -> Place | None:
    """Where to begin, if a stroke was named.

    Raises:
        BadInput: there is no such stroke, or --resume says another.
    """
    if first is None:
        return None
    if resume:
        raise BadInput("--resume and --from say two places to begin; choose one")
    if first > len(job.begins_s):
        raise BadInput(f"--from {first}: the drawing has {len(job.begins_s)} strokes; choose one of them")
    return Place(first - 1)
