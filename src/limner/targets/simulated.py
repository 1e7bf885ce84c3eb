"""Lines go in; a plotter that is not there draws them, at the pace of one that is."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence

import numpy as np

from limner.errors import BadInput
from limner.targets.ebb import Plan
from limner.types import Floats, PenPath

PACES = (0.01, 1000.0)
"""How much slower or faster than the machine a simulation may be."""

_LOOK_S = 0.02


def parse_pace(text: str) -> float:
    """How many times as fast, from ``sim:`` (1) or ``sim:20``.

    Raises:
        BadInput: something else.
    """
    word = text.removeprefix("sim:")
    try:
        pace = float(word or 1)
    except ValueError:
        pace = math.nan
    if not text.startswith("sim:") or not PACES[0] <= pace <= PACES[1]:
        raise BadInput(f"--to {text}: expected sim:, or how many times as fast: sim:20 ({PACES[0]:g} to {PACES[1]:g})")
    return pace


class Clock:
    """Lets a simulation take its time: what is behind catches up, so that nothing adds up."""

    def __init__(self, pace: float) -> None:
        """Begin now.

        Args:
            pace: seconds of the machine in a second.
        """
        self._pace, self._due = pace, time.monotonic()

    def wait(self, seconds: float, going_on: Callable[[], bool] = lambda: True) -> float:
        """Wait for so much of the machine's time, or until it is not to go on; the time waited."""
        now = time.monotonic()
        # Who was paused is not behind.
        began = max(self._due, now - 1.0)
        self._due = began + seconds / self._pace
        while (left := self._due - time.monotonic()) > 0:
            if not going_on():
                self._due = time.monotonic()
                return min(seconds, (self._due - began) * self._pace)
            time.sleep(min(left, _LOOK_S))
        return seconds


class SimulatedPlotter:
    """A plotter that moves as planned and never fails.

    Attributes:
        name: that says what it is.
        lines_mm: what it has drawn.
    """

    def __init__(self, plan: Plan, home_mm: Sequence[float], pace: float = 1.0) -> None:
        """A plotter with its pen raised.

        Args:
            plan: the motion of a line.
            home_mm: (2,) where the pen stands in the beginning, page frame.
            pace: seconds of the machine in a second.
        """
        self.name = "a simulated plotter"
        self.lines_mm: list[Floats] = []
        self._plan, self._clock = plan, Clock(pace)
        self._home = self._place = np.array(home_mm, dtype=np.float64)

    def open(self) -> None:
        """It is always there."""

    def draw(self, line_mm: Floats, going_on: Callable[[], bool]) -> int:
        """Take the time to draw a line; it can stop at each of its points."""
        path = self._plan(self._place, line_mm)
        times = _arrivals(path, line_mm)
        waited = self._clock.wait(float(times[0]))
        for reached in range(1, len(line_mm)):
            if not going_on():
                return self._raised(line_mm[:reached])
            waited += self._clock.wait(float(times[reached] - times[reached - 1]))
        self._clock.wait(max(0.0, float(path.t_s[-1]) - waited))
        return self._raised(line_mm)

    def _raised(self, drawn: Floats) -> int:
        self.lines_mm.append(drawn)
        self._place = drawn[-1]
        return len(drawn) - 1

    def home(self) -> None:
        """Take the time to go home."""
        path = self._plan(self._place, self._home[None])
        self._clock.wait(float(path.t_s[-1]))
        self._place = self._home

    def abort(self) -> bool:
        """Its pen is up."""
        return True

    def close(self) -> None:
        """There is nothing to let go of."""


def _arrivals(path: PenPath, line_mm: Floats) -> Floats:
    """(n,) when the pen is at each point of the line it draws."""
    drawn = np.flatnonzero(path.down)
    if not len(drawn):
        return np.full(len(line_mm), float(path.t_s[-1]))
    some = np.concatenate([drawn[:1] - 1, drawn])
    way = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(path.position_mm[some, :2], axis=0).T))])
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line_mm, axis=0).T))])
    arrivals: Floats = np.interp(along, way, path.t_s[some])
    return arrivals
