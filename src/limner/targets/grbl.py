"""Lines in millimetres go in; G-code goes to a plotter under GRBL 1.1, no faster than its buffer takes it."""

from __future__ import annotations

import contextlib
import re
import time
from collections import deque
from collections.abc import Callable, Sequence

from limner.errors import DeviceFailed
from limner.targets.gcode import MODES, GcodeSettings, Words, number
from limner.targets.grbl_words import explained
from limner.targets.link import Lines, Link, Noise
from limner.types import Floats

RX_BYTES = 127
"""GRBL's serial buffer has 128 bytes and keeps one free."""

BANNER = re.compile(r"Grbl(HAL)? \d", re.IGNORECASE)

_PATIENCE = 3600  # things said without an answer: it is asked for its state about once a second
_GREETINGS = 100  # lines after a reset

_RESET, _HOLD, _STATUS = b"\x18", b"!", b"?"
_TALK = re.compile(r"\[.*\]|\$.*|>.*")  # messages, settings, start-up lines: not answers to what we send


class Grbl:
    """A plotter under GRBL behind a link.

    Flow is controlled by counting characters: of the lines sent and not yet answered never more than ``RX_BYTES`` are
    under way, so that GRBL always knows the next moves and need not slow down between them.
    """

    def __init__(self, link: Link, settings: GcodeSettings, home_mm: Sequence[float], silence_s: float = 5.0) -> None:
        """Take a link; nothing is sent yet.

        Args:
            link: to the machine.
            settings: what lifts the pen, and its feed.
            home_mm: (2,) where the pen stands in the beginning, page frame.
            silence_s: a machine that says nothing for so long has failed.
        """
        self.name = f"GRBL at {link.name}"
        self._link, self._lines, self._words = link, Lines(link), Words(settings)
        self._home, self._silence_s = home_mm, silence_s
        self._under_way: deque[tuple[int, str]] = deque()
        self._pen_is_up = False
        self._told: list[str] = []

    def open(self) -> None:
        """Reset it, see that it is GRBL and not locked, raise the pen, and call where it is home."""
        self._greet()
        if "Alarm" in self._state():
            raise DeviceFailed(f"{self.name} is locked by an alarm; home it ($H) or unlock it ($X), then send again")
        settings = self._words.settings
        z = f" Z{number(settings.z_up_mm)}" if settings.pen == "z" else ""
        self._check_laser_mode()
        for line in (MODES, f"G92 X{number(self._home[0])} Y{number(self._home[1])}{z}", *self._words.up()):
            self._queue(line)
        self._finish()
        self._pen_is_up = True

    def _check_laser_mode(self) -> None:
        """A servo is moved by the spindle's output, which laser mode switches off while the pen travels."""
        self._told.clear()
        self._queue("$$")
        self._drain()
        if self._words.settings.pen == "servo" and any(setting.startswith("$32=1") for setting in self._told):
            raise DeviceFailed(f"{self.name} is in laser mode, which drops a servo pen; send it $32=0 once")

    def draw(self, line_mm: Floats, going_on: Callable[[], bool]) -> int:
        """As ``Target.draw``; it can stop at every point."""
        points = line_mm.tolist()
        self._queue(self._words.travel(points[0]))
        # Should the travel be refused, the pen must not have been told to go down.
        self._drain()
        self._pen_is_up = False
        for line in self._words.down():
            self._queue(line)
        reached = 0
        for to in points[1:]:
            if not going_on():
                break
            self._queue(self._words.draw(to, reached == 0))
            reached += 1
        self._raise()
        return reached

    def home(self) -> None:
        """Go home and wait until it is there."""
        self._queue(self._words.travel(self._home))
        self._finish()

    def abort(self) -> bool:
        """Hold, reset, raise the pen."""
        with contextlib.suppress(DeviceFailed):
            self._link.write(_HOLD)
            end = time.monotonic() + self._silence_s
            while "Run" in self._state() and time.monotonic() < end:
                time.sleep(0.02)
            self._greet()
            if "Alarm" in self._state():
                self._queue("$X")
            self._raise_blindly()
        return self._pen_is_up

    def close(self) -> None:
        """Let go of the port."""
        self._link.close()

    def _raise(self) -> None:
        for line in self._words.up():
            self._queue(line)
        self._finish()
        self._pen_is_up = True

    def _raise_blindly(self) -> None:
        """After a reset Z is where it is, but its zero is forgotten: a Z pen goes up by as much as it was lowered."""
        if self._pen_is_up:
            return
        settings = self._words.settings
        if settings.pen == "z":
            self._queue(f"G21 G91 G0 Z{number(settings.z_up_mm - settings.z_down_mm)}")
            self._queue("G90")
            self._finish()
            self._pen_is_up = True
        else:
            self._raise()

    def _queue(self, line: str) -> None:
        """Send a line as soon as there is room for it."""
        data = f"{line}\n".encode("ascii")
        while sum(size for size, _ in self._under_way) + len(data) > RX_BYTES:
            self._answered()
        self._link.write(data)
        self._under_way.append((len(data), line))

    def _finish(self) -> None:
        """Wait until everything sent has been done, not only read: a dwell is answered after the moves before it."""
        self._queue("G4 P0.01")
        self._drain()

    def _drain(self) -> None:
        while self._under_way:
            self._answered()

    def _answered(self) -> None:
        """Wait for the answer to the oldest line; moves may take long, but GRBL tells its state meanwhile."""
        for _ in range(_PATIENCE):
            answer = self._next()
            if answer == "ok":
                self._under_way.popleft()
                return
            if answer.startswith(("error:", "ALARM:")):
                line = self._under_way[0][1] if answer.startswith("error") else "a move"
                raise DeviceFailed(f"{self.name} refuses {line!r} with {explained(answer)}")
            if answer.startswith("<Alarm"):
                raise DeviceFailed(f"{self.name} is locked by an alarm; home it ($H) or unlock it ($X), then --resume")
            if BANNER.match(answer):
                raise DeviceFailed(f"{self.name} has reset itself; check its power and the cable's shielding")
            self._told += [answer] if answer.startswith("$") else []
            if not (answer.startswith("<") or _TALK.fullmatch(answer)):
                raise DeviceFailed(f"{self.name} says {answer[:40]!r}, which is no answer of GRBL's; check the cable")
        raise DeviceFailed(f"{self.name} says much but does not answer {self._under_way[0][1]!r}; reset it")

    def _next(self) -> str:
        """The next thing it says; it is asked for its state when it has said nothing for a while."""
        end = time.monotonic() + self._silence_s
        # However late it is, what has come is looked at first: this process may have slept, not the machine.
        while (answer := self._lines.next(self._silence_s / 5)) is None:
            if time.monotonic() > end:
                raise DeviceFailed(f"{self.name} has said nothing for {self._silence_s:g} s; check cable and power")
            self._link.write(_STATUS)
        return answer

    def _state(self) -> str:
        """What it does now, such as Idle, Run, Hold:0, Alarm."""
        self._link.write(_STATUS)
        end = time.monotonic() + self._silence_s
        while not (answer := self._lines.next(max(end - time.monotonic(), 0)) or "").startswith("<"):
            if time.monotonic() > end:
                raise DeviceFailed(f"{self.name} does not tell its state; check cable and power")
        return answer.strip("<>").partition("|")[0]

    def _greet(self) -> None:
        """Reset it until its greeting comes; a board that has just been plugged in takes a while to start."""
        self._under_way.clear()
        heard: str | None = None
        for _ in range(4):
            self._link.write(_RESET)
            left = self._silence_s / 4
            end = time.monotonic() + left
            while left > 0:
                try:
                    heard = self._lines.next(left) or heard
                except Noise:
                    heard = "noise"
                if heard and BANNER.match(heard):
                    self._quiet()
                    return
                left = end - time.monotonic()
        said = f"it says {heard[:40]!r}" if heard else "it says nothing"
        raise DeviceFailed(f"{self.name}: no GRBL answers, {said}; check port, baud rate and power")

    def _quiet(self) -> None:
        """Let a second greeting and its messages pass."""
        for _ in range(_GREETINGS):
            if self._lines.next(self._silence_s / 50) is None:
                return
        raise DeviceFailed(f"{self.name} does not stop talking; check port and baud rate")
