"""A picture goes in, HOG maps of it at falling scales come out, only those that somebody will search."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import DTypeLike, NDArray

from limner.types import Floats
from limner.vision.landmarks.fmp.hog import CHANNELS, Array, half_down, hog, hog_part

PAD = 4
"""Empty cells around each map, so that parts may lie partly outside the picture."""

FILTER = 5
"""Side of a part's filter [cells]."""

_DROPPED_SHARE = 1e-3
"""Shares of a pixel below this are not counted in area averaging."""


@dataclass(frozen=True, eq=False)
class Level:
    """One map of the pyramid.

    Attributes:
        index: counted as Zhu & Ramanan's release does: ``interval + 1`` is the picture at full size.
        scale_px: pixels of the picture per cell, nominal (sizes are rounded to whole pixels, so each axis has its own).
        features: (rows + 2 PAD, cols + 2 PAD, 32); cell (PAD, PAD) is the first of the HOG map.
        cell_px: (2,) pixels of the picture per cell along x and y, exact.
        start_px: (2,) x, y of the upper left corner of cell (0, 0) in the picture, pixel centres on integers.
    """

    index: int
    scale_px: float
    features: Array
    cell_px: Floats
    start_px: Floats

    def centres_px(self, cells: NDArray[Any]) -> Floats:
        """(..., 2) the pixels x, y at the centres of the filters whose first cells are ``cells`` (..., 2)."""
        centres: Floats = self.start_px + (cells + FILTER / 2) * self.cell_px
        return centres


def pyramid(
    image: Array,
    interval: int,
    *,
    cell_px: int = 4,
    dtype: DTypeLike = np.float64,
    scale_range_px: tuple[float, float] = (0.0, math.inf),
) -> Iterator[Level]:
    """HOG maps from fine to coarse, one at a time, each ``2 ** (1 / interval)`` coarser than the last.

    The levels are computed in the order in which they need the least work, not in that of their index: all octaves of
    one fraction, then of the next.

    Args:
        image: (H, W, 3), values 0..255.
        interval: levels per octave.
        cell_px: side of a cell in each scaled picture [px].
        dtype: float64, or float32 for speed.
        scale_range_px: photo pixels per cell, from and to: other levels are skipped.
    """
    wanted = wanted_steps(image.shape[:2], interval, cell_px, scale_range_px)
    for scaled in scaled_pictures(np.asarray(image, dtype), interval, wanted):
        yield level_of(scaled, interval, cell_px, dtype)


def wanted_steps(size: tuple[int, ...], interval: int, cell_px: int, scale_range_px: tuple[float, float]) -> list[int]:
    """How often a picture of ``size`` (height, width) is made smaller by ``2 ** (-1 / interval)`` for each level."""
    low, high = scale_range_px
    shrink = 2 ** (1 / interval)
    return [step for step in range(level_count(size, interval, cell_px)) if low <= cell_px * shrink**step <= high]


def level_of(scaled: Scaled, interval: int, cell_px: int, dtype: DTypeLike) -> Level:
    """The map of a picture made smaller."""
    features = padded(hog(scaled.image, cell_px, dtype))
    start = scaled.corner_px + (1 - PAD) * cell_px * scaled.pixel_px
    scale = cell_px * 2 ** (scaled.step / interval)
    return Level(interval + 1 + scaled.step, scale, features, cell_px * scaled.pixel_px, start)


def padded_size(scaled: Scaled, cell_px: int) -> NDArray[np.int64]:
    """(2,) columns and rows of the whole padded map of a picture."""
    blocks = [half_down(length / cell_px) for length in scaled.image.shape[1::-1]]
    return np.array([max(length - 2, 0) + 2 * PAD for length in blocks], np.int64)


def part_of(
    scaled: Scaled,
    interval: int,
    cell_px: int,
    dtype: DTypeLike,
    box: tuple[NDArray[np.int64], NDArray[np.int64]],
) -> Level:
    """A part of ``level_of(...)`` with the work of that part alone; its cells count from the part's first.

    Args:
        scaled: the picture.
        interval: levels per octave.
        cell_px: side of a cell [px].
        dtype: float64, or float32 for speed.
        box: first cell x, y of the padded map and the last ones plus 1, inside of it.
    """
    low, high = box
    inner = padded_size(scaled, cell_px) - 2 * PAD
    features = np.zeros((*(high - low)[::-1], CHANNELS), dtype)
    features[..., -1] = 1
    first, last = np.clip(low - PAD, 0, inner), np.clip(high - PAD, 0, inner)
    if (last > first).all():
        at, end = first - (low - PAD), last - (low - PAD)
        cells = hog_part(scaled.image, (int(first[1]), int(first[0])), (int(last[1]), int(last[0])), cell_px, dtype)
        features[at[1] : end[1], at[0] : end[0]] = cells
    start = scaled.corner_px + (low + 1 - PAD) * cell_px * scaled.pixel_px
    scale = cell_px * 2 ** (scaled.step / interval)
    return Level(interval + 1 + scaled.step, scale, features, cell_px * scaled.pixel_px, start)


