"""The pen's motion in time goes in; commands for the board of an AxiDraw (EBB), slice by slice, go out."""

from __future__ import annotations

import contextlib
import itertools
import math
import re
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from limner import geometry
from limner.errors import BadInput, DeviceFailed
from limner.settings import SettingsGroup, setting
from limner.targets.link import Lines, Link
from limner.types import Floats, PenPath

Plan = Callable[[Floats, Floats], PenPath]
"""From where the pen is (2,) and a line (n, 2), page frame, to its motion there and along it, raised at the end."""

SLICE_S = 0.012
"""Slices of motion are at least so long where the path allows: the board takes a command in a few milliseconds."""

CUT_MM = 0.03
"""No corner is cut by more than this to make a slice longer."""

MAX_STEPS_PER_MS = 25.0

_SERVO_0, _SERVO_100 = 9855, 27831  # of 1/12 us: 0.8 and 2.3 ms
_SERVO_RATE = 0  # at once; the plan's times hold the pauses
_LEFT_OVER = 100  # lines that may still come when it is stopped
_NO_POWER = 250  # of the 10-bit reading of the motors' voltage; USB alone reads less


@dataclass(frozen=True)
class EbbSettings(SettingsGroup):
    """How the board of an AxiDraw moves pen and carriage."""

    pen_up: float = setting(60.0, "Height of the raised pen in the servo's travel", unit="%", low=0, high=100)
    pen_down: float = setting(30.0, "Height of the lowered pen in the servo's travel", unit="%", low=0, high=100)
    steps_per_mm: float = setting(80.0, "Steps of both motors for a move of 1 mm in x", unit="1/mm", low=1, high=1000)


@dataclass(frozen=True)
class Limits:
    """What a motion keeps.

    Attributes:
        fastest_mm_s: its greatest speed.
        brake_mm: the way it takes to come to rest from its greatest speed with the pen down.
    """

    fastest_mm_s: float
    brake_mm: float


@dataclass(frozen=True)
class Command:
    """A command of a motion.

    Attributes:
        text: as it is sent, without its end.
        seconds: that it takes.
        steps: (2,) where the motors are after it.
        until_s: the time of the motion at its end.
    """

    text: str
    seconds: float
    steps: NDArray[np.int64]
    until_s: float


