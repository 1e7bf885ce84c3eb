"""Score maps of parts and their springs go in, the best score each place can hope for from such a part comes out."""

from __future__ import annotations

import math

import numpy as np

from limner.vision.landmarks.fmp.hog import Array


def spread(scores: Array, stiffness: Array, shift: Array) -> tuple[list[Array], Array]:
    """The generalised distance transform of Felzenszwalb & Huttenlocher 2012 (doi:10.4086/toc.2012.v008a019).

    For each part ``max over v of score(v) - ax (x + kx - vx)^2 - ay (y + ky - vy)^2`` at every cell (x, y), exactly:
    along one axis the parabola ``a e^2`` is the sum of steps ``a, 3 a, 5 a...``, so the maximum over all cells up to
    K away is K times a maximum over the two neighbours. Where neighbours never differ by more than S, a step closer to
    the goal gains more than it loses as soon as ``a (2 e - 1) >= S``, so no best cell is farther than the last step
    below S.

    Args:
        scores: (P, R, C) of P parts.
        stiffness: (P, 2) ax, ay > 0.
        shift: (P, 2) kx, ky, whole cells.

    Returns:
        For each part its (R, C) map, and ``reach`` (2,): how many cells in x and y the best cell can be away from
        (x + kx, y + ky), unless it is the nearest on the border of the map.
    """
    count, rows, cols = scores.shape
    a, k = stiffness.astype(scores.dtype)[:, :, None, None], shift
    top, bottom = max(0, -k[:, 1].min()), max(0, k[:, 1].max())
    left, right = max(0, -k[:, 0].min()), max(0, k[:, 0].max())
    tall = np.full((count, top + rows + bottom + 1, cols), -np.inf, scores.dtype)
    tall[:, top : top + rows] = scores
    reach_y = _reach(scores[:, 1:], scores[:, :-1], a[:, 1], top + rows + bottom)
    _grow(tall, 1, a[:, 1], max(reach_y, top, bottom))

    wide = np.full((count, rows, left + cols + right + 1), -np.inf, scores.dtype)
    for target, source, start in zip(wide, tall, top + k[:, 1], strict=True):
        target[:, left : left + cols] = source[start : start + rows]
    inner = wide[:, :, left : left + cols]
    reach_x = _reach(inner[:, :, 1:], inner[:, :, :-1], a[:, 0], left + cols + right)
    _grow(wide, 2, a[:, 0], max(reach_x, left, right))
    maps = [source[:, start : start + cols] for source, start in zip(wide, left + k[:, 0], strict=True)]
    return maps, np.array([reach_x, reach_y])


def _reach(cells: Array, neighbours: Array, a: Array, most: int) -> int:
    """The last step e with ``a (2 e - 1)`` below the largest difference of neighbours, at most ``most``."""
    if not cells.size:
        return 0
    with np.errstate(invalid="ignore"):  # two forbidden cells differ by inf - inf
        difference = np.abs(cells - neighbours)
    slope = np.fmax.reduce(difference.reshape(len(a), -1), axis=1)
    steps = float(np.fmax.reduce(slope / a.ravel(), initial=0)) / 2 + 0.5
    return most if steps > most else max(0, math.ceil(steps) - 1)


def _grow(maps: Array, axis: int, a: Array, steps: int) -> None:
    """Let every cell win over its two neighbours along one axis, ``steps`` times at rising cost, in place.

    Works on all maps as one long row of numbers, far faster than on slices; so that nothing passes from the end of
    one line to the start of the next, the last entry along the axis is no cell and never offers anything.

    Args:
        maps: (P, R, C) contiguous.
        axis: 1 for y, 2 for x.
        a: (P, 1, 1) cost of the first step.
        steps: how many.
    """
    stride = maps.shape[2] if axis == 1 else 1
    offer = np.empty_like(maps)
    fence = offer[:, -1] if axis == 1 else offer[:, :, -1]
    mine, theirs = maps.reshape(-1), offer.reshape(-1)
    for step in range(steps):
        np.subtract(maps, a * (2 * step + 1), out=offer)
        fence.fill(-np.inf)
        np.maximum(mine[stride:], theirs[:-stride], out=mine[stride:])
        np.maximum(mine[:-stride], theirs[stride:], out=mine[:-stride])
