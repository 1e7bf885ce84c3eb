"""Polylines: lengths, resampling and simplification of (n, 2) arrays, in whatever unit comes in."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from limner.types import Floats


def length(line: Floats) -> float:
    """Length of a polyline; 0 for a single point."""
    step = line[1:] - line[:-1]
    return float(np.hypot(step[:, 0], step[:, 1]).sum())


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
    """Distance of points (..., 2) to segments from ``a`` to ``b`` (..., 2), of shapes that go together: (...)."""
    # Coordinate by coordinate: numpy is slow along an axis of two.
    (x, y), (ax, ay), (bx, by) = ((place[..., 0], place[..., 1]) for place in (points, a, b))
    along_x, along_y = bx - ax, by - ay
    squared = np.maximum(along_x * along_x + along_y * along_y, 1e-300)
    t = np.clip(((x - ax) * along_x + (y - ay) * along_y) / squared, 0, 1)
    distance: Floats = np.hypot(x - (ax + t * along_x), y - (ay + t * along_y))
    return distance


def simplify(line: Floats, tolerance: float) -> Floats:
    """Fewer vertices of a polyline, none of the dropped farther than ``tolerance`` from the result.

    Douglas & Peucker 1973 (doi:10.3138/FM57-6770-U75U-7727); ends stay, a closed line stays closed.
    """
    return simplify_all([line], tolerance)[0]


def simplify_all(lines: Sequence[Floats], tolerance: float) -> list[Floats]:
    """Each of many polylines simplified; all parts of all lines are split together, for most have few vertices."""
    if not lines:
        return []
    points, ends = np.concatenate(lines), np.cumsum([len(line) for line in lines])
    first, last = np.concatenate([[0], ends[:-1]]), ends - 1
    keep = np.zeros(len(points), bool)
    keep[first], keep[last] = True, True
    while len(first := first[(open_ := last - first > 1)]):
        last = last[open_]
        count = last - first - 1
        start = np.cumsum(count) - count
        part = np.repeat(np.arange(len(first)), count)
        inner = np.arange(len(part)) + (first + 1 - start)[part]
        distance = distance_to_segments(points[inner], points[first[part]], points[last[part]])
        farthest = np.maximum.reduceat(distance, start)
        at_most = np.flatnonzero(~(distance < farthest[part]))  # where numbers overflow, too
        split = inner[at_most[np.unique(part[at_most], return_index=True)[1]]]
        far = farthest > tolerance
        first, split, last = first[far], split[far], last[far]
        keep[split] = True
        first, last = np.concatenate([first, split]), np.concatenate([split, last])
    return [part[kept] for part, kept in zip(np.split(points, ends[:-1]), np.split(keep, ends[:-1]), strict=True)]
