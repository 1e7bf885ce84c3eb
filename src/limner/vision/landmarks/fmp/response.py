"""A padded HOG map and filters go in, how well each filter fits at each cell comes out."""

from __future__ import annotations

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from limner.vision.landmarks.fmp.hog import CHANNELS, Array
from limner.vision.landmarks.fmp.pyramid import FILTER

_BATCH_CELLS = 4000
"""Cells worked on at once: their windows, unrolled, are 160 times as many numbers."""


def responses(features: Array, filters: Array) -> Array:
    """Correlate all filters with all windows as five matrix products, one for each row of the filters.

    Args:
        features: (rows, cols, 32).
        filters: (F, 5, 5, 32) y, x, channel.

    Returns:
        (F, rows - 4, cols - 4) in the features' dtype; entry (y, x) is the window whose first cell is (y, x).
    """
    rows, cols = features.shape[0] - FILTER + 1, features.shape[1] - FILTER + 1
    if min(rows, cols) < 1:
        return np.zeros((len(filters), max(rows, 0), max(cols, 0)), features.dtype)
    weights = filters.astype(features.dtype, copy=False).reshape(len(filters), FILTER, -1)
    result = np.empty((len(filters), rows, cols), features.dtype)
    batch = max(1, _BATCH_CELLS // cols)
    for top in range(0, rows, batch):
        strip = features[top : top + batch + FILTER - 1]
        result[:, top : top + batch] = _strip(strip, weights, cols)
    return result


def _strip(features: Array, weights: Array, cols: int) -> Array:
    lines = sliding_window_view(features, FILTER, axis=1).transpose(0, 1, 3, 2)
    lines = np.ascontiguousarray(lines).reshape(features.shape[0] * cols, FILTER * CHANNELS)
    rows = features.shape[0] - FILTER + 1
    total: Array = weights[:, 0] @ lines[: rows * cols].T
    for dy in range(1, FILTER):
        total += weights[:, dy] @ lines[dy * cols : (dy + rows) * cols].T
    return total.reshape(len(weights), rows, cols)
