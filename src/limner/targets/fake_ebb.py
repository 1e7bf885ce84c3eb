"""A fake of an AxiDraw's board: bytes go in, answers, ink and breaches of protocol come out."""

from __future__ import annotations

from dataclasses import dataclass, field

from limner.targets.fake import Fake, Point


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
