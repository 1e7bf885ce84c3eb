"""Score maps of parts and their springs go in, the best score each place can hope for from such a part comes out."""

from __future__ import annotations

import numpy as np

from limner.vision.landmarks.fmp.hog import Array


def spread(scores: Array, stiffness: Array, shift: Array, slope: Array) -> tuple[list[Array], Array]:
    """The generalised distance transform of Felzenszwalb & Huttenlocher 2012 (doi:10.4086/toc.2012.v008a019).

    For each part ``max over v of score(v) + slope . v - ax (x + kx - vx)^2 - ay (y + ky - vy)^2`` at every cell
    (x, y), exactly: along one axis the parabola ``a e^2`` is the sum of steps ``a, 3 a, 5 a...``, so the maximum over
    all cells up to K away is K times a maximum over the two neighbours. Where neighbours never differ by more than S,
    a step closer to the goal gains more than it loses as soon as ``a (2 e - 1) >= S``, so no best cell is farther
    than the last step below S; the maximum over the other axis makes no neighbours differ more.

    Args:
        scores: (P, R, C) of P parts; may hold -inf.
        stiffness: (P, 2) ax, ay > 0.
        shift: (P, 2) kx, ky, whole cells.
        slope: (P, 2) what a cell further right and further down adds to the score.

    Returns:
        For each part its (R, C) map, and ``reach`` (2,): how many cells in x and y the best cell can be away from
        (x + kx, y + ky), unless it is the nearest on the border of the map.
    """
    _, rows, cols = scores.shape
    a, tilt = stiffness.astype(scores.dtype)[:, :, None, None], slope.astype(scores.dtype)[:, :, None, None]
    y, x = np.arange(rows, dtype=scores.dtype)[:, None], np.arange(cols, dtype=scores.dtype)
    reach = _reach(scores, stiffness, slope, np.abs(shift).max(axis=0))

    tall, top = _room(scores, 1, shift[:, 1])
    np.add(scores, tilt[:, 1] * y, out=tall[:, top : top + rows])
    _grow(tall, 1, top, rows, a[:, 1], int(reach[1]))
    wide, left = _room(scores, 2, shift[:, 0])
    ramps = tilt[:, 0] * x
    for target, source, start, ramp in zip(wide, tall, top + shift[:, 1], ramps, strict=True):
        np.add(source[start : start + rows], ramp, out=target[:, left : left + cols])
    _grow(wide, 2, left, cols, a[:, 0], int(reach[0]))
    return [source[:, start : start + cols] for source, start in zip(wide, left + shift[:, 0], strict=True)], reach


def _reach(scores: Array, stiffness: Array, slope: Array, farthest: Array) -> Array:
    """The last step e, along x and y, with ``a (2 e - 1)`` below the largest difference of neighbours; (2,)."""
    count, rows, cols = scores.shape
    flat, difference = scores.reshape(count, -1), np.empty_like(scores)
    steps = np.zeros(2)
    for axis, stride in ((0, 1), (1, cols)):
        if (cols, rows)[axis] == 1:
            continue
        change = difference.reshape(count, -1)[:, : rows * cols - stride]
        with np.errstate(invalid="ignore"):  # two forbidden cells differ by inf - inf
            np.subtract(flat[:, stride:], flat[:, :-stride], out=change)
        if axis == 0:
            difference[:, :-1, -1] = 0  # from the end of a row to the start of the next is no step
        rise, fall = change.max(axis=1) + slope[:, axis], change.min(axis=1) + slope[:, axis]
        steps[axis] = np.ceil((np.maximum(rise, -fall) / stiffness[:, axis]).max() / 2 + 0.5) - 1
    most = np.array([cols, rows]) + farthest
    return np.where(steps < most, steps, most).astype(np.int64)  # no number for steps: neighbours are forbidden


def _room(scores: Array, axis: int, shift: Array) -> tuple[Array, int]:
    """Maps with room along an axis for the cells outside that the shifts reach, and how many there are before.

    All but the room for the scores is -inf: the cells outside, and one behind the last that is no cell but a fence.
    """
    before, after = max(0, -int(shift.min())), max(0, int(shift.max()))
    shape = list(scores.shape)
    shape[axis] += before + after + 1
    maps = np.empty(shape, scores.dtype)
    lines = maps.swapaxes(1, axis)
    lines[:, :before] = -np.inf
    lines[:, before + scores.shape[axis] :] = -np.inf
    return maps, before


def _grow(maps: Array, axis: int, before: int, count: int, a: Array, steps: int) -> None:
    """Let every cell win over its neighbours up to ``steps`` away along an axis, at the cost of the spring, in place.

    Works on all maps as one long row of numbers, far faster than on slices; the fence at the end of each line never
    offers anything, so that nothing passes to the start of the next. Cells farther outside than ``steps`` take the
    line's end, the only one that can be their best.

    Args:
        maps: (P, R, C) contiguous, as ``_room`` lays them out.
        axis: 1 for y, 2 for x.
        before: cells outside, before the first score of a line.
        count: scores in a line.
        a: (P, 1, 1) cost of the first step.
        steps: how many.
    """
    lines, stride = maps.swapaxes(1, axis), maps.shape[2] if axis == 1 else 1
    after = lines.shape[1] - before - count - 1
    first, last = lines[:, before].copy(), lines[:, before + count - 1].copy()
    offer = np.empty_like(maps)
    fence = offer.swapaxes(1, axis)[:, -1]
    mine, theirs = maps.reshape(-1), offer.reshape(-1)
    later, earlier = mine[stride:], mine[:-stride]
    from_before, from_after = theirs[:-stride], theirs[stride:]
    for cost in a * (2 * np.arange(steps, dtype=a.dtype) + 1)[:, None, None, None]:
        np.subtract(maps, cost, out=offer)
        fence.fill(-np.inf)
        np.maximum(later, from_before, out=later)
        np.maximum(earlier, from_after, out=earlier)
    if before > steps:
        away = np.arange(before, steps, -1).astype(maps.dtype)[:, None]
        lines[:, : before - steps] = first[:, None] - a * away**2
    if after > steps:
        away = np.arange(steps + 1, after + 1).astype(maps.dtype)[:, None]
        lines[:, before + count + steps : -1] = last[:, None] - a * away**2