class Ebb:
    """An AxiDraw behind a link.

    The board knows neither corners nor acceleration: every move is a slice of constant speed, whose steps and
    milliseconds come from the planned motion, counted from the beginning so that nothing adds up. Motor 1 turns by
    x + y and motor 2 by x - y, with y down the page.
    """

    def __init__(
        self,
        link: Link,
        plan: Plan,
        settings: EbbSettings,
        home_mm: Sequence[float],
        limits: Limits,
        silence_s: float = 3.0,
    ) -> None:
        """Take a link; nothing is sent yet.

        Args:
            link: to the board.
            plan: the motion of a line.
            settings: of pen and carriage.
            home_mm: (2,) where the pen stands in the beginning, page frame.
            limits: what ``plan`` keeps.
            silence_s: a board that says nothing for so long has failed.

        Raises:
            BadInput: the board cannot step so fast.
        """
        self.name = f"EBB at {link.name}"
        self._link, self._lines, self._plan, self._settings = link, Lines(link), plan, settings
        self._home, self._silence_s = np.array(home_mm, dtype=np.float64), silence_s
        self._place = self._home.copy()
        self._steps = np.zeros(2, np.int64)
        self._pen_is_up = False
        self._brake_mm = limits.brake_mm
        self._recent_s: deque[float] = deque(maxlen=4)
        limit = 0.95 * MAX_STEPS_PER_MS * 1000 / (settings.steps_per_mm * np.sqrt(2))
        if limits.fastest_mm_s > limit:
            raise BadInput(f"machine: {limits.fastest_mm_s:g} mm/s; an EBB makes at most {limit:.0f} mm/s")

    def open(self) -> None:
        """See that it is an EBB with power, raise the pen, and call where it is home."""
        version = self._ask("V", re.compile(r"EBB.*Version.*"))
        if version is None:
            raise DeviceFailed(f"{self.name}: no EBB answers; check port and power")
        self._check_power()
        up, down = _servo(self._settings.pen_up), _servo(self._settings.pen_down)
        for command in (f"SC,4,{up}", f"SC,5,{down}", f"SC,10,{_SERVO_RATE}", "SP,1,500", "EM,1,1", "CS"):
            self._tell(command)
        self._pen_is_up = True

    def draw(self, line_mm: Floats, going_on: Callable[[], bool]) -> int:
        """As ``Target.draw``; it stops at the next point before which it can slow down."""
        self._pen_is_up = False
        path, reached = self._plan(self._place, line_mm), len(line_mm) - 1
        ended_s = self._follow(path, going_on)
        if ended_s < path.t_s[-1]:
            reached = self._next_halt(path, line_mm, ended_s)
            # The same motion up to here, since no limit reaches back farther than the way it takes to slow down.
            path = self._plan(self._place, line_mm[: reached + 1])
            self._follow(path, begin_s=ended_s)
        self._rest(path)
        self._pen_is_up = True
        return reached

    def home(self) -> None:
        """Go home, wait until it is there, and let go of the carriage."""
        path = self._plan(self._place, self._home[None])
        raised = path.position_mm[:, 2] == path.position_mm[0, 2]
        k = len(raised) if raised.all() else int(raised.argmin())
        travel = PenPath(path.t_s[:k], path.position_mm[:k], path.down[:k], path.stroke[:k])
        self._follow(travel)
        self._rest(travel)
        self._tell("EM,0,0")

    def abort(self) -> bool:
        """Stop the motors, raise the pen."""
        with contextlib.suppress(DeviceFailed):
            self._link.write(b"\rES\r")
            for _ in range(_LEFT_OVER):
                if self._lines.next(self._silence_s / 10) is None:
                    break
            self._tell("SP,1,500")
            self._pen_is_up = True
        return self._pen_is_up

    def close(self) -> None:
        """Let go of the port."""
        self._link.close()

    def _follow(self, path: PenPath, going_on: Callable[[], bool] = lambda: True, begin_s: float = 0.0) -> float:
        """Move from one time of a path to its end, or to where it is not to go on; tells the time of that."""
        for command in commands(path, self._steps, self._to_steps, begin_s):
            self._tell(command.text, command.seconds)
            self._steps = command.steps
            if not going_on():
                return command.until_s
        return float(path.t_s[-1])

    def _next_halt(self, path: PenPath, line_mm: Floats, t_s: float) -> int:
        """The first point of a line that is farther from where the pen is than it takes to slow down."""
        drawn = path.down & (path.t_s <= t_s)
        behind = float(np.hypot(*np.diff(path.position_mm[:, :2], axis=0).T)[drawn[1:]].sum())
        along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line_mm, axis=0).T))])
        far = np.flatnonzero(along >= behind + self._brake_mm)
        return int(far[0]) if len(far) else len(line_mm) - 1

    def _rest(self, path: PenPath) -> None:
        """At the end of a path, wait until it is there, and see that it is."""
        self._place = path.position_mm[-1, :2].copy()
        self._wait_until_still()

    def _to_steps(self, place_mm: Floats) -> NDArray[np.int64]:
        """Steps of both motors from home: (n, 2)."""
        x, y = (place_mm - self._home).T * self._settings.steps_per_mm
        steps: NDArray[np.int64] = np.rint(np.stack([x - y, x + y], axis=1)).astype(np.int64)
        return steps

    def _wait_until_still(self) -> None:
        end = time.monotonic() + sum(self._recent_s) + self._silence_s
        while self._ask("QM", re.compile(r"QM(,\d+)+")) not in ("QM,0,0,0,0", "QM,0,0,0"):
            if time.monotonic() > end:
                raise DeviceFailed(f"{self.name} has not come to rest; check its motors")
        where = self._ask("QS", re.compile(r"-?\d+,-?\d+"))
        self._take_ok("QS", self._silence_s)
        if where != f"{self._steps[0]},{self._steps[1]}":
            raise DeviceFailed(
                f"{self.name} stands at step {where} instead of {self._steps[0]},{self._steps[1]};"
                " was it reset or stopped by hand?"
            )

    def _check_power(self) -> None:
        reading = self._ask("QC", re.compile(r"\d+,\d+")) or "0,0"
        self._take_ok("QC", self._silence_s)
        if int(reading.split(",")[1]) < _NO_POWER:
            raise DeviceFailed(f"{self.name} has no power for its motors; plug its power supply in and switch it on")

    def _tell(self, command: str, seconds: float = 0.0) -> None:
        """Give a command and wait until it is taken, which it is when the one before it is nearly done."""
        self._recent_s.append(seconds)
        self._link.write(f"{command}\r".encode("ascii"))
        self._take_ok(command, self._silence_s + sum(self._recent_s))

    def _take_ok(self, command: str, timeout_s: float) -> None:
        answer = self._lines.next(timeout_s)
        if answer == "OK":
            return
        if answer is None:
            raise DeviceFailed(f"{self.name} has said nothing to {command!r}; check cable and power")
        if answer.startswith("!"):
            raise DeviceFailed(f"{self.name} refuses {command!r} with {answer[:60]!r}")
        raise DeviceFailed(f"{self.name} says {answer[:40]!r} to {command!r}, which is no answer of an EBB's")

    def _ask(self, command: str, expected: re.Pattern[str]) -> str | None:
        self._link.write(f"{command}\r".encode("ascii"))
        answer = self._lines.next(self._silence_s)
        if answer is None and command != "V":
            raise DeviceFailed(f"{self.name} has said nothing to {command!r}; check cable and power")
        if answer is not None and not expected.fullmatch(answer):
            raise DeviceFailed(f"{self.name} says {answer[:40]!r} to {command!r}, which is no answer of an EBB's")
        return answer


