"""The two ends of every stroke go in; a first tour through all strokes, made of the shortest hops, comes out."""

from __future__ import annotations

import numpy as np

from limner.drawing.neighbours import Index, nearest
from limner.types import Floats

_LOOK_AT = 8


def greedy_tour(ends: Floats) -> list[int]:
    """Join the nearest free ends, again and again, until all strokes hang together (greedy edges).

    Args:
        ends: (2 n, 2) where the tour ends and where it starts, then begin and end of each stroke.

    Returns:
        The ends in the order of the tour, two for each stroke, 0 and 1 first.
    """
    hop = [-1] * len(ends)
    tip = [end ^ 1 for end in range(len(ends))]
    free = np.arange(len(ends))
    while len(free) > 2:
        joined = False
        for a, b in _short_hops(ends, free):
            if hop[a] < 0 and hop[b] < 0 and tip[a] != b:
                hop[a], hop[b] = b, a
                far, other = tip[a], tip[b]
                tip[far], tip[other] = other, far
                joined = True
        free = np.array([end for end in free.tolist() if hop[end] < 0])
        if not joined:
            _join_in_row(free.tolist(), hop, tip)
            break
    return _walk(hop)


def _short_hops(ends: Floats, free: Index) -> list[tuple[int, int]]:
    """Pairs of free ends that are near each other, the shortest first."""
    near = free[nearest(ends[free], _LOOK_AT)]
    a = np.repeat(free, near.shape[1])
    b = near.ravel()
    low, high = np.minimum(a, b), np.maximum(a, b)
    keep = low // 2 != high // 2
    low, high = low[keep], high[keep]
    gap = np.hypot(*(ends[low] - ends[high]).T)
    order = np.lexsort((high, low, gap))
    return list(zip(low[order].tolist(), high[order].tolist(), strict=True))


def _join_in_row(free: list[int], hop: list[int], tip: list[int]) -> None:
    """Hang what is left together as it comes: so many ends lie on one spot that no other is seen from there."""
    seen: set[int] = set()
    last = -1
    for a in free:
        if a in seen:
            continue
        seen |= {a, tip[a]}
        if last >= 0:
            hop[last], hop[a] = a, last
        last = tip[a]


def _walk(hop: list[int]) -> list[int]:
    """From the start over strokes and hops; two ends stay free, and the hop between them closes the tour."""
    free = [end for end in range(len(hop)) if hop[end] < 0]
    after = dict(zip(free, reversed(free), strict=True))
    tour: list[int] = []
    end = 0
    while len(tour) < len(hop):
        tour += [end, end ^ 1]
        end = hop[end ^ 1] if hop[end ^ 1] >= 0 else after[end ^ 1]
    return tour
