"""A picture goes in, a map of cells with 32 oriented-gradient channels each comes out."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

CHANNELS = 32
"""18 signed and 9 unsigned orientations, 4 texture energies, 1 that marks the outside of the picture."""

Array = NDArray[Any]

_COS = (1.0, 0.9397, 0.7660, 0.5, 0.1736, -0.1736, -0.5, -0.7660, -0.9397)
_SIN = (0.0, 0.3420, 0.6428, 0.8660, 0.9848, 0.9848, 0.8660, 0.6428, 0.3420)
_CLIP = 0.2
_ENERGY_FLOOR = 1e-4
_TEXTURE = 0.2357


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
    magnitude, orientation = _gradients(image, blocks[0] * cell_px, blocks[1] * cell_px, np.dtype(dtype))
    return _normalised(_histogram(magnitude, orientation, cell_px, blocks).astype(dtype, copy=False))


def _gradients(image: Array, height: int, width: int, dtype: np.dtype[Any]) -> tuple[Array, Array]:
    """Magnitude and signed orientation bin (0..17) of the pixels 1 to height-2 and 1 to width-2.

    The colour channel with the strongest gradient speaks for the pixel. Where the cells reach beyond the picture the
    last inner pixels repeat.
    """
    strongest, dx, dy = _gradient(image[:height, :width, 0], dtype)
    for channel in (1, 2):
        energy, other_dx, other_dy = _gradient(image[:height, :width, channel], dtype)
        stronger = energy > strongest
        np.copyto(strongest, energy, where=stronger)
        np.copyto(dx, other_dx, where=stronger)
        np.copyto(dy, other_dy, where=stronger)
    magnitude, orientation = np.sqrt(strongest), _orientation(dx, dy)
    missing = (0, height - 2 - magnitude.shape[0]), (0, width - 2 - magnitude.shape[1])
    if np.any(missing):
        magnitude, orientation = np.pad(magnitude, missing, "edge"), np.pad(orientation, missing, "edge")
    return magnitude, orientation


def _gradient(plane: Array, dtype: np.dtype[Any]) -> tuple[Array, Array, Array]:
    plane = plane.astype(dtype)
    dx = plane[1:-1, 2:] - plane[1:-1, :-2]
    dy = plane[2:, 1:-1] - plane[:-2, 1:-1]
    return dx * dx + dy * dy, dx, dy


def _orientation(dx: Array, dy: Array) -> Array:
    """The signed bin whose direction is nearest; the first of equals."""
    best = np.zeros_like(dx)
    orientation = np.zeros(dx.shape, np.int64)
    for k, (cos, sin) in enumerate(zip(_COS, _SIN, strict=True)):
        along = cos * dx + sin * dy
        size = np.abs(along)
        better = size > best
        np.copyto(best, size, where=better)
        np.copyto(orientation, np.where(along < 0, k + 9, k), where=better)
    return orientation


def _histogram(magnitude: Array, orientation: Array, cell_px: int, blocks: tuple[int, int]) -> Array:
    """Sum the magnitudes into cells x 18 bins, each pixel shared among the four nearest cells: (rows, cols, 18)."""
    row, below = _share(magnitude.shape[0], cell_px)
    col, right = _share(magnitude.shape[1], cell_px)
    stride = blocks[1] + 2
    bins = (row[:, None] * stride + col) * 18 + orientation
    size = (blocks[0] + 2) * stride * 18
    total = np.zeros(size)
    for down, weight_y in ((0, 1 - below), (1, below)):
        for across, weight_x in ((0, 1 - right), (1, right)):
            weight = (weight_x * weight_y[:, None]) * magnitude
            target = bins + (down * stride + across) * 18
            total += np.bincount(target.ravel(), weight.ravel(), size)
    return total.reshape(blocks[0] + 2, stride, 18)[1:-1, 1:-1]


def _share(count: int, cell_px: int) -> tuple[Array, Array]:
    """For the pixels 1..count: the cell before (counted from one outside the picture) and the share of the next."""
    position = (np.arange(1, count + 1) + 0.5) / cell_px + 0.5
    cell = np.floor(position).astype(np.int64)
    return cell, position - cell


def _normalised(histogram: Array) -> Array:
    """The 32 channels from the histograms (rows, cols, 18) of all cells."""
    signed = histogram[1:-1, 1:-1]
    unsigned = signed[..., :9] + signed[..., 9:]
    features = np.zeros((*signed.shape[:2], CHANNELS), histogram.dtype)
    for k, scale in enumerate(_scales(histogram)):
        clipped = np.minimum(signed * scale[..., None], _CLIP)
        features[..., :18] += clipped
        features[..., 18:27] += np.minimum(unsigned * scale[..., None], _CLIP)
        features[..., 27 + k] = _TEXTURE * clipped.sum(-1)
    features[..., :27] *= 0.5
    return features


def _scales(histogram: Array) -> tuple[Array, Array, Array, Array]:
    """For each inner cell the inverse energies of the four 2x2 neighbourhoods it belongs to."""
    energy = ((histogram[..., :9] + histogram[..., 9:]) ** 2).sum(-1)
    square = energy[:-1, :-1] + energy[1:, :-1] + energy[:-1, 1:] + energy[1:, 1:]
    scale = 1 / np.sqrt(square + histogram.dtype.type(_ENERGY_FLOOR))
    return scale[1:, 1:], scale[:-1, 1:], scale[1:, :-1], scale[:-1, :-1]
