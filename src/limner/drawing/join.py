"""Lines of which some ends meet go in; which of them the pen can draw in one go comes out."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from limner.types import Floats

Chain = list[tuple[int, bool]]
"""Lines to be drawn without lifting the pen: the index of each, and whether it is walked backwards."""


def chains(lines: Sequence[Floats], groups: Sequence[str], reach: float) -> list[tuple[Chain, bool]]:
    """Join lines end to end: the nearest and straightest pairs first, each end once.

    Two ends are joined when they are in the same group and their cost is at most 1. It is bend / 180 deg, plus
    gap / reach, that times 1 more for each 180 deg of turning onto the bridge and off it: ends that touch may bend
    as they like, ends a full reach apart must go straight on, and none goes back.

    Args:
        lines: polylines, in any unit; closed ones and dots stay alone.
        groups: of each line; only lines of one group are joined.
        reach: the widest gap bridged, in the lines' unit.

    Returns:
        Each chain and whether its last end is joined to its first, in the order of their first line.
    """
    loose = [i for i, line in enumerate(lines) if len(line) > 1 and (line[0] != line[-1]).any()]
    if not loose or reach <= 0:
        return [([(i, False)], False) for i in range(len(lines))]
    link = _links(*_ends(lines, loose, reach), [groups[i] for i in loose], reach)
    return _walk(len(lines), loose, link)


def _ends(lines: Sequence[Floats], loose: list[int], reach: float) -> tuple[Floats, Floats]:
    """Position and outward direction of both ends of each loose line: (2 n, 2) each, start before end."""
    both = [line for i in loose for line in (lines[i], lines[i][::-1])]
    positions = np.array([line[0] for line in both])
    outward = np.array([_outward(line, reach) for line in both])
    return positions, outward


def _outward(line: Floats, reach: float) -> Floats:
    """Unit direction out of the line's start, over about ``reach`` so that a single pixel's step does not tell."""
    away = np.hypot(*(line - line[0]).T)
    inner = int(np.argmax(away >= reach)) if away.max() >= reach else int(away.argmax())
    direction: Floats = (line[0] - line[inner]) / away[inner]
    return direction


def _links(positions: Floats, outward: Floats, groups: list[str], reach: float) -> dict[int, int]:
    """Which end is joined to which, both ways."""
    a, b = near_pairs(positions, reach)
    group = np.unique(groups, return_inverse=True)[1]
    same = group[a // 2] == group[b // 2]
    a, b = a[same], b[same]
    cost = _costs(positions[b] - positions[a], outward[a], -outward[b], reach)
    link: dict[int, int] = {}
    for k in np.lexsort((b, a, np.round(cost, 9))):
        i, j = int(a[k]), int(b[k])
        if cost[k] <= 1 and i not in link and j not in link:
            link[i], link[j] = j, i
    return link


def _costs(bridge: Floats, leaving: Floats, entering: Floats, reach: float) -> Floats:
    gap = np.hypot(*bridge.T)
    along = bridge / np.maximum(gap, 1e-12)[:, None]
    turns = _half_turns(leaving, along) + _half_turns(along, entering)
    cost: Floats = _half_turns(leaving, entering) + gap / reach * (1 + turns)
    return cost


def _half_turns(a: Floats, b: Floats) -> Floats:
    """Angle between unit vectors, in units of 180 deg."""
    angle: Floats = np.arccos(np.clip((a * b).sum(axis=1), -1, 1)) / np.pi
    return angle


def near_pairs(points: Floats, radius: float) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Indices a < b of all pairs of points (n, 2) no farther apart than ``radius``."""
    order = np.argsort(points[:, 0], kind="stable")
    x, y = points[order].T
    found_a, found_b = [np.empty(0, np.int64)], [np.empty(0, np.int64)]
    for step in range(1, len(points)):
        near = x[step:] - x[:-step] <= radius
        if not near.any():
            break
        k = np.flatnonzero(near)
        k = k[np.hypot(x[k + step] - x[k], y[k + step] - y[k]) <= radius]
        found_a.append(order[k])
        found_b.append(order[k + step])
    a, b = np.concatenate(found_a), np.concatenate(found_b)
    return np.minimum(a, b), np.maximum(a, b)


def _walk(count: int, loose: list[int], link: dict[int, int]) -> list[tuple[Chain, bool]]:
    slot = {line: k for k, line in enumerate(loose)}
    seen: set[int] = set()
    found: list[tuple[Chain, bool]] = []
    for line in range(count):
        if line in seen:
            continue
        if line not in slot:
            found.append(([(line, False)], False))
            continue
        start, closed = _first_end(2 * slot[line], link)
        chain = _follow(start, link, loose)
        seen.update(i for i, _ in chain)
        found.append((chain, closed))
    return found


def _first_end(end: int, link: dict[int, int]) -> tuple[int, bool]:
    """The free end that is reached backwards from a line's start; that start itself when the chain is a ring."""
    first = end
    while end in link:
        end = link[end] ^ 1
        if end == first:
            return end, True
    return end, False


def _follow(end: int, link: dict[int, int], loose: list[int]) -> Chain:
    chain: Chain = []
    first = end
    while True:
        chain.append((loose[end // 2], bool(end % 2)))
        if (end ^ 1) not in link or link[end ^ 1] == first:
            return chain
        end = link[end ^ 1]
