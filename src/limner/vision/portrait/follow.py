"""A curve that is about right goes in, the line of the photo that it means comes out: moved as a whole, then bent."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from limner import geometry
from limner.types import Floats
from limner.vision.edges.flow import Flow
from limner.vision.portrait.marks import runs
from limner.vision.portrait.seen import Seen
from limner.vision.raster import Image
from limner.vision.trace import smooth

STEP_PX = 2.0
"""From station to station along a curve."""


@dataclass(frozen=True)
class Manner:
    """How a line is followed.

    Attributes:
        stiff: what a change of the offset from the curve by a pixel costs, from station to station.
        pull: what an offset by the whole reach costs at each station.
        smooth_px: smoothing of the line found, standard deviation along it.
        broad: its direction is looked up over a wider neighbourhood.
    """

    stiff: float = 0.02
    pull: float = 0.03
    smooth_px: float = 2.5
    broad: bool = False


@dataclass(frozen=True, eq=False)
class Found:
    """A line found near a curve.

    Attributes:
        line: (n, 2) [px].
        strength: (n,) what was seen of it at each point.
    """

    line: Floats
    strength: Floats

    def parts(self, least: float, gap: float, shortest: float) -> list[Floats]:
        """Where it was seen, gaps up to ``gap`` [px] bridged, parts shorter than ``shortest`` [px] left out."""
        joined: list[list[int]] = []
        for run in runs(self.strength >= least):
            if joined and (run[0] - joined[-1][1]) * STEP_PX <= gap:
                joined[-1][1] = int(run[-1])
            else:
                joined.append([int(run[0]), int(run[-1])])
        return [self.line[a : b + 1] for a, b in joined if (b - a) * STEP_PX >= shortest]


def normals(line: Floats, over: int = 2) -> Floats:
    """Unit vectors (n, 2) to the right of a line that is walked (y down): its direction turned by a quarter."""
    ahead = np.concatenate([line[over:], np.repeat(line[-1:], over, axis=0)])
    behind = np.concatenate([np.repeat(line[:1], over, axis=0), line[:-over]])
    way = ahead - behind
    way = way / np.maximum(np.hypot(*way.T), 1e-9)[:, None]
    return np.stack([-way[:, 1], way[:, 0]], axis=1)


def reward(seen: Seen, image: Image, flow: Flow, points: Floats, across: Floats) -> Floats:
    """Strength of the lines at points (n, k, 2) as far as they run along a curve with normals (n, 2)."""
    cross = seen.at(flow.x, points) * across[:, None, 0] + seen.at(flow.y, points) * across[:, None, 1]
    length = np.hypot(seen.at(flow.x, points), seen.at(flow.y, points))
    aligned = 1 - (cross / np.maximum(length, 1e-6)) ** 2
    answer: Floats = seen.at(image, points) * np.maximum(aligned, 0) ** 2
    return answer


def settle(seen: Seen, curves: list[Floats], reach: float, image: Image) -> Floats:
    """The shift (2,) within ``reach`` [px] by which some curves together lie best on the lines seen."""
    stations = [geometry.resample(curve, STEP_PX) for curve in curves]
    points, across = np.concatenate(stations), np.concatenate([normals(line) for line in stations])
    steps = np.arange(-np.floor(reach / 1.5), np.floor(reach / 1.5) + 1) * 1.5
    shifts = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    shifts = shifts[np.hypot(*shifts.T) <= reach]
    answers = reward(seen, image, seen.flow, points[:, None] + shifts, across)
    score = np.sqrt(answers).mean(axis=0) * (1 - 0.35 * (shifts**2).sum(axis=1) / reach**2)
    best: Floats = shifts[score.argmax()]
    return best


def follow(seen: Seen, curve: Floats, reach: float, image: Image, manner: Manner | None = None) -> Found:
    """The strongest line within ``reach`` [px] of a curve that runs along it from end to end, by dynamic programming.

    Args:
        seen: the photo.
        curve: (n, 2) about where the line is.
        reach: how far it may lie aside.
        image: (H, W) strength of lines.
        manner: how freely it bends.
    """
    manner = manner or Manner()
    stations = geometry.resample(curve, STEP_PX)
    across = normals(stations, 3)
    offsets = np.arange(-np.ceil(reach), np.ceil(reach) + 1)
    points = stations[:, None] + offsets[None, :, None] * across[:, None]
    answers = reward(seen, image, seen.broad if manner.broad else seen.flow, points, across)
    chosen = _best_path(np.sqrt(answers) - manner.pull * (offsets / max(reach, 1)) ** 2, manner.stiff)
    rows = np.arange(len(stations))
    line = smooth(points[rows, chosen], manner.smooth_px)
    strength = np.convolve(np.pad(answers[rows, chosen], 2, mode="edge"), np.ones(5) / 5, mode="valid")
    return Found(line, strength)


def _best_path(worth: Floats, stiff: float, most: int = 2) -> NDArray[np.int64]:
    """Column in each row of a table (n, k) with the largest sum, changing by at most ``most`` from row to row."""
    n, k = worth.shape
    total, came = worth[0], np.zeros((n, k), np.int64)
    steps = np.arange(-most, most + 1)
    source = np.arange(k)[:, None] + steps
    outside = (source < 0) | (source >= k)
    source = np.clip(source, 0, k - 1)
    cost = np.where(outside, np.inf, stiff * steps**2)
    for i in range(1, n):
        options = total[source] - cost
        pick = options.argmax(axis=1)
        came[i] = source[np.arange(k), pick]
        total = options[np.arange(k), pick] + worth[i]
    path = np.empty(n, np.int64)
    path[-1] = total.argmax()
    for i in range(n - 1, 0, -1):
        path[i - 1] = came[i, path[i]]
    return path
