"""Directions and wanted spacings go in; evenly spaced strokes along the directions come out."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from limner.types import Floats
from limner.vision.raster import Image, whole

STEP_PX = 2.0
"""Length of a stroke's smallest part."""

CLOSEST = 0.6
"""A stroke ends where it comes nearer to another than this share of the spacing; none begins within all of it."""

LARGEST_TURN = 2.6
"""A stroke that has turned by more than this [rad] ends: it would close a ring."""

GOLDEN = 0.6180339887498949
"""Multiples of it, less their whole part, are spread evenly: chance that is the same every time."""


@dataclass(frozen=True, eq=False)
class Ground:
    """What the strokes are laid on.

    Attributes:
        cos, sin: (H, W) direction of the strokes; a direction and its opposite are one.
        spacing: (H, W) wanted between neighbours [px]; 0 where no stroke goes.
        fade: (H, W) from 0, where some strokes end already, to 1, where all go on.
        area: (H, W) uint8; a stroke stays within the area it began in.
    """

    cos: Image
    sin: Image
    spacing: Image
    fade: Image
    area: NDArray[np.uint8]


def streamlines(ground: Ground, drawn: Sequence[Floats], shortest_px: float) -> list[Floats]:
    """Strokes of even distance (Jobard & Lefer 1997, doi:10.1007/978-3-7091-6876-9_5), the densest places first.

    Args:
        ground: what they are laid on.
        drawn: lines from which they keep away as from each other.
        shortest_px: shorter ones are left out.

    Returns:
        Polylines (n, 2) [px].
    """
    layer = _Layer(ground, shortest_px)
    for line in drawn:
        layer.occupy(line)
    for x, y in _seeds(ground.spacing):
        queue = deque([(x, y)])
        while queue:
            stroke = layer.grow(*queue.popleft())
            if stroke is not None:
                queue.extend(layer.beside(stroke))
    return layer.lines


def _seeds(spacing: Image) -> list[tuple[float, float]]:
    """A grid of places, the densest first."""
    rows, columns = np.nonzero(spacing[::3, ::3])
    rows, columns = 3 * rows, 3 * columns
    order = np.argsort(np.rint(spacing[rows, columns]), kind="stable")
    return list(zip(columns[order].astype(float).tolist(), rows[order].astype(float).tolist(), strict=True))


class _Layer:
    """Strokes laid so far, and what room they leave."""

    def __init__(self, ground: Ground, shortest_px: float) -> None:
        self.lines: list[Floats] = []
        self._ground, self._shortest = ground, shortest_px
        self._near, self._close = (np.zeros(ground.spacing.shape[:2], np.uint8) for _ in range(2))
        self._size = ground.spacing.shape[:2]
        # Single values are read through their buffers: several times as fast as through the arrays.
        self._cos, self._sin = ground.cos.data, ground.sin.data
        self._fade, self._area = ground.fade.data, ground.area.data
        self._spacing, self._taken = ground.spacing.data, self._close.data

    def grow(self, x: float, y: float) -> Floats | None:
        """The stroke through a place, laid; None where there is no room for one."""
        height, width = self._size
        column, row = round(x), round(y)
        if not (0 <= column < width and 0 <= row < height) or self._near[row, column] or not self._spacing[row, column]:
            return None
        end_at = (len(self.lines) + 1) * GOLDEN % 1
        back, ahead = (self._walk(x, y, sign, end_at) for sign in (-1.0, 1.0))
        points = [*back[::-1], (x, y), *ahead]
        if (len(points) - 1) * STEP_PX < self._shortest:
            self._near[row, column] = 1
            return None
        line = np.array(points)
        self.lines.append(line)
        self.occupy(line)
        return line

    def _walk(self, x: float, y: float, sign: float, end_at: float) -> list[tuple[float, float]]:
        """Places from here on one way, until the tone, the area or the room ends."""
        height, width = self._size
        column, row = round(x), round(y)
        area = self._area[row, column]
        dx, dy = sign * self._cos[row, column], sign * self._sin[row, column]
        points: list[tuple[float, float]] = []
        turned = 0.0
        while True:
            x, y = x + STEP_PX * dx, y + STEP_PX * dy
            column, row = round(x), round(y)
            if not (0 <= column < width and 0 <= row < height) or self._area[row, column] != area:
                return points
            if self._taken[row, column] or not self._spacing[row, column] or self._fade[row, column] < end_at:
                return points
            points.append((x, y))
            cos, sin = self._cos[row, column], self._sin[row, column]
            if cos * dx + sin * dy < 0:
                cos, sin = -cos, -sin
            turned += dx * sin - dy * cos
            if abs(turned) > LARGEST_TURN:
                return points
            dx, dy = cos, sin

    def occupy(self, line: Floats) -> None:
        """Keep the room around a line free, as much as is wanted there."""
        height, width = self._size
        parts = line[:: max(1, min(3, len(line) - 1))]
        parts = np.concatenate([parts, line[-1:]])
        at = np.clip(whole(parts), 0, [width - 1, height - 1])
        wanted = self._ground.spacing[at[:, 1], at[:, 0]].tolist()
        for a, b, one, other in zip(at[:-1].tolist(), at[1:].tolist(), wanted[:-1], wanted[1:], strict=True):
            spacing = max(one, other)
            cv2.line(self._near, a, b, (1,), max(1, round(2 * spacing - 1)))
            cv2.line(self._close, a, b, (1,), max(1, round(2 * CLOSEST * spacing - 1)))

    def beside(self, line: Floats) -> list[tuple[float, float]]:
        """Places left and right of a line where its neighbours may run."""
        height, width = self._size
        places: list[tuple[float, float]] = []
        for k in range(0, len(line), 4):
            x, y = line[k].tolist()
            column, row = min(max(round(x), 0), width - 1), min(max(round(y), 0), height - 1)
            away = self._spacing[row, column] + 1.0
            across = -self._sin[row, column] * away, self._cos[row, column] * away
            places += [(x + across[0], y + across[1]), (x - across[0], y - across[1])]
        return places