def _servo(per_cent: float) -> int:
    return round(_SERVO_0 + (_SERVO_100 - _SERVO_0) * per_cent / 100)


def commands(
    path: PenPath, steps: NDArray[np.int64], to_steps: Callable[[Floats], NDArray[np.int64]], begin_s: float = 0.0
) -> Iterator[Command]:
    """The commands of a motion.

    Args:
        path: the motion.
        steps: (2,) where the motors are.
        to_steps: from places (n, 2) [mm] to where the motors are there (n, 2).
        begin_s: the time of the motion at which they are there.
    """
    lifts = np.concatenate([[False], np.diff(path.position_mm[:, 2]) != 0])
    time_ms, position = np.rint(path.t_s * 1000).astype(np.int64), to_steps(path.position_mm[:, :2])
    at, last_ms = steps, round(begin_s * 1000)
    first = max(int(np.searchsorted(path.t_s, begin_s, side="right")) - 1, 0)
    for before, k in itertools.pairwise([first, *_ends(path, lifts, first)]):
        by = position[k] - at
        least = 1 if lifts[k] else math.ceil(float(np.abs(by).max()) / MAX_STEPS_PER_MS)
        took = max(int(time_ms[k]) - last_ms, least)
        if lifts[k]:
            text = f"SP,{int(path.position_mm[k, 2] > path.position_mm[before, 2])},{took}"
        elif took and (by.any() or took >= SLICE_S * 1000):
            text = f"SM,{took},{by[0]},{by[1]}"
        else:
            continue
        at, last_ms = position[k], last_ms + took
        yield Command(text, took / 1000, at, float(path.t_s[k]))


def _ends(path: PenPath, lifts: NDArray[np.bool_], first: int) -> Iterator[int]:
    """The samples at which a command ends: of a lift the last, of a motion as few as ``SLICE_S`` and ``CUT_MM`` let."""
    place, count, last = path.position_mm[:, :2], len(path.t_s), first
    for k in range(first + 1, count):
        whole = k + 1 == count or lifts[k] != lifts[k + 1] or path.down[k] != path.down[k + 1]
        if not whole and (lifts[k] or path.t_s[k] - path.t_s[last] < SLICE_S):
            skipped = place[last + 1 : k + 1]
            if lifts[k] or geometry.distance_to_segments(skipped, place[last], place[k + 1]).max() < CUT_MM:
                continue
        last = k
        yield k
