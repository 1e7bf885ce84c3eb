"""Many lines go in; few long ones, which go on from line to line in smooth turns where it is dark, come out."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from limner.types import Floats
from limner.vision.raster import Image, whole

NEAREST = 30
"""Of each free end so many others are looked at."""

LOOKS = 7
"""Places along a link at which it is seen how dark it is."""

HANDLE = 0.5
"""How far a link goes straight on before it turns, of its length."""

CURVE_POINTS = 7
"""Points of a link between its ends."""


@dataclass(frozen=True)
class Taste:
    """What makes a good link; lengths are pixels.

    Attributes:
        light: how many times its length a link costs where there is no ink, besides its length.
        turn_px: what half a turn costs.
        least_px: worth of the least chain that is drawn.
    """

    light: float
    turn_px: float
    least_px: float


def chained(lines: Sequence[Floats], worth: Floats, ink: Image, most: int, taste: Taste) -> list[Floats]:
    """Join lines until at most so many are left, the cheapest links first.

    A link costs its length, more where it runs over white paper, and its turns. Where it costs more than the lesser
    of the two chains is worth, that chain is left out instead; so is in the end what is worth next to nothing.

    Args:
        lines: (n, 2) each, n > 1 [px].
        worth: (lines,) of a line, in pixels of a link.
        ink: (H, W) from 0, white, to 1, in which a link does not show.
        most: how many lines may be left.
        taste: what links cost.
    """
    chains = _Chains(lines, worth)
    while chains.count > most:
        before = chains.count
        for cost, a, b in _links(chains, ink, taste):
            if chains.count <= most:
                break
            chains.join(a, b, cost)
        if chains.count == before:
            break
    walks = [walk for walk in chains.walks() if chains.worth[walk[0] // 2] >= taste.least_px]
    return [_drawn(lines, walk) for walk in walks]


class _Chains:
    """Lines, of which ends are joined; end 2 k is where line k begins, 2 k + 1 where it ends."""

    def __init__(self, lines: Sequence[Floats], worth: Floats) -> None:
        self.ends = np.array([line[k] for line in lines for k in (0, -1)]).reshape(-1, 2)
        self.outward = np.array([_outward(side) for line in lines for side in (line, line[::-1])]).reshape(-1, 2)
        self.worth: list[float] = worth.tolist()  # at both its ends, of the whole chain
        self.far = [end ^ 1 for end in range(2 * len(lines))]
        self.link: dict[int, int] = {}
        self.dropped: set[int] = set()
        self.count = len(lines)

    def free(self) -> NDArray[np.int64]:
        """Ends that can be joined."""
        return np.array([e for e in range(len(self.ends)) if e not in self.link and e not in self.dropped], np.int64)

    def join(self, a: int, b: int, cost: float) -> None:
        """Join two ends, or leave the lesser chain out; nothing where one is taken by now, or both are of a chain."""
        if self.far[a] == b or any(e in self.link or e in self.dropped for e in (a, b)):
            return
        self.count -= 1
        lesser = min((a, b), key=lambda end: self.worth[end // 2])
        if cost > self.worth[lesser // 2]:
            self.dropped |= {lesser, self.far[lesser]}
            return
        self.link[a], self.link[b] = b, a
        ends = self.far[a], self.far[b]
        total = self.worth[a // 2] + self.worth[b // 2]
        self.far[ends[0]], self.far[ends[1]] = ends[1], ends[0]
        for end in ends:
            self.worth[end // 2] = total

    def walks(self) -> list[list[int]]:
        """The ends at which each chain's lines are entered, in order."""
        walks = []
        seen: set[int] = set()
        for start in self.free().tolist():
            if start in seen:
                continue
            walk, end = [start], start ^ 1
            while end in self.link:
                walk.append(self.link[end])
                end = self.link[end] ^ 1
            seen |= {start, end}
            walks.append(walk)
        return walks


def _outward(line: Floats) -> Floats:
    """Unit direction in which a line would go on beyond its first point."""
    way = line[0] - line[min(3, len(line) - 1)]
    unit: Floats = way / max(float(np.hypot(*way)), 1e-9)
    return unit


def _links(chains: _Chains, ink: Image, taste: Taste) -> list[tuple[float, int, int]]:
    """Links between free ends that are near each other, the cheapest first."""
    free = chains.free()
    places, outward = chains.ends[free], chains.outward[free]
    gaps = np.hypot(*(places[:, None] - places[None]).transpose(2, 0, 1))
    own = np.array([chains.far[end] for end in free.tolist()])
    gaps[free[:, None] == own[None, :]] = np.inf
    np.fill_diagonal(gaps, np.inf)
    near = np.argsort(gaps, axis=1, kind="stable")[:, :NEAREST]
    a, b = np.repeat(np.arange(len(free)), near.shape[1]), near.ravel()
    once = (a < b) | ~(near[b] == a[:, None]).any(axis=1)
    a, b = a[once & np.isfinite(gaps[a, b])], b[once & np.isfinite(gaps[a, b])]
    way = places[b] - places[a]
    gap = np.hypot(*way.T)
    along = way / np.maximum(gap, 1e-9)[:, None]
    turns = _half_turns(outward[a], along) + _half_turns(-along, outward[b])
    t = np.linspace(0, 1, LOOKS)[:, None, None]
    at = np.clip(whole(places[a] + t * way), 0, np.array(ink.shape[::-1]) - 1)
    white = 1 - np.clip(ink[at[..., 1], at[..., 0]], 0, 1).mean(axis=0)
    cost = gap * (1 + taste.light * white) + taste.turn_px * turns
    order = np.lexsort((b, a, cost))
    return list(zip(cost[order].tolist(), free[a[order]].tolist(), free[b[order]].tolist(), strict=True))


def _half_turns(one: Floats, other: Floats) -> Floats:
    """Angle between unit vectors (n, 2), in units of 180 deg."""
    turns: Floats = np.arccos(np.clip((one * other).sum(axis=1), -1, 1)) / np.pi
    return turns


def _drawn(lines: Sequence[Floats], walk: list[int]) -> Floats:
    """The lines of a chain one after the other, with the curves between."""
    parts = [lines[end // 2][::-1] if end % 2 else lines[end // 2] for end in walk]
    drawn = [parts[0]]
    for before, after in itertools.pairwise(parts):
        drawn += [_curve(before, after), after]
    return np.concatenate(drawn)


def _curve(before: Floats, after: Floats) -> Floats:
    """Points (``CURVE_POINTS``, 2) of the cubic Bezier curve that goes on from one line into the next."""
    start, end = before[-1], after[0]
    reach = HANDLE * float(np.hypot(*(end - start)))
    control = np.stack([start, start + reach * _outward(before[::-1]), end + reach * _outward(after), end])
    t = np.linspace(0, 1, CURVE_POINTS + 2)[1:-1, None]
    weights = np.hstack([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3])
    curve: Floats = weights @ control
    return curve
