"""Joint positions as they are reported go in; the lines of ink that the pen has left on the sheet come out."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from limner.motion.arm.paper import Placement
from limner.motion.arm.robot import Robot
from limner.types import Floats

_APART_MM = 0.02


class InkTrail:
    """The ink on one sheet; an ideal pen draws wherever it is on the paper or pressed below it.

    Attributes:
        lines_mm: so far, each (n, 2), paper frame.
    """

    def __init__(self, robot: Robot, placement: Placement) -> None:
        self._robot, self._placement = robot, placement
        self._lines: list[list[Floats]] = []
        self._touches = False

    @property
    def lines_mm(self) -> tuple[Floats, ...]:
        """Lines so far, each (n, 2)."""
        return tuple(np.array(line) for line in self._lines)

    def take(self, positions: Sequence[Floats]) -> Floats:
        """Follow the pen on.

        Args:
            positions: (dof,) each, in the order of time.

        Returns:
            (n, 2, 2) new segments of ink [mm]; a touch without movement is a segment of no length.
        """
        if not len(positions):
            return np.zeros((0, 2, 2))
        tips = self._placement.points_mm(self._robot.forward(np.array(positions))[:, :3, 3])
        segments = [segment for tip in tips if (segment := self._add(tip)) is not None]
        return np.array(segments).reshape(-1, 2, 2)

    def _add(self, tip: Floats) -> Floats | None:
        touched, self._touches = self._touches, bool(tip[2] <= 0)
        if not self._touches:
            return None
        place = tip[:2]
        if not touched:
            self._lines.append([place])
            return np.array([place, place])
        line = self._lines[-1]
        if np.hypot(*(place - line[-1])) < _APART_MM:
            return None
        line.append(place)
        return np.array([line[-2], place])
