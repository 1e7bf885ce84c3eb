"""A fake of an AxiDraw's board: bytes go in, answers, ink and breaches of protocol come out."""

from __future__ import annotations

from dataclasses import dataclass, field

from limner.targets.fake import Fake, Point

_ANSWERS = {"V": "EBBv13_and_above EB Firmware Version 2.8.1", "QM": "QM,0,0,0,0"}
"""Of queries that no OK follows."""

_COMMANDS = {
    "QS": "_tell_steps",
    "QC": "_tell_power",
    "SP": "_move_pen",
    "EM": "_power",
    "CS": "_forget_steps",
    "SM": "_moves",
    "ES": "_stop",
    "SC": "_configure",
}


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
        name, numbers = words[0], [int(word) for word in words[1:]]
        if name in _ANSWERS:
            self.say(_ANSWERS[name])
        elif name in _COMMANDS:
            getattr(self, _COMMANDS[name])(*numbers)
            self.say("OK")
        else:
            self.say(f"!8 Err: Unknown command '{name}:{ord(name[0]) if name else 0}'")

    def _tell_steps(self) -> None:
        self.say(f"{self.steps[0]},{self.steps[1]}")

    def _tell_power(self) -> None:
        self.say(f"0394,{'0540' if self.powered else '0120'}")

    def _move_pen(self, up: int, milliseconds: int, *_: int) -> None:
        self._lower(up == 0)
        self.milliseconds += milliseconds

    def _power(self, one: int, *_: int) -> None:
        self._enabled = one > 0

    def _forget_steps(self) -> None:
        self.steps, self._counted, self.place = (0, 0), True, self.home

    def _stop(self) -> None:
        self.say("0,0,0,0,0")

    def _configure(self, *_: int) -> None:
        """Where a servo stands is not seen here."""

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
