"""Polylines: lengths, resampling and simplification of (n, 2) arrays, in whatever unit comes in."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from limner.types import Floats


def length(line: Floats) -> float:
    """Length of a polyline; 0 for a single point."""
    return float(np.hypot(*np.diff(line, axis=0).T).sum())


def total_length(lines: Sequence[Floats]) -> float:
    """Sum of the lengths of polylines."""
    return sum(map(length, lines))


def is_closed(line: Floats) -> bool:
    """Whether a polyline of more than two points ends where it starts."""
    return len(line) > 2 and bool((line[0] == line[-1]).all())


def without_repeats(line: Floats) -> Floats:
    """A polyline without the points that repeat the one before."""
    new = np.ones(len(line), bool)
    new[1:] = (np.diff(line, axis=0) != 0).any(axis=1)
    return line[new]


def resample(line: Floats, step: float) -> Floats:
    """Points along a polyline no farther apart than ``step``, both ends kept."""
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    if along[-1] == 0:
        return line[:1].copy()
    t = np.linspace(0, along[-1], max(2, int(np.ceil(along[-1] / step)) + 1))
    return np.stack([np.interp(t, along, line[:, 0]), np.interp(t, along, line[:, 1])], axis=1)


def distance_to_segments(points: Floats, a: Floats, b: Floats) -> Floats:
    """Distance of points (n, 2) to segments from ``a`` to ``b``, each (2,) or (n, 2): (n,)."""
    ab = b - a
    squared = np.maximum((ab * ab).sum(-1), 1e-300)
    t = np.clip(((points - a) * ab).sum(-1) / squared, 0, 1)
    nearest = a + t[..., None] * ab
    distance: Floats = np.hypot(*(points - nearest).T)
    return distance


def simplify(line: Floats, tolerance: float) -> Floats:
    """Fewer vertices of a polyline, none of the dropped farther than ``tolerance`` from the result.

    Douglas & Peucker 1973 (doi:10.3138/FM57-6770-U75U-7727); ends stay, a closed line stays closed.
    """
    if len(line) < 3:
        return line.copy()
    keep = np.zeros(len(line), bool)
    keep[[0, -1]] = True
    todo = [(0, len(line) - 1)]
    while todo:
        i, j = todo.pop()
        if j - i < 2:
            continue
        distance = distance_to_segments(line[i + 1 : j], line[i], line[j])
        k = int(distance.argmax())
        if distance[k] > tolerance:
            keep[i + 1 + k] = True
            todo += [(i, i + 1 + k), (i + 1 + k, j)]
    return line[keep]
