"""What fakes of plotters share: bytes go in, answers, ink and breaches of protocol come out."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
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
class Fake(ABC):
    """A plotter that is none.

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

    @abstractmethod
    def receive(self, data: bytes) -> None:
        """Take bytes from the cable."""

    @abstractmethod
    def step(self) -> bool:
        """Do the next thing there is to do; False if there is nothing."""

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

    @abstractmethod
    def _restart(self) -> None:
        """What a reset does to it."""

    @abstractmethod
    def _refusal(self) -> str:
        """How it says that it takes no such line."""

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
