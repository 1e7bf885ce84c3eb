"""What the parts of the portrait hand on: a line, what it draws and how much it matters."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from limner.types import Floats
from limner.vision.splines import natural_spline


@dataclass(frozen=True, eq=False)
class Mark:
    """A line of the portrait.

    Attributes:
        line: (n, 2) [px].
        region: one of ``types.REGIONS``.
        worth: how much a piece of it matters against one of another mark of the region.
    """

    line: Floats
    region: str
    worth: float = 1.0


def curve(points: Floats) -> Floats:
    """A smooth line (m, 2) through points (n, 2), vertices about two pixels apart."""
    return natural_spline(points).line(2.0)


def taken(points: Floats, start: float, end: float) -> Floats:
    """The part of a line from one share of its length to another."""
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    total = max(along[-1], 1e-9)
    inner = (along > start * total) & (along < end * total)
    ends = [[np.interp(share * total, along, points[:, axis]) for axis in (0, 1)] for share in (start, end)]
    return np.concatenate([ends[:1], points[inner], ends[1:]])


def runs(kept: NDArray[np.bool_]) -> list[NDArray[np.int64]]:
    """The indices of each unbroken run of true values."""
    borders = np.flatnonzero(np.diff(kept.astype(np.int8))) + 1
    return [run for run in np.split(np.arange(len(kept)), borders) if len(run) and kept[run[0]]]
