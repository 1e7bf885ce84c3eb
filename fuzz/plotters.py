"""What a plotter says goes in, as bytes from its cable; a driver listens to it."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from types import SimpleNamespace
from unittest import mock

import numpy as np

from fuzz.contract import Broken
from limner.errors import DeviceFailed, LimnerError
from limner.motion.machine import load_machine
from limner.motion.pen import plan
from limner.targets import ebb, grbl, link
from limner.targets.gcode import GcodeSettings
from limner.targets.target import Target
from limner.types import Drawing, Floats, Page, PenPath

LINE = np.array([[10.0, 10.0], [20.0, 10.0], [20.0, 15.0]])
MOST_READS = 20_000
"""Looks at the cable in one conversation; more is a driver that listens for ever."""


class Told:
    """A cable whose other end says what it was given, a piece each time it is asked, over and over.

    The first byte says how: pieces of 1 to 64 bytes, once or again and again. Its clock runs by looking at it.
    """

    def __init__(self, data: bytes) -> None:
        self.name, self.now = "fake", 0.0
        self._data, self._at, self._reads = data[1:], 0, 0
        self._piece, self._again = 1 + data[0] % 64 if data else 1, bool(data) and data[0] >= 128

    def write(self, data: bytes) -> None:
        """Heard by nobody."""

    def read(self, timeout_s: float) -> bytes:
        """The next piece; time passes."""
        self._reads += 1
        if self._reads > MOST_READS:
            raise Broken("listens for ever")
        if self._at >= len(self._data) and self._again:
            self._at = 0
        piece = self._data[self._at : self._at + self._piece]
        self._at += self._piece
        self.now += 1e-3 if piece else max(timeout_s, 1e-3)
        return piece

    def close(self) -> None:
        """Nothing is held."""


@contextlib.contextmanager
def clock_of(told: Told) -> Iterator[None]:
    """The drivers' time is the cable's."""

    def sleep(seconds: float) -> None:
        told.now += seconds

    clock = SimpleNamespace(monotonic=lambda: told.now, sleep=sleep)
    with contextlib.ExitStack() as stack:
        for module in (grbl, ebb, link):
            stack.enter_context(mock.patch.object(module, "time", clock))
        yield


def _draw(target: Target, told: Told) -> None:
    with clock_of(told):
        try:
            target.open()
            target.draw(LINE, lambda: True)
            target.home()
        except LimnerError:
            assert isinstance(target.abort(), bool)
            raise
        finally:
            with contextlib.suppress(DeviceFailed):
                target.close()


def grbl_answers(data: bytes) -> None:
    """GRBL, with a servo and with a Z pen."""
    told = Told(data)
    pen = "z" if data and data[0] & 64 else "servo"
    _draw(grbl.Grbl(told, GcodeSettings(pen=pen), (0.0, 210.0)), told)


def ebb_answers(data: bytes) -> None:
    """The board of an AxiDraw."""
    machine = load_machine("axidraw")

    def motion(start: Floats, line: Floats) -> PenPath:
        way = Drawing((np.concatenate([start[None], line]),), ("face",), np.ones(1), Page())
        return plan(way, machine)

    told = Told(data)
    limits = ebb.Limits(machine.travel_mm_s, machine.draw_mm_s**2 / (2 * machine.draw_mm_s2))
    _draw(ebb.Ebb(told, motion, ebb.EbbSettings(), (0.0, 210.0), limits), told)


HARNESSES = {"grbl": grbl_answers, "ebb": ebb_answers}
