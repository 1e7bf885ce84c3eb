"""Lines and pairs of their ends go in; the lines joined through these pairs come out.

The ends of line i are numbered 2 i (its first point) and 2 i + 1 (its last).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from limner import geometry
from limner.types import Floats

Index = NDArray[np.int64]

TANGENT_PX = 6.0
"""How much of a line tells its direction at an end: longer than a stair of the pixel grid, shorter than an eyelid."""


def outward(line: Floats, last: bool) -> Floats:
    """Direction (2,) of unit length in which a line would go on beyond its first or its last point; 0 for a dot."""
    line = line if last else line[::-1]
    away = np.hypot(*(line[-1] - line).T)
    far = np.flatnonzero(away >= TANGENT_PX)
    start = far[-1] if len(far) else 0
    direction: Floats = (line[-1] - line[start]) / max(float(away[start]), 1e-12)
    return direction


def runs_of(lines: int, pairs: Iterable[tuple[int, int]]) -> list[list[int]]:
    """Follow the pairs from line to line.

    Args:
        lines: how many there are.
        pairs: ends that are joined, each end in at most one pair.

    Returns:
        Runs, each a list of the ends at which its lines are entered; every line is in exactly one.
    """
    partner = {a: b for pair in pairs for a, b in (pair, pair[::-1])}
    used = [False] * lines
    runs = []
    free = [end for end in range(2 * lines) if end not in partner]
    for start in [*free, *range(0, 2 * lines, 2)]:  # what is left when the free ends are used up are rings
        run: list[int] = []
        end: int | None = start
        while end is not None and not used[end // 2]:
            used[end // 2] = True
            run.append(end)
            end = partner.get(end ^ 1)
        if run:
            runs.append(run)
    return runs


def join(lines: Sequence[Floats], runs: Iterable[Sequence[int]]) -> list[Floats]:
    """The lines of each run one after another, turned as entered; a point that two of them share is kept once."""
    joined = []
    for run in runs:
        path = np.concatenate([lines[end // 2] if end % 2 == 0 else lines[end // 2][::-1] for end in run])
        new = np.concatenate([[True], (path[1:] != path[:-1]).any(axis=1)])
        joined.append(path[new])
    return joined


def join_gaps(lines: Sequence[Floats], gap: float, bend_rad: float) -> list[Floats]:
    """Join lines of which two ends face each other over a small gap, the closest first.

    Args:
        lines: open ones are joined, closed ones and dots stay.
        gap: largest distance of two ends, in the unit of the lines.
        bend_rad: largest angle between the gap and the direction of either line.

    Returns:
        The lines, those joined as one; both of its ends may have met, then it is closed.
    """
    open_lines = [line for line in lines if len(line) > 1 and not geometry.is_closed(line)]
    others = [line for line in lines if len(line) == 1 or geometry.is_closed(line)]
    pairs = _facing(open_lines, gap, bend_rad) if open_lines and gap > 0 else []
    runs = runs_of(len(open_lines), pairs)
    joined = join(open_lines, runs)
    met = {frozenset(pair) for pair in pairs}
    for i, run in enumerate(runs):
        if frozenset((run[0], run[-1] ^ 1)) in met:
            joined[i] = np.concatenate([joined[i], joined[i][:1]])
    return [*joined, *others]


def _facing(lines: Sequence[Floats], gap: float, bend_rad: float) -> list[tuple[int, int]]:
    tips = np.array([tip for line in lines for tip in (line[0], line[-1])])
    ways = np.array([outward(line, last) for line in lines for last in (False, True)])
    i, j = _within(tips, gap)
    across = tips[j] - tips[i]
    distance = np.hypot(*across.T)
    across = np.where(distance[:, None] > 0, across / np.maximum(distance, 1e-12)[:, None], ways[i] - ways[j])
    bends = [np.arccos(np.clip((way * across).sum(axis=1), -1, 1)) for way in (ways[i], -ways[j])]
    lengths = np.array([geometry.length(line) for line in lines])
    not_curled = (i // 2 != j // 2) | (lengths[i // 2] > 4 * gap)
    faces = (np.maximum(*bends) <= bend_rad) & not_curled
    order = np.lexsort((j, i, distance * (1 + sum(bends))))
    return _each_once(i[order[faces[order]]], j[order[faces[order]]])


def _within(points: Floats, reach: float) -> tuple[Index, Index]:
    """All pairs of points at most ``reach`` apart, each once, the lower number first."""
    order = np.argsort(points[:, 0], kind="stable")
    x, pairs = points[order, 0], [np.empty((0, 2), np.int64)]
    for shift in range(1, len(points)):
        near = np.flatnonzero(x[shift:] - x[:-shift] <= reach)
        if not len(near):
            break
        pairs.append(np.sort(np.stack([order[near], order[near + shift]], axis=1), axis=1))
    i, j = np.concatenate(pairs).T
    close = np.hypot(*(points[i] - points[j]).T) <= reach
    return i[close], j[close]


def _each_once(i: Index, j: Index) -> list[tuple[int, int]]:
    pairs = []
    used: set[int] = set()
    for a, b in zip(i.tolist(), j.tolist(), strict=True):
        if not used & {a, b}:
            used |= {a, b}
            pairs.append((a, b))
    return pairs
