"""Strokes with their weights go in; what each of them adds to those already there comes out."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from limner import geometry
from limner.types import Drawing, Floats

Index = NDArray[np.int64]

_FULL = 1 - np.exp(-1)


class Coverage:
    """Ink that is worth less the more there is already around it.

    Each stroke lays its weight, spread along its length, into the cells of a grid. What a cell is worth rises with
    what lies in it ever more slowly, as 1 - exp(-load / scale), the scale being the most that one stroke brings there:
    a lone stroke is worth about its weight, the second of two that run side by side a third of it. So the worth of a
    set of strokes is monotone and submodular (saturated coverage: Lin & Bilmes 2011, aclanthology P11-1052).

    Args:
        drawing: all strokes that may be taken.
        cell_mm: strokes nearer than this share their worth.

    Attributes:
        load: (cells,) of what was taken.
    """

    def __init__(self, drawing: Drawing, cell_mm: float) -> None:
        stroke, cell, share = _deposits(drawing, cell_mm)
        self.cell, self.share = cell, share
        self.starts = np.searchsorted(stroke, np.arange(len(drawing.lines_mm) + 1)).tolist()
        self.scale = np.zeros(int(cell.max(initial=-1)) + 1)
        np.maximum.at(self.scale, cell, share)
        self.scale[self.scale == 0] = 1.0
        self.load = np.zeros(len(self.scale))

    def gain(self, stroke: int) -> float:
        """What taking the stroke now would add."""
        part = slice(self.starts[stroke], self.starts[stroke + 1])
        cells = self.cell[part]
        scale = self.scale[cells]
        less = np.exp(-self.load[cells] / scale)
        return float((scale * less * -np.expm1(-self.share[part] / scale)).sum() / _FULL)

    def take(self, stroke: int) -> None:
        """Count the stroke as drawn."""
        part = slice(self.starts[stroke], self.starts[stroke + 1])
        self.load[self.cell[part]] += self.share[part]

    def worth(self) -> float:
        """Of all that was taken: the sum of the gains."""
        return float((self.scale * -np.expm1(-self.load / self.scale)).sum() / _FULL)


def _deposits(drawing: Drawing, cell_mm: float) -> tuple[Index, Index, Floats]:
    """What each stroke brings to which cell: stroke (sorted), cell, share of the weight; cells numbered from 0."""
    parts = [geometry.resample(line, cell_mm) for line in drawing.lines_mm]
    sizes = np.array([len(part) for part in parts], np.int64)
    if not len(sizes):
        return np.empty(0, np.int64), np.empty(0, np.int64), np.empty(0)
    points = np.concatenate(parts) / cell_mm
    stroke = np.repeat(np.arange(len(sizes)), sizes)
    weight = np.repeat(drawing.weight / sizes, sizes)
    corner = np.floor(points)
    fraction = points - corner
    place = (corner - corner.min(axis=0)).astype(np.int64)
    width = int(place[:, 1].max()) + 2
    cells, shares = [], []
    # Shared out among the four cells around, so that nothing hangs on where the grid lies.
    for dx in (0, 1):
        for dy in (0, 1):
            cells.append((place[:, 0] + dx) * width + place[:, 1] + dy)
            shares.append(weight * np.abs(1 - dx - fraction[:, 0]) * np.abs(1 - dy - fraction[:, 1]))
    number = np.unique(np.concatenate(cells), return_inverse=True)[1]
    count = int(number.max()) + 1
    pair, which = np.unique(np.tile(stroke, 4) * count + number, return_inverse=True)
    total = np.bincount(which, weights=np.concatenate(shares)).astype(np.float64)
    return pair // count, pair % count, total
