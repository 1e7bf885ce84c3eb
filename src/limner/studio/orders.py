"""What is to be drawn by what, what may be done with it in which state, and what is told of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Protocol

from limner.errors import BadInput, LimnerError

COMMANDS = {
    "idle": ("start",),
    "connecting": ("cancel",),
    "running": ("pause", "cancel"),
    "pausing": ("resume", "cancel"),
    "paused": ("resume", "cancel"),
    "cancelling": ("cancel",),
    "cancelled": ("resume", "start", "clear"),
    "done": ("start", "clear"),
    "error": ("resume", "start", "clear"),
    "lost": ("resume", "start", "clear"),
    "interrupted": ("resume", "start", "clear"),
}
"""Every state, and what may be done in it."""

BUSY = ("connecting", "running", "pausing", "paused", "cancelling")


class WrongState(LimnerError):
    """A command that the job's state does not allow."""


class NotThere(BadInput):
    """A name that a visitor has nothing under."""


class Made(Protocol):
    """An order, ready to be drawn: what ``limner send`` has too."""

    @property
    def drawing(self) -> Any:
        """For the journal."""

    @property
    def begins_s(self) -> Any:
        """(strokes,) when each begins, as planned."""

    @property
    def seconds(self) -> float:
        """How long all takes, as planned."""

    @property
    def name(self) -> str:
        """Of the machine."""

    @property
    def ready(self) -> str:
        """What must be so before it begins."""

    @property
    def run(self) -> Callable[..., Any]:
        """Draws with a journal, a control and a watch; where it ended."""


@dataclass(frozen=True)
class Order:
    """What is to be drawn by what.

    Attributes:
        to: address of the machine.
        machine: profile of a plotter, or None for the usual one.
        robot: name of an arm, or None for a plotter.
        settings: tree of the drawing's.
        frame_only: go round the drawing with the pen up.
    """

    to: str
    machine: str | None = None
    robot: str | None = None
    settings: dict[str, Any] = field(default_factory=dict)
    frame_only: bool = False


Make = Callable[[Order, str], Made]
"""From an order and the file of its drawing or motion."""


@dataclass
class Status:
    """What is told of a job; see docs/studio-protocol.md."""

    state: str = "idle"
    target: str = ""
    name: str = ""
    strokes: int = 0
    stroke: int = 0
    share: float = 0.0
    seconds: float = 0.0
    elapsed_s: float = 0.0
    left_s: float = 0.0
    frame_only: bool = False
    error: str | None = None
    said: str = ""
    next_pen: str = ""
