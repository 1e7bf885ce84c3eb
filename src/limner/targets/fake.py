"""Fakes of a GRBL plotter and an AxiDraw's board: bytes go in, answers, ink and breaches of protocol come out."""

from __future__ import annotations

import re
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field

from limner.errors import DeviceFailed

Point = tuple[float, float]

IDLE_S = 0.002
"""A fake with nothing to say waits so long, as a cable would."""

FAULTS = ("garbage", "silence", "reset", "unplug", "error")
"""What a fake can do wrong."""


@dataclass
class Fault:
    """What goes wrong, and with which line that the fake reads (0 = the first after it was opened); -1 = never."""

    kind: str = "garbage"
    line: int = -1


@dataclass
class Fake:
    """What both fakes share.

    Attributes:
        fault: what goes wrong.
        breaches: of the protocol, each a sentence; a driver must leave this empty.
        ink: segments drawn, and dots as segments of no length, page frame.
        place: where the pen is.
        pen_down: whether it is on the paper.
        lines: how many lines it has read.
        gone: whether it was unplugged.
    """

    fault: Fault = field(default_factory=Fault)
    breaches: list[str] = field(default_factory=list)
    ink: list[tuple[Point, Point]] = field(default_factory=list)
    place: Point = (0.0, 0.0)
    pen_down: bool = False
    lines: int = 0
    gone: bool = False
    _mute: bool = False
    _fresh: bool = False
    _out: bytearray = field(default_factory=bytearray)

    def receive(self, data: bytes) -> None:
        """Take bytes from the cable."""
        raise NotImplementedError

    def step(self) -> bool:
        """Do the next thing there is to do; False if there is nothing."""
        raise NotImplementedError

    def take(self) -> bytes:
        """What it has said since the last time."""
        said, self._out = bytes(self._out), bytearray()
        return b"" if self._mute else said

    def say(self, text: str) -> None:
        """Answer with a line."""
        self._out += text.encode("latin-1") + b"\r\n"

    def breach(self, what: str) -> None:
        """Note a breach of protocol."""
        self.breaches.append(f"line {self.lines}: {what}")

    def _faulty(self) -> bool:
        """Count a line; whether it is lost to the fault."""
        self.lines += 1
        if self.lines - 1 != self.fault.line:
            return False
        if self.fault.kind == "garbage":
            self.say("\xfe\x07ok\x80")
        elif self.fault.kind == "silence":
            self._mute = True
        elif self.fault.kind == "unplug":
            self.gone = True
        elif self.fault.kind == "reset":
            self._restart()
        elif self.fault.kind == "error":
            self.say(self._refusal())
        return True

    def _restart(self) -> None:
        raise NotImplementedError

    def _refusal(self) -> str:
        raise NotImplementedError

    def _lower(self, down: bool) -> None:
        if down and not self.pen_down:
            self._fresh = True
        elif self.pen_down and not down and self._fresh:
            self.ink.append((self.place, self.place))
        self.pen_down = down

    def _go(self, to: Point) -> None:
        if self.pen_down and to != self.place:
            self.ink.append((self.place, to))
            self._fresh = False
        self.place = to


class FakeLink:
    """A link straight into a fake, without a cable."""

    def __init__(self, fake: Fake, name: str = "fake") -> None:
        self.fake, self.name = fake, name

    def write(self, data: bytes) -> None:
        """Send all of it."""
        self._check()
        self.fake.receive(data)

    def read(self, timeout_s: float) -> bytes:
        """What the fake says, once it has something to say or nothing more to do."""
        self._check()
        while not (said := self.fake.take()) and self.fake.step():
            pass
        self._check()
        if not said:
            time.sleep(min(timeout_s, IDLE_S))
        return said

    def close(self) -> None:
        """Nothing is held."""

    def _check(self) -> None:
        if self.fake.gone:
            raise DeviceFailed(f"{self.name} does not answer any more; is it unplugged?")


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


@dataclass
class FakeEbb(Fake):
    """A fake of an AxiDraw's board, firmware 2.8.

    Attributes:
        home: where the pen stands when steps are counted from, page frame.
        steps_per_mm: of its motors.
        powered: whether its motors have power.
        milliseconds: that its motions have taken.
        slices: milliseconds and steps of both motors of each motion.
    """

    home: Point = (0.0, 0.0)
    steps_per_mm: float = 80.0
    powered: bool = True
    milliseconds: int = 0
    slices: list[tuple[int, int, int]] = field(default_factory=list)
    steps: tuple[int, int] = (0, 0)
    _rx: bytearray = field(default_factory=bytearray)
    _enabled: bool = False
    _counted: bool = False

    def receive(self, data: bytes) -> None:
        """Take bytes; a command ends with a carriage return."""
        self._rx += data
        if self._rx.count(b"\r") > 2:
            self.breach("a command before the last was answered")

    def step(self) -> bool:
        """Do the next command."""
        command, end, rest = bytes(self._rx).partition(b"\r")
        if not end:
            return False
        self._rx = bytearray(rest)
        if command and not self._faulty():
            self._act(command.decode("latin-1").split(","))
        return True

    def _restart(self) -> None:
        """The board forgets steps and motors; it greets nobody."""
        self._enabled = self._counted = False
        self.steps = (0, 0)

    def _refusal(self) -> str:
        return "!8 Err: Unknown command"

    def _act(self, words: list[str]) -> None:
        name = words[0]
        numbers = [int(word) for word in words[1:]]
        if name == "V":
            self.say("EBBv13_and_above EB Firmware Version 2.8.1")
            return
        if name == "QM":
            self.say("QM,0,0,0,0")
            return
        if name == "QS":
            self.say(f"{self.steps[0]},{self.steps[1]}")
        elif name == "QC":
            self.say(f"0394,{'0540' if self.powered else '0120'}")
        elif name == "SP":
            self._lower(numbers[0] == 0)
            self.milliseconds += numbers[1]
        elif name == "EM":
            self._enabled = numbers[0] > 0
        elif name == "CS":
            self.steps, self._counted, self.place = (0, 0), True, self.home
        elif name == "SM":
            self._moves(*numbers)
        elif name == "ES":
            self.say("0,0,0,0,0")
        elif name != "SC":
            self.say(f"!8 Err: Unknown command '{name}:{ord(name[0]) if name else 0}'")
            return
        self.say("OK")

    def _moves(self, milliseconds: int, one: int, two: int) -> None:
        if not self._enabled or not self._counted:
            self.breach("a move before motors and home are set")
        if milliseconds < 1 or max(abs(one), abs(two)) > 25 * milliseconds:
            self.breach(f"{one}, {two} steps in {milliseconds} ms")
        self.milliseconds += milliseconds
        self.slices.append((milliseconds, one, two))
        self.steps = (self.steps[0] + one, self.steps[1] + two)
        x, y = (self.steps[0] + self.steps[1]) / 2, (self.steps[0] - self.steps[1]) / 2
        self._go((self.home[0] + x / self.steps_per_mm, self.home[1] - y / self.steps_per_mm))
