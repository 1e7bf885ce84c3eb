"""Strokes side by side go in; the same drawn to and fro, in a few long ones, come out."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from limner import geometry
from limner.types import Floats
from limner.vision.raster import Image, whole

BACK = -0.5
"""A stroke is gone on with by one that leads back: the cosine between the ways is at most this."""

SLANT = 8.0
"""A stroke that is moved at its end to meet the next begins to lean so many times the move before."""


def to_and_fro(lines: Sequence[Floats], reach: Image) -> list[Floats]:
    """Join strokes at their ends as a hand does that hatches without lifting the pen.

    Args:
        lines: (n, 2) strokes that do not cross [px].
        reach: (H, W) how far from there an end may be that is gone on with [px]; 0 where no way leads.

    Returns:
        The strokes, each given one in just one of them. Where two were joined their ends meet in one point.
    """
    left = dict(enumerate(lines))
    joined = []
    while left:
        line = left.pop(next(iter(left)))
        for _ in range(2):
            while (found := _next(line, left, reach)) is not None:
                number, backwards = found
                more = left.pop(number)
                line = _pointed(line, more[::-1] if backwards else more)
            line = line[::-1]
        joined.append(line)
    return joined


def _next(line: Floats, left: dict[int, Floats], reach: Image) -> tuple[int, bool] | None:
    """Which stroke goes on from the end of a line the nearest, and whether from its own end."""
    x, y = np.clip(whole(line[-1]), 0, np.array(reach.shape[::-1]) - 1).tolist()
    best, found = float(reach[y, x]), None
    for number, other in left.items():
        for backwards in (False, True):
            more = other[::-1] if backwards else other
            away = float(np.hypot(*(more[0] - line[-1])))
            if away <= best and _way(line[::-1]) @ _way(more) >= -BACK and _over(line[-1], more[0], reach):
                best, found = away, (number, backwards)
    return found


def _pointed(line: Floats, more: Floats) -> Floats:
    """Two lines as one that turns in a point half-way between their ends."""
    half = (more[0] - line[-1]) / 2
    return np.concatenate([_drawn_to(line[::-1], half)[::-1], _drawn_to(more, -half)[1:]])


def _drawn_to(line: Floats, shift: Floats) -> Floats:
    """A line whose start is moved, and with it the first part of it, less and less."""
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    lean = np.clip(1 - along / (SLANT * max(float(np.hypot(*shift)), 1e-9)), 0, 1)
    moved: Floats = line + lean[:, None] * shift
    return moved


def _way(line: Floats, over: int = 4) -> Floats:
    """The unit vector (2,) into a line from its start."""
    way = line[min(over, len(line) - 1)] - line[0]
    unit: Floats = way / max(float(np.hypot(*way)), 1e-9)
    return unit


def _over(start: Floats, end: Floats, reach: Image) -> bool:
    x, y = whole(geometry.resample(np.stack([start, end]), 1.0)).T
    inside = (x >= 0) & (y >= 0) & (x < reach.shape[1]) & (y < reach.shape[0])
    return bool(inside.all() and (reach[y, x] > 0).all())
