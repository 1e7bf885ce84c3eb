"""A fake of a plotter under GRBL: bytes go in, answers, ink and breaches of protocol come out."""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field

from limner.targets.fake import Fake, Point

_WORD = re.compile(r"([A-Z])(-?\d+(?:\.\d+)?)")


@dataclass
class FakeGrbl(Fake):
    """A fake of a plotter under GRBL 1.1 with 128 bytes of serial buffer and 15 planned moves.

    Attributes:
        pen: ``servo`` or ``z``.
        down_word: S or Z of the lowered pen.
        locked: whether it starts in alarm.
        laser: whether it is in laser mode.
        limit_mm: soft limits: a move beyond is alarm 2.
        fullest: most bytes that its buffer has held.
    """

    pen: str = "servo"
    down_word: float = 700.0
    locked: bool = False
    laser: bool = False
    limit_mm: tuple[float, float, float, float] = (-1.0, -1.0, 1000.0, 1000.0)
    fullest: int = 0
    _rx: bytearray = field(default_factory=bytearray)
    _moves: deque[Callable[[], None]] = field(default_factory=deque)
    _feed: bool = False
    _placed: bool = False
    _modes: set[str] = field(default_factory=set)
    _motion: str = "G0"
    _head: Point = (0.0, 0.0)
    _lowered: bool = False
    _held: bool = False

    def receive(self, data: bytes) -> None:
        """Take bytes; real-time commands pass by the buffer."""
        for byte in data:
            if byte == 0x18:
                self._restart()
            elif byte == ord("!"):
                self._held = True
            elif byte == ord("~"):
                self._held = False
            elif byte == ord("?"):
                self.say(f"<{self._state()}|MPos:0.000,0.000,0.000|FS:0,0>")
            else:
                self._rx.append(byte)
        self.fullest = max(self.fullest, len(self._rx))
        if len(self._rx) > 127:
            self.breach(f"the buffer of 128 bytes is overrun: {len(self._rx)}")

    def step(self) -> bool:
        """Read a line when there is room for its move, else make the oldest move."""
        if len(self._moves) < 15 and b"\n" in self._rx and not self._waits():
            line, _, rest = bytes(self._rx).partition(b"\n")
            self._rx = bytearray(rest)
            if not self._faulty():
                self._read(line.decode("latin-1").strip())
            return True
        if self._moves and not self._held:
            self._moves.popleft()()
            return True
        return False

    def _state(self) -> str:
        if self.locked:
            return "Alarm"
        if self._held:
            return "Hold:0"
        return "Run" if self._moves or self._rx else "Idle"

    def _waits(self) -> bool:
        """A dwell or a servo waits for all moves before it."""
        line = bytes(self._rx).partition(b"\n")[0]
        return bool(self._moves) and line.startswith((b"G4", b"M3"))

    def _restart(self) -> None:
        """As after a reset: modes, feed and G92 are forgotten, where the carriage is remains."""
        self._moves.clear()
        self._rx.clear()
        self._feed = self._placed = self._held = False
        self._modes.clear()
        self._motion = "G0"
        self._head = self.place
        self._lowered = self.pen_down
        self.say("")
        self.say("Grbl 1.1h ['$' for help]")

    def _refusal(self) -> str:
        return "error:9"

    def _read(self, line: str) -> None:
        if line == "$X":
            self.locked = False
        elif self.locked and line:
            self.say("error:9")
            return
        elif line == "$$":
            self.say(f"$30=1000\r\n$32={int(self.laser)}")
        elif line:
            words = _WORD.findall(line)
            if " ".join(a + b for a, b in words) != line:
                self.say("error:2")
                return
            answer = self._act([(letter, float(value)) for letter, value in words])
            if answer:
                self.say(answer)
                return
        self.say("ok")

    def _act(self, words: list[tuple[str, float]]) -> str:
        values = dict(words)
        codes = {f"{letter}{value:g}" for letter, value in words if letter in "GM"}
        self._modes |= codes & {"G21", "G90", "G17", "G94"}
        self._modes -= {"G90"} if "G91" in codes else set()
        self._motion = next(iter(codes & {"G0", "G1"}), self._motion)
        self._feed = self._feed or "F" in values
        if "G4" in codes or (not codes - {"G21", "G90", "G91", "G17", "G94"} and not {"X", "Y", "Z"} & set(values)):
            return ""
        if "G92" in codes:
            self.place = self._head = (values["X"], values["Y"])
            self._placed = True
            return ""
        if "M3" in codes:
            self._pen_goes(values["S"] == self.down_word)
            return ""
        return self._move(values)

    def _move(self, values: dict[str, float]) -> str:
        if self._motion == "G1" and not self._feed:
            return "error:22"
        if "Z" in values:
            # Relative words only raise the pen after a reset, when the zero of Z is not known.
            self._pen_goes("G90" in self._modes and values["Z"] == self.down_word)
            return ""
        if {"G21", "G90", "G17", "G94"} - self._modes or not self._placed:
            self.breach("a move before modes and home are said")
        to = (values.get("X", self._head[0]), values.get("Y", self._head[1]))
        x0, y0, x1, y1 = self.limit_mm
        if not (x0 <= to[0] <= x1 and y0 <= to[1] <= y1):
            self.locked = True
            return "ALARM:2"
        if (self._motion == "G0") == self._lowered:
            self.breach(f"{self._motion} with the pen {'down' if self._lowered else 'up'}")
        self._head = to
        self._moves.append(lambda: self._go(to))
        return ""

    def _pen_goes(self, down: bool) -> None:
        if down and not self._placed:
            self.breach("the pen goes down before home is said")
        self._lowered = down
        self._moves.append(lambda: self._lower(down))