@dataclass(frozen=True, eq=False)
class Scaled:
    """A picture made smaller.

    Attributes:
        step: how often by ``2 ** (-1 / interval)``.
        image: (h, w, 3) in the picture's dtype.
        corner_px: (2,) x, y of its upper left corner in the picture, pixel centres on integers.
        pixel_px: (2,) size of its pixels x, y in those of the picture.
    """

    step: int
    image: Array
    corner_px: Floats
    pixel_px: Floats


def scaled_pictures(image: Array, interval: int, steps: Collection[int]) -> Iterator[Scaled]:
    """The picture at the scales ``2 ** (-step / interval)``: area averages for the first octave, then halvings."""
    for first in range(interval):
        last = max((step for step in steps if step % interval == first), default=-1)
        for step in range(first, last + 1, interval):
            if step == first:
                scaled = resize(image, 2 ** (-first / interval))
                corner, pixel = np.array([-0.5, -0.5]), np.array(image.shape[1::-1]) / scaled.shape[1::-1]
            else:
                scaled, corner, pixel = reduce(scaled), corner - pixel / 2, 2 * pixel
            if step in steps:
                yield Scaled(step, scaled, corner, pixel)


def level_count(size: tuple[int, ...], interval: int, cell_px: int = 4) -> int:
    """Number of levels from the full size down to where the shorter side is as long as one filter."""
    smallest = min(size) / (FILTER * cell_px)
    return 1 + math.floor(math.log(smallest) / math.log(2 ** (1 / interval))) if smallest >= 1 else 0


def padded(features: Array, pad: int = PAD) -> Array:
    """The map with ``pad`` cells around it that are empty but for the last channel, which says that they are."""
    rows, cols = features.shape[:2]
    result = np.zeros((rows + 2 * pad, cols + 2 * pad, CHANNELS), features.dtype)
    result[..., -1] = 1
    result[pad : pad + rows, pad : pad + cols] = features
    return result


def resize(image: Array, scale: float) -> Array:
    """A smaller picture whose pixels are the averages of the areas they cover.

    Args:
        image: (H, W, 3) float64 (exact) or float32 (by OpenCV, which weighs by the same rule).
        scale: in (0, 1].
    """
    height, width = half_down(image.shape[0] * scale), half_down(image.shape[1] * scale)
    if (height, width) == image.shape[:2]:
        return image
    if image.dtype == np.float32:
        return cv2.resize(image, (width, height), interpolation=cv2.INTER_AREA)
    rows = _average(image, height)
    return _average(rows.swapaxes(0, 1), width).swapaxes(0, 1)


def _average(image: Array, target: int) -> Array:
    """Area averages along the first axis."""
    first, weights = _area_weights(image.shape[0], target)
    result = np.zeros((target, *image.shape[1:]), image.dtype)
    for k, weight in enumerate(weights):
        source = np.minimum(first + k, image.shape[0] - 1)
        result += weight[:, None, None].astype(image.dtype) * image[source]
    return result


def _area_weights(length: int, target: int) -> tuple[Array, Array]:
    """First source pixel of each target pixel (target,) and the weights from there on (taps, target)."""
    ratio = length / target
    start = np.arange(target) * ratio
    end = start + ratio
    first = np.floor(start).astype(np.int64)
    source = first + np.arange(math.ceil(ratio) + 1)[:, None]
    share = np.minimum(source + 1, end) - np.maximum(source, start)
    return first, np.where(share > _DROPPED_SHARE, share, 0) * (target / length)


def reduce(image: Array) -> Array:
    """The picture at half size (a half goes down), smoothed by the five taps [1 4 6 4 1] / 16 along both axes.

    The taps of target pixel i are centred on source pixel 2 i, so that its corner lies half a source pixel before
    that of a plain halving; beyond the last centre its pixel repeats.
    """
    if image.dtype == np.float32:
        height, width = half_down(image.shape[0] / 2), half_down(image.shape[1] / 2)
        return cv2.pyrDown(image[: 2 * height - 1, : 2 * width - 1], borderType=cv2.BORDER_REPLICATE)
    return _reduce(_reduce(image).swapaxes(0, 1)).swapaxes(0, 1)


def _reduce(image: Array) -> Array:
    target = half_down(image.shape[0] / 2)
    source = np.clip(np.arange(-2, 2 * target + 1), 0, 2 * target - 2)
    taps = [image[source[k : k + 2 * target : 2]] for k in range(5)]
    return taps[0] * 0.0625 + taps[1] * 0.25 + taps[2] * 0.375 + taps[3] * 0.25 + taps[4] * 0.0625
