"""A line that crosses itself goes in; a shorter one through the same points that does not comes out."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from limner.drawing.join import near_pairs
from limner.types import Floats

_LEAST_GAIN = 1e-12


def uncrossed(line: Floats) -> Floats:
    """Turn a stretch of the line round wherever two of its segments meet, until none do.

    Each turn makes the line shorter, as two sides of a quadrilateral are shorter than its diagonals, so it ends.

    Args:
        line: (n, 2), no two points the same.

    Returns:
        The same points in another order, first and last where they were.
    """
    line = line.copy()
    while True:
        turned_to = -1
        for i, j in _meeting(line):
            a, b, c, d = line[i], line[i + 1], line[j], line[j + 1]
            # What lies in a stretch that was turned has other neighbours now: the next look finds it.
            if i > turned_to and _gain(a, b, c, d) > _LEAST_GAIN:
                line[i + 1 : j + 1] = line[i + 1 : j + 1][::-1].copy()
                turned_to = j
        if turned_to < 0:
            return line


def _gain(a: Floats, b: Floats, c: Floats, d: Floats) -> float:
    """What is saved by a-c and b-d in place of a-b and c-d."""
    return float(np.hypot(*(a - b)) + np.hypot(*(c - d)) - np.hypot(*(a - c)) - np.hypot(*(b - d)))


def _meeting(line: Floats) -> list[tuple[int, int]]:
    """Pairs of segments i < j that are not neighbours and cross or touch."""
    if len(line) < 4:
        return []
    a, b = line[:-1], line[1:]
    first, second = _close(a, b)
    apart = second - first > 1
    first, second = first[apart], second[apart]
    p, q, r, s = a[first], b[first], a[second], b[second]
    across = (_side(p, q, r) * _side(p, q, s) <= 0) & (_side(r, s, p) * _side(r, s, q) <= 0)
    # On one straight line all sides are 0: they meet only where their boxes do.
    boxes = (np.maximum(p, q) >= np.minimum(r, s)).all(axis=1) & (np.maximum(r, s) >= np.minimum(p, q)).all(axis=1)
    return sorted(zip(first[across & boxes].tolist(), second[across & boxes].tolist(), strict=True))


def _side(a: Floats, b: Floats, c: Floats) -> Floats:
    """On which side (n,) of a-b the points c lie: the sign."""
    side: Floats = np.sign((b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0]))
    return side


def _close(a: Floats, b: Floats) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Pairs i < j of segments from a to b (n, 2) that can meet: short ones by their middles, long ones with all."""
    middle, length = (a + b) / 2, np.hypot(*(b - a).T)
    usual = 3 * float(np.median(length))
    first, second = near_pairs(middle, usual)
    low, high = np.minimum(a, b), np.maximum(a, b)
    pairs = [np.stack([first, second], axis=1)]
    for k in np.flatnonzero(length > usual):
        near = np.flatnonzero((low <= high[k]).all(axis=1) & (high >= low[k]).all(axis=1))
        pairs.append(np.stack([np.minimum(near, k), np.maximum(near, k)], axis=1))
    found = np.unique(np.concatenate(pairs), axis=0)
    return found[:, 0], found[:, 1]
