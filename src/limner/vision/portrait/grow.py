"""Strength and flow of lines go in; long lines along the flow come out, the strongest first and none beside another.

Evenly spaced streamlines (Jobard & Lefer 1997, doi:10.1007/978-3-7091-6876-9_5) that keep to the crests of what is
seen: hair becomes a few strands instead of a mesh, and no line has spurs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from limner.types import Floats
from limner.vision.edges.flow import Flow
from limner.vision.edges.ridges import crests
from limner.vision.raster import Image, whole
from limner.vision.trace import smooth

STEP_PX = 1.5
BEND = float(np.cos(np.deg2rad(35)))
"""A line ends where it would turn more than this in one step."""

PATIENCE = 7
"""Steps over which a line may be invisible and go on."""

CELL_PX, ROUND = 5, 12
"""A line ends where it comes back to a cell of this size more than so many steps later: it goes round in circles."""

LONGEST = 400
"""Steps after which a line ends in any case."""


@dataclass(frozen=True)
class Rule:
    """What becomes a line.

    Attributes:
        low: it goes on while it is stronger than this.
        high: it begins where it is stronger than this.
        shortest: what reaches less far is dropped [px].
        apart: how near to others it may come [px].
        worth: as in ``Mark``.
        smooth: its smoothing, standard deviation along it [px].
    """

    low: float
    high: float
    shortest: float
    apart: float
    worth: float
    smooth: float = 4.0


@dataclass(frozen=True, eq=False)
class Grown:
    """A line and the index of the rule by which most of it was found."""

    line: Floats
    rule: int


class _Field:
    """What a walker sees."""

    def __init__(self, strength: Image, flow: Flow, low: Image, taken: NDArray[np.uint8]) -> None:
        self.height, self.width = strength.shape
        # Single pixels come sooner out of memory than out of arrays, row by row.
        images = (strength, flow.x, flow.y, low, taken)
        self.views = tuple(np.ascontiguousarray(image).ravel().data for image in images)

    def walk(self, x: float, y: float, sign: float) -> list[tuple[float, float]]:
        """The places reached from a seed in one direction, up to the last that was strong enough."""
        strength, flow_x, flow_y, low, taken = self.views
        width, bottom, right = self.width, self.height - 1, self.width - 1
        path: list[tuple[float, float]] = []
        last = 0
        seen: dict[tuple[int, int], int] = {}
        place = round(y) * width + round(x)
        dx, dy = sign * flow_x[place], sign * flow_y[place]
        for step in range(LONGEST):
            x, y = x + STEP_PX * dx, y + STEP_PX * dy
            row, column = round(y), round(x)
            place = row * width + column
            if not (0 < row < bottom and 0 < column < right) or taken[place]:
                break
            tx, ty = flow_x[place], flow_y[place]
            turn = tx * dx + ty * dy
            if abs(turn) < BEND or step - seen.setdefault((row // CELL_PX, column // CELL_PX), step) > ROUND:
                break
            dx, dy = (tx, ty) if turn > 0 else (-tx, -ty)
            # Half a pixel towards the crest, where one side is stronger than the other.
            one = strength[round(y + dx) * width + round(x - dy)]
            other = strength[round(y - dx) * width + round(x + dy)]
            here = strength[place]
            if one > here or other > here:
                side = 0.5 if one > other else -0.5
                x, y = x - side * dy, y + side * dx
            path.append((x, y))
            if here > low[place]:
                last = len(path)
            elif len(path) - last > PATIENCE:
                break
        return path[:last]


def grow(
    strength: Image, flow: Flow, labels: NDArray[np.uint8], rules: Sequence[Rule], drawn: Sequence[tuple[Floats, float]]
) -> list[Grown]:
    """Lines of what is seen, the strongest first.

    Args:
        strength: (H, W) of the dark lines.
        flow: their direction.
        labels: (H, W) which rule holds where.
        rules: by label.
        drawn: lines that are there already, each with the distance to keep from it [px].
    """
    low, high = (np.array([getattr(rule, name) for rule in rules], np.float32)[labels] for name in ("low", "high"))
    taken = np.zeros(strength.shape, np.uint8)
    for line, apart in drawn:
        _occupy(taken, line, apart)
    field = _Field(strength, flow, low, taken)
    rows, columns = np.nonzero(crests(strength, flow.angle_rad) & (strength > high))
    order = np.argsort(-strength[rows, columns], kind="stable")
    found = []
    for row, column in zip(rows[order].tolist(), columns[order].tolist(), strict=True):
        if taken.item(row, column) or not (1 <= row < field.height - 1 and 1 <= column < field.width - 1):
            continue
        ahead, behind = (field.walk(float(column), float(row), sign) for sign in (1.0, -1.0))
        line = np.array([*behind[::-1], (float(column), float(row)), *ahead])
        places = whole(line)
        label = int(np.bincount(labels[places[:, 1], places[:, 0]]).argmax())
        if float(np.hypot(*np.ptp(line, axis=0))) < rules[label].shortest:
            taken[row, column] = 1
            continue
        _occupy(taken, line, rules[label].apart)
        found.append(Grown(smooth(line, rules[label].smooth), label))
    return found


def _occupy(taken: NDArray[np.uint8], line: Floats, apart: float) -> None:
    cv2.polylines(taken, [whole(line)], isClosed=False, color=(1,), thickness=max(1, round(2 * apart)))
