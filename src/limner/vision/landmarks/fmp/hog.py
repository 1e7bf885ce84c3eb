"""A picture goes in, a map of cells with 32 oriented-gradient channels each comes out."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import DTypeLike, NDArray

CHANNELS = 32
"""18 signed and 9 unsigned orientations, 4 texture energies, 1 that marks the outside of the picture."""

Array = NDArray[Any]

_BOUNDS = (603 / 3420, 1737 / 3008, 2660 / 2232, 3264 / 1188)
"""Where, in the first quadrant, one of the directions (cos, sin) of (1, 0), (.9397, .3420), (.7660, .6428), (.5, .8660)
and (.1736, .9848) gives way to the next as the nearest: slopes at which both agree with the gradient equally."""

_BINS = np.array([*range(5), *range(9, 4, -1), 0, *range(17, 13, -1), *range(9, 14)], np.int64)
"""Bin of 18 for the nearest of these, in the quadrants (x, y) = (+, +), (-, +), (+, -), (-, -)."""

_CLIP = 0.2
_ENERGY_FLOOR = 1e-4
_TEXTURE = 0.2357
_STRIP_PX = 64


def half_down(x: float) -> int:
    """The nearest whole number; a half goes down."""
    return int(np.ceil(x - 0.5))


def hog(image: Array, cell_px: int = 4, dtype: DTypeLike = np.float64) -> Array:
    """Histograms of oriented gradients, normalised by their neighbourhood.

    Felzenszwalb et al. 2010 (doi:10.1109/TPAMI.2009.167), with the constants of Zhu & Ramanan 2012
    (doi:10.1109/CVPR.2012.6248014), whose models expect exactly these numbers.

    Args:
        image: (H, W, 3), values 0..255.
        cell_px: side of a cell [px].
        dtype: float64, or float32 for speed.

    Returns:
        (round(H / cell_px) - 2, round(W / cell_px) - 2, 32): the outermost cells lack neighbours and are left out,
        so that entry (i, j) covers the pixels from ``(i + 1) * cell_px`` and ``(j + 1) * cell_px`` on. Empty when the
        picture has fewer than three cells in a direction.
    """
    blocks = half_down(image.shape[0] / cell_px), half_down(image.shape[1] / cell_px)
    if min(blocks) < 3:
        return np.zeros((max(blocks[0] - 2, 0), max(blocks[1] - 2, 0), CHANNELS), dtype)
    return _normalised(_histogram(image, cell_px, blocks, np.dtype(dtype)))


def hog_part(
    image: Array, low: tuple[int, int], high: tuple[int, int], cell_px: int = 4, dtype: DTypeLike = np.float64
) -> Array:
    """``hog(image, cell_px, dtype)[low[0]:high[0], low[1]:high[1]]`` with the work of that part alone.

    Args:
        image: as for ``hog``.
        low: first row and column of cells.
        high: last ones plus 1; beyond the map there is nothing.
        cell_px: as for ``hog``.
        dtype: as for ``hog``.
    """
    # A cell's normalisers reach one cell further and that one's pixels count from half a cell further still, and the
    # picture's outermost pixels have no gradient.
    first = [max(0, k - 1) for k in low]
    last = [k + 3 for k in high]
    top, left = (k * cell_px for k in first)
    bottom, right = (k * cell_px for k in last)
    cells = hog(image[top:bottom, left:right], cell_px, dtype)
    skip_y, skip_x = (k - f for k, f in zip(low, first, strict=True))
    return cells[skip_y : skip_y + high[0] - low[0], skip_x : skip_x + high[1] - low[1]]


def _histogram(image: Array, cell_px: int, blocks: tuple[int, int], dtype: np.dtype[Any]) -> Array:
    """Sum the magnitudes into 18 bins of cells, each pixel shared among the four nearest cells: (18, rows, cols).

    Works on strips of the picture that stay in the cache. Where the cells reach beyond the picture the last inner
    pixels repeat.
    """
    height, width = blocks[0] * cell_px, blocks[1] * cell_px
    total = np.zeros((blocks[0] + 2, blocks[1] + 2, 18))
    cols = _share(1, width - 1, cell_px)
    for first in range(1, height - 1, _STRIP_PX):
        last = min(first + _STRIP_PX, height - 1)
        start, stop = (min(y, image.shape[0] - 2) for y in (first, last - 1))
        magnitude, orientation = _gradients(image[start - 1 : stop + 2, :width], dtype)
        missing = (0, last - first - magnitude.shape[0]), (0, width - 2 - magnitude.shape[1])
        if np.any(missing):
            magnitude, orientation = np.pad(magnitude, missing, "edge"), np.pad(orientation, missing, "edge")
        _add(total, magnitude, orientation, _share(first, last, cell_px), cols)
    planes = total[1:-1, 1:-1].reshape(-1, 18).astype(dtype, copy=False)
    return cv2.transpose(planes).reshape(18, *blocks)


def _share(first: int, last: int, cell_px: int) -> tuple[Array, Array]:
    """For the pixels first..last-1: the cell before (counted from one outside the picture), the share of the next."""
    position = (np.arange(first, last) + 0.5) / cell_px + 0.5
    cell = np.floor(position).astype(np.int64)
    return cell, position - cell


def _add(
    total: Array, magnitude: Array, orientation: Array, rows: tuple[Array, Array], cols: tuple[Array, Array]
) -> None:
    """Add a strip of pixels to ``total`` (rows, cols, 18)."""
    stride, top = total.shape[1] * 18, int(rows[0][0])
    size = (int(rows[0][-1]) + 2 - top) * stride
    bins = (orientation + ((rows[0] - top)[:, None] * stride + cols[0] * 18)).ravel()
    below, right = (share.astype(magnitude.dtype) for share in (rows[1][:, None], cols[1]))
    strip = total.reshape(-1)[top * stride : top * stride + size]
    lower = magnitude * below
    for down, part in ((0, magnitude - lower), (stride, lower)):
        other = part * right
        for across, weight in ((0, part - other), (18, other)):
            start = down + across
            strip[start:] += np.bincount(bins, weight.ravel(), size)[: size - start]


def _gradients(image: Array, dtype: np.dtype[Any]) -> tuple[Array, Array]:
    """Magnitude and signed orientation bin (0..17) of the inner pixels, each (H - 2, W - 2).

    The colour channel with the strongest gradient speaks for the pixel.
    """
    strongest, dx, dy = _gradient(image[..., 0], dtype)
    for channel in (1, 2):
        energy, other_dx, other_dy = _gradient(image[..., channel], dtype)
        stronger = (energy > strongest).view(np.uint8)
        for other, winner in ((energy, strongest), (other_dx, dx), (other_dy, dy)):
            cv2.copyTo(other, stronger, winner)
    return np.sqrt(strongest), _orientation(dx, dy)


def _gradient(plane: Array, dtype: np.dtype[Any]) -> tuple[Array, Array, Array]:
    plane = np.ascontiguousarray(plane, dtype)
    dx = plane[1:-1, 2:] - plane[1:-1, :-2]
    dy = plane[2:, 1:-1] - plane[:-2, 1:-1]
    return dx * dx + dy * dy, dx, dy


def _orientation(dx: Array, dy: Array) -> Array:
    """The signed bin whose direction is nearest; of the two nearest to straight up or down the first."""
    across, along = np.abs(dx), np.abs(dy)
    down = dy < 0
    left = np.where(down, dx <= 0, dx < 0)
    code: Array = left * np.uint8(5) + down * np.uint8(10)
    for bound in _BOUNDS:
        code += (along > across * dx.dtype.type(bound)).view(np.uint8)
    bins: Array = _BINS.take(code)
    return bins


def _normalised(histogram: Array) -> Array:
    """The 32 channels (rows - 2, cols - 2, 32) from the histograms (18, rows, cols) of all cells."""
    both = histogram[:9] + histogram[9:]
    signed = np.ascontiguousarray(histogram[:, 1:-1, 1:-1])
    unsigned = np.ascontiguousarray(both[:, 1:-1, 1:-1])
    features = np.zeros((CHANNELS, *signed.shape[1:]), histogram.dtype)
    for k, scale in enumerate(_scales(both)):
        clipped = np.minimum(signed * scale, _CLIP)
        features[:18] += clipped
        features[27 + k] = _TEXTURE * clipped.sum(axis=0)
        features[18:27] += np.minimum(unsigned * scale, _CLIP)
    features[:27] *= 0.5
    flat: Array = cv2.transpose(features.reshape(CHANNELS, -1))
    return flat.reshape(*signed.shape[1:], CHANNELS)


def _scales(both: Array) -> tuple[Array, Array, Array, Array]:
    """For each inner cell the inverse energies of the four 2x2 neighbourhoods it belongs to.

    Args:
        both: (9, rows, cols) the magnitudes in each unsigned bin.
    """
    energy = (both * both).sum(axis=0)
    square = energy[:-1, :-1] + energy[1:, :-1] + energy[:-1, 1:] + energy[1:, 1:]
    scale = 1 / np.sqrt(square + both.dtype.type(_ENERGY_FLOOR))
    return scale[1:, 1:], scale[:-1, 1:], scale[1:, :-1], scale[:-1, :-1]
