"""Points go in; for each of them its nearest other points come out, in linear memory."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from limner.types import Floats

Index = NDArray[np.int64]

_FEW = 300
_AT_ONCE = 1_000_000
_FINEST = 2**24
_CROWD = 32
"""The most points of one cell of the finest grid that are looked at: more are on one spot."""


def nearest(points: Floats, count: int) -> Index:
    """The nearest other points of each point, the nearest first.

    A grid is laid over the points again and again, each time twice as coarse, until every point has found enough
    neighbours within the width of a cell: crowded places are done by the fine grids, lonely points by the coarse.

    Args:
        points: (n, 2).
        count: how many neighbours; fewer when there are not so many other points.

    Returns:
        (n, min(count, n - 1)) indices; exact but where more than ``_CROWD`` points share a cell of the finest grid.
    """
    n = len(points)
    count = min(count, n - 1)
    if n <= _FEW:
        gap = np.hypot(*(points[:, None] - points[None]).transpose(2, 0, 1))
        np.fill_diagonal(gap, np.inf)
        return np.argsort(gap, axis=1, kind="stable")[:, :count]
    found = np.empty((n, count), np.int64)
    corner = points.min(axis=0)
    size = max(float(np.ptp(points, axis=0).max()), 1e-9)
    cell, crowd, todo = _finest(points - corner, size), _CROWD, np.arange(n)
    while len(todo):
        todo = _Grid(points - corner, cell, crowd, whole=cell > size).search(todo, count, found)
        cell, crowd = cell * 2, n
    return found


def _finest(points: Floats, size: float) -> float:
    """A cell so small that none is crowded, unless its points are all but one."""
    cell = size / 2 ** int(np.log2(len(points)) / 2)
    while cell > size / _FINEST:
        row, column = (points // cell).astype(np.int64).T
        if np.unique(row * (int(size / cell) + 2) + column, return_counts=True)[1].max() <= _CROWD:
            break
        cell /= 2
    return float(cell)


class _Grid:
    """Points sorted by the square cell they lie in; ``whole`` when one cell holds them all."""

    def __init__(self, points: Floats, cell: float, crowd: int, whole: bool) -> None:
        self.x, self.y = np.ascontiguousarray(points.T)
        self.reach = np.inf if whole else cell
        place = (points // cell).astype(np.int64) + 1
        stride = int(place[:, 1].max()) + 3
        key = place @ np.array([stride, 1])
        self.order = np.argsort(key, kind="stable")
        around = np.array([dx * stride + dy for dx in (-1, 0, 1) for dy in (-1, 0, 1)])
        cells = key[:, None] + around
        self.first = np.searchsorted(key[self.order], cells)
        sizes = np.searchsorted(key[self.order], cells, side="right") - self.first
        self.sizes = np.minimum(sizes, crowd)
        # In a crowd each point looks at those around it in the row, or all would know the same few.
        rank = np.empty(len(points), np.int64)
        rank[self.order] = np.arange(len(points))
        skipped = rank[:, None] - self.first - crowd // 2
        self.first += np.clip(skipped, 0, sizes - self.sizes)

    def search(self, rows: Index, count: int, found: Index) -> Index:
        """Write the neighbours of those points that have enough of them in reach; the others are returned."""
        load = np.cumsum(self.sizes[rows].sum(axis=1)) // _AT_ONCE
        parts = np.split(rows, np.flatnonzero(np.diff(load)) + 1)
        return np.concatenate([self._search(part, count, found) for part in parts])

    def _search(self, rows: Index, count: int, found: Index) -> Index:
        sizes = self.sizes[rows].ravel()
        ends = np.cumsum(sizes)
        within = np.arange(ends[-1]) - np.repeat(ends - sizes, sizes)
        other = self.order[np.repeat(self.first[rows].ravel(), sizes) + within]
        query = np.repeat(np.arange(len(rows)), self.sizes[rows].sum(axis=1))
        here = rows[query]
        gap = np.hypot(self.x[here] - self.x[other], self.y[here] - self.y[other])
        keep = np.flatnonzero((gap <= self.reach) & (other != here))
        for closer in (2, 4):
            # Who has enough neighbours nearby needs none beyond, and to sort is what takes long.
            near = gap[keep] <= self.reach / closer
            served = np.bincount(query[keep[near]], minlength=len(rows)) >= count
            keep = keep[near | ~served[query[keep]]]
        query, other, gap = query[keep], other[keep], gap[keep]
        order = np.lexsort((other, gap, query))
        query, other = query[order], other[order]
        many = np.bincount(query, minlength=len(rows))
        enough = np.flatnonzero(many >= count)
        starts = np.cumsum(many) - many
        found[rows[enough]] = other[starts[enough, None] + np.arange(count)]
        return rows[many < count]
