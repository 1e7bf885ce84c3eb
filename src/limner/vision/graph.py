"""A skeleton goes in; its branches from node to node come out, spurs pruned and branches linked where asked.

Two pixels of the skeleton are neighbours if they share a side, or a corner that no third pixel of the skeleton
bridges by sides. A pixel with two neighbours is inside a branch; every other one is a node (an end, a junction or a
single pixel).
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from itertools import combinations, pairwise

import numpy as np
from numpy.typing import NDArray

from limner import geometry
from limner.types import Floats
from limner.vision.chains import join, outward, runs_of


@dataclass(frozen=True, eq=False)
class Branch:
    """A walk over the skeleton.

    Attributes:
        path: (n, 2) pixel centres x, y, both ends included; one point for a single pixel; first = last for a loop.
        nodes: where it starts and ends; the same number twice for a loop.
    """

    path: Floats
    nodes: tuple[int, int]


def branches_of(skeleton: NDArray[np.bool_]) -> list[Branch]:
    """Split a skeleton into branches.

    Every pixel that is no node lies inside exactly one branch, exactly once; a node is an end of each branch that
    meets there; every pair of neighbours is walked exactly once.

    Args:
        skeleton: (H, W) bool, one pixel wide.
    """
    rows, columns = np.nonzero(skeleton)
    centres = np.stack([columns, rows], axis=1).astype(np.float64)
    return [Branch(centres[walk], (walk[0], walk[-1])) for walk in _walks(_neighbours(skeleton))]


def _neighbours(skeleton: NDArray[np.bool_]) -> list[list[int]]:
    """The neighbours of every pixel of the skeleton, pixels counted in raster order."""
    framed = np.pad(skeleton, 1)
    width = framed.shape[1]
    pixels = np.flatnonzero(framed)
    number = np.full(framed.size, -1)
    number[pixels] = np.arange(len(pixels))
    right, left, below, below_right, below_left = (
        number[pixels + step] for step in (1, -1, width, width + 1, width - 1)
    )
    below_right[(below >= 0) | (right >= 0)] = -1
    below_left[(below >= 0) | (left >= 0)] = -1
    pairs = np.concatenate([_pairs(there) for there in (right, below, below_right, below_left)])
    pairs = np.concatenate([pairs, pairs[:, ::-1]])
    pairs = pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]
    ends = np.cumsum(np.bincount(pairs[:, 0], minlength=len(pixels)))
    near = pairs[:, 1].tolist()
    return [near[start:end] for start, end in pairwise([0, *ends.tolist()])]


def _pairs(there: NDArray[np.int64]) -> NDArray[np.int64]:
    """Each pixel with its neighbour ``there``, where it has one."""
    here = np.flatnonzero(there >= 0)
    return np.stack([here, there[here]], axis=1)


def _walks(neighbours: list[list[int]]) -> list[list[int]]:
    inside = [len(near) == 2 for near in neighbours]
    seen = [False] * len(neighbours)
    walks = [[node] for node, near in enumerate(neighbours) if not near]
    for node, near in enumerate(neighbours):
        if inside[node]:
            continue
        for first in near:
            if not seen[first] and (inside[first] or node < first):
                walks.append(_walk(node, first, neighbours, inside, seen))
    for pixel in range(len(neighbours)):
        if inside[pixel] and not seen[pixel]:
            walks.append(_walk(pixel, neighbours[pixel][0], neighbours, inside, seen))
    return walks


def _walk(start: int, first: int, neighbours: list[list[int]], inside: list[bool], seen: list[bool]) -> list[int]:
    """From a node, or from anywhere in a loop, to the next node, or once around."""
    walk = [start, first]
    while inside[walk[-1]] and walk[-1] != start:
        here, before = walk[-1], walk[-2]
        seen[here] = True
        one, other = neighbours[here]
        walk.append(other if one == before else one)
    seen[start] = inside[start]
    return walk


def prune_spurs(branches: list[Branch], shorter_than: float) -> list[Branch]:
    """Drop side branches that end free, the shortest first, as long as a junction is left under them.

    What was split by a pruned spur alone is one branch again, and may be a spur itself.

    Args:
        branches: of a skeleton.
        shorter_than: length of a spur [px]; 0 keeps all.
    """
    while spurs := _spurs(branches, shorter_than):
        branches = through_nodes([branch for i, branch in enumerate(branches) if i not in spurs], None)
    return branches


def _spurs(branches: list[Branch], shorter_than: float) -> set[int]:
    meeting = Counter(node for branch in branches for node in branch.nodes)
    lengths = [geometry.length(branch.path) for branch in branches]
    spurs = set()
    for i in sorted(range(len(branches)), key=lengths.__getitem__):
        free, rooted = sorted(branches[i].nodes, key=meeting.__getitem__)
        if lengths[i] < shorter_than and meeting[free] == 1 and meeting[rooted] >= 3:
            spurs.add(i)
            meeting[rooted] -= 1
    return spurs


def through_nodes(branches: list[Branch], bend_deg: float | None) -> list[Branch]:
    """Link branches that go on into each other: where only two meet, and at junctions the straightest pairs.

    Args:
        branches: of a skeleton.
        bend_deg: the largest bend at a junction [deg]; None links none there.
    """
    ends: dict[int, list[int]] = {}
    for i, branch in enumerate(branches):
        ends.setdefault(branch.nodes[0], []).append(2 * i)
        ends.setdefault(branch.nodes[1], []).append(2 * i + 1)
    pairs = []
    for meeting in ends.values():
        if len(meeting) == 2:
            pairs.append((meeting[0], meeting[1]))
        elif bend_deg is not None and len(meeting) > 2:
            pairs += _straightest([branches[end // 2].path for end in meeting], meeting, np.deg2rad(bend_deg))
    runs = runs_of(len(branches), pairs)
    return [
        Branch(path, (branches[run[0] // 2].nodes[run[0] % 2], branches[run[-1] // 2].nodes[1 - run[-1] % 2]))
        for run, path in zip(runs, join([branch.path for branch in branches], runs), strict=True)
    ]


def _straightest(paths: list[Floats], ends: list[int], bend_rad: float) -> list[tuple[int, int]]:
    """Pairs of ends at one junction, each at most once, the smallest bend first."""
    inward = np.array([-outward(path, end % 2 == 1) for path, end in zip(paths, ends, strict=True)])
    bends = np.arccos(np.clip(-inward @ inward.T, -1, 1))
    pairs: list[tuple[int, int]] = []
    used: set[int] = set()
    for i, j in sorted(combinations(range(len(ends)), 2), key=bends.__getitem__):
        if bends[i, j] <= bend_rad and not used & {i, j}:
            used |= {i, j}
            pairs.append((ends[i], ends[j]))
    return pairs
