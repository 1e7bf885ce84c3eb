"""What a machine that draws has to offer, whichever it is: lines in millimetres go in, ink on paper comes out."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from limner.errors import DeviceFailed
from limner.types import Floats, JointTrajectory


class NotConnected(DeviceFailed):
    """There is no way to the machine: it was told nothing, and nobody needs to ask where its pen is."""


class Device(Protocol):
    """A machine that can be begun and ended with."""

    name: str

    def open(self) -> None:
        """Make sure that the right machine answers, and find out or settle where it is.

        Raises:
            DeviceFailed: another machine answers, or none.
        """

    def home(self) -> None:
        """Go home, the pen raised, and wait until it is there."""

    def abort(self) -> bool:
        """Stop at once and raise the pen, after anything has gone wrong; never raises.

        Returns:
            Whether the pen is known to be up.
        """

    def close(self) -> None:
        """Let go of the machine."""


class Target(Device, Protocol):
    """A machine that draws lines, or a fake of one. It opens with its pen raised, and takes where it is for home."""

    def draw(self, line_mm: Floats, going_on: Callable[[], bool]) -> int:
        """Travel to a line's first point, lower the pen, draw, raise it, and wait until that is done.

        Args:
            line_mm: (n, 2), page frame; a single point is a dot.
            going_on: asked wherever the machine can stop within a line.

        Returns:
            Index of the point at which the pen was raised: n - 1, or less when it was not to go on; everything up to
            there is drawn and nothing beyond.

        Raises:
            DeviceFailed: the machine did not do as told; what is drawn of the line is not known.
        """


class Route(Protocol):
    """Checked motions of an arm, each from rest to rest with the pen up."""

    def stroke(self, index: int) -> JointTrajectory:
        """Along a stroke."""

    def to_stroke(self, q: Floats, index: int) -> JointTrajectory:
        """From joint positions to where a stroke begins."""

    def home(self, index: int) -> JointTrajectory:
        """From where a stroke begins to the end."""

    def lift(self, q: Floats) -> JointTrajectory:
        """From joint positions anywhere, at rest, straight up along the pen.

        Raises:
            LimnerError: there is no such motion within the limits.
        """

    def tips(self, q: Floats) -> Floats:
        """(n, 3) where the pen's tip is [m]."""


class Arm(Device, Protocol):
    """An arm that is led along checked motions."""

    def draw(self, index: int, stopping: Callable[[], bool]) -> bool:
        """Go to a stroke if the arm is not there, and draw it.

        Args:
            index: of the stroke.
            stopping: asked wherever the arm can stop.

        Returns:
            Whether the stroke is drawn; else the arm was stopped, the pen up.

        Raises:
            DeviceFailed: it did not do as told.
        """
