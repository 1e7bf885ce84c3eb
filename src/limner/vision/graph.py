"""A skeleton goes in; its branches from node to node come out, spurs pruned and branches linked where asked.

Two pixels of the skeleton are neighbours if they share a side, or a corner that no third pixel of the skeleton
bridges by sides. A pixel with two neighbours is inside a branch; every other one is a node (an end, a junction or a
single pixel).
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from limner import geometry
from limner.types import Floats
from limner.vision.chains import join, outward, runs_of

_MOST_TRIED = 8


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
    """Pairs of ends at one junction, each at most once: those that together save most of the turning allowed."""
    inward = np.array([-outward(path, end % 2 == 1) for path, end in zip(paths, ends, strict=True)])
    saved = bend_rad - np.arccos(np.clip(-inward @ inward.T, -1, 1))
    return [(ends[i], ends[j]) for i, j in _matched(list(range(len(ends))), saved)[1]]


def _matched(left: list[int], saved: Floats) -> tuple[float, list[tuple[int, int]]]:
    """The matching that saves most among those left, each of which may stay alone."""
    if len(left) > _MOST_TRIED:  # more never meet in a thinned picture but on purpose
        left = left[:_MOST_TRIED]
    if len(left) < 2:
        return 0.0, []
    first, *others = left
    best = _matched(others, saved)
    for other in others:
        if saved[first, other] >= 0:
            rest = _matched([k for k in others if k != other], saved)
            best = max(best, (rest[0] + float(saved[first, other]), [(first, other), *rest[1]]), key=lambda m: m[0])
    return best


def merge_junctions(branches: list[Branch], near: float) -> list[Branch]:
    """Make one node of junctions that are linked by branches shorter than ``near`` [px]; those branches go."""
    meeting = Counter(node for branch in branches for node in branch.nodes)
    home = {node: node for node in meeting}

    def find(node: int) -> int:
        while home[node] != node:
            node = home[node]
        return node

    tiny = [
        branch
        for branch in branches
        if geometry.length(branch.path) < near and min(meeting[n] for n in branch.nodes) > 2
    ]
    for branch in tiny:
        one, other = map(find, branch.nodes)
        home[max(one, other)] = min(one, other)
    left = [branch for branch in branches if not any(branch is some for some in tiny)]
    return [Branch(branch.path, (find(branch.nodes[0]), find(branch.nodes[1]))) for branch in left]


def cross_bridges(branches: list[Branch], longest: float, bend_deg: float) -> list[Branch]:
    """Let lines that cross at a sharp angle cross: thinned, they run together for a while, over a bridge.

    Where a short branch links two junctions of three branches each, and two branches of the one go straight on as
    two of the other, the bridge goes, and each pair is led through the middle of its own crossing.

    Args:
        branches: of a skeleton.
        longest: length of a bridge [px].
        bend_deg: the largest bend of a line that crosses [deg].
    """
    net = _Net(branches)
    for bridge in sorted(range(len(branches)), key=lambda i: len(branches[i].path)):
        length = geometry.length(net.paths[bridge])
        if length > longest or not net.links_two_crossings(bridge):
            continue
        skip = length / 2 + 2
        (a, b), (c, d) = net.ends_at(bridge)
        pairings = [((a, c), (b, d)), ((a, d), (b, c))]
        bends = [max(_bend_deg(net.paths, pair, skip) for pair in pairing) for pairing in pairings]
        if min(bends) <= bend_deg:
            net.cross(bridge, pairings[int(np.argmin(bends))], skip)
    return net.branches()


class _Net:
    """Branches while their crossings change; end 2 i + side is that side of branch i.

    Attributes:
        paths: of the branches, as they are by now.
    """

    def __init__(self, branches: list[Branch]) -> None:
        self.paths, self._nodes = [branch.path for branch in branches], [list(branch.nodes) for branch in branches]
        self._first = [branch.nodes for branch in branches]
        self._meeting: dict[int, list[int]] = {}
        for i, branch in enumerate(branches):
            for side in (0, 1):
                self._meeting.setdefault(branch.nodes[side], []).append(2 * i + side)
        self._fresh = max(self._meeting, default=0) + 1
        self._gone: set[int] = set()

    def ends_at(self, bridge: int) -> list[list[int]]:
        """What meets a branch at either of its nodes."""
        return [[end for end in self._meeting[node] if end // 2 != bridge] for node in self._first[bridge]]

    def links_two_crossings(self, bridge: int) -> bool:
        """Whether two others meet a branch at each of two nodes, and nothing there has changed yet."""
        u, v = self._first[bridge]
        return u != v and all(len(some) == 2 for some in self.ends_at(bridge)) and not self._touched(u, v)

    def _touched(self, *nodes: int) -> bool:
        ends = [(end, node) for node in nodes for end in self._meeting[node]]
        return any(end // 2 in self._gone or self._nodes[end // 2][end % 2] != node for end, node in ends)

    def cross(self, bridge: int, pairing: tuple[tuple[int, int], tuple[int, int]], skip: float) -> None:
        """Take the bridge out, and lead each pair of ends through a middle of its own."""
        self._gone.add(bridge)
        for one, other in pairing:
            middle = (_inner(self.paths, one, skip)[0] + _inner(self.paths, other, skip)[0]) / 2
            for end in (one, other):
                self.paths[end // 2] = _led_to(self.paths[end // 2], end % 2, skip, middle)
                self._nodes[end // 2][end % 2] = self._fresh
            self._fresh += 1

    def branches(self) -> list[Branch]:
        """Those that are left."""
        left = [i for i in range(len(self.paths)) if i not in self._gone]
        return [Branch(self.paths[i], (self._nodes[i][0], self._nodes[i][1])) for i in left]


def _inner(paths: list[Floats], end: int, skip: float) -> tuple[Floats, Floats]:
    """A point beyond ``skip`` from the end of a line, where the crossing no longer bends it, and the way out there."""
    line = paths[end // 2] if end % 2 == 0 else paths[end // 2][::-1]
    away = np.hypot(*(line - line[0]).T)
    k = int(np.argmax(away >= skip)) if away.max() >= skip else len(line) // 2
    return line[k], outward(line[k:], last=False)


def _bend_deg(paths: list[Floats], pair: tuple[int, int], skip: float) -> float:
    """The larger of the bends on the straight way over a crossing, from one line onto it and off it to the other."""
    (start, leaving), (end, entering) = _inner(paths, pair[0], skip), _inner(paths, pair[1], skip)
    way = (end - start) / max(float(np.hypot(*(end - start))), 1e-9)
    cosine = min(float(leaving @ way), float(-entering @ way))
    return float(np.degrees(np.arccos(np.clip(cosine, -1, 1))))


def _led_to(path: Floats, side: int, skip: float, middle: Floats) -> Floats:
    """A path whose end goes to ``middle`` instead of to the junction; at least its other end stays."""
    line = path if side == 0 else path[::-1]
    away = np.hypot(*(line - line[0]).T)
    far = np.flatnonzero(away >= skip)
    k = int(far[0]) if len(far) else len(line) - 1
    led = np.concatenate([middle[None], line[k:]])
    return led if side == 0 else led[::-1]
