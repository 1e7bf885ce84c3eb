"""A face found on whole cells goes in, its landmarks between the cells come out."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import DTypeLike, NDArray

from limner.types import Floats
from limner.vision.landmarks.fmp.hog import Array, half_down, hog
from limner.vision.landmarks.fmp.inference import Detection
from limner.vision.landmarks.fmp.matching import Forest
from limner.vision.landmarks.fmp.model import Component, FmpModel
from limner.vision.landmarks.fmp.pyramid import FILTER, PAD, padded
from limner.vision.landmarks.fmp.response import responses
from limner.vision.landmarks.fmp.threads import one_thread

_STEP_OCTAVES = 0.2
_MARGIN_CELLS = 3
_SHARPNESS = 3.0
"""A size whose score is better by 1 counts e ** this as much in the average."""
_HOLD = 1e-6
"""A spring to its cell for each part, for faces whose parts fit equally well everywhere."""


def refine(image: Array, found: Detection, model: FmpModel, sizes: int, dtype: DTypeLike = np.float32) -> Floats:
    """Place the parts anew in the face's surroundings at some sizes, each between the cells, and average.

    Args:
        image: (H, W, 3) in which the face was found, values 0..255.
        found: where.
        model: what found it.
        sizes: how many, a fifth of an octave apart, the found one in the middle.
        dtype: float64, or float32 for speed.

    Returns:
        (n, 2) centres of the parts, x, y in ``image``, pixel centres on integers.
    """
    component = model.components[found.component]
    octaves = (np.arange(sizes) - (sizes - 1) / 2) * _STEP_OCTAVES
    scales = found.scale_px * 2**octaves
    with one_thread():
        placed = [_place(image, found, model, component, scale, np.dtype(dtype)) for scale in scales]
    scores = np.array([score for score, _ in placed])
    weights = np.exp(_SHARPNESS * (scores - scores.max()))
    mean: Floats = np.tensordot(weights / weights.sum(), [points for _, points in placed], axes=1)
    return mean


def _place(
    image: Array, found: Detection, model: FmpModel, component: Component, scale_px: float, dtype: np.dtype[Any]
) -> tuple[float, Floats]:
    """Score and parts of the best configuration around the face when a cell is ``scale_px`` pixels wide."""
    margin = (FILTER / 2 + _MARGIN_CELLS) * scale_px
    low = np.clip(np.floor(found.points_px.min(axis=0) - margin), 0, None).astype(int)
    high = np.minimum(np.ceil(found.points_px.max(axis=0) + margin).astype(int), image.shape[1::-1])
    cut = image[low[1] : high[1], low[0] : high[0]].astype(dtype)
    size = [max(FILTER * model.cell_px, half_down(length * model.cell_px / scale_px)) for length in high - low]
    way = cv2.INTER_AREA if scale_px > model.cell_px else cv2.INTER_CUBIC
    cut = cv2.resize(cut, size, interpolation=way)
    fits = responses(padded(hog(cut, model.cell_px, dtype)), model.filters[component.filters])
    match = Forest((component,)).match(fits.copy())
    root = match.roots[0]
    y, x = np.unravel_index(int(root.argmax()), root.shape)
    cells = match.places(0, np.array([[x, y]]))[0]
    centres = (between_cells(cells, fits, component) + (1 - PAD + FILTER / 2)) * model.cell_px
    return float(root[y, x]), low - 0.5 + centres * (high - low) / size


def between_cells(cells: NDArray[np.int64], fits: Array, component: Component) -> Floats:
    """The best places of all parts together, when each part's fit is a parabola through its cell and the neighbours.

    The whole is then quadratic in all places and its maximum, for each axis, the solution of one linear system.

    Args:
        cells: (n, 2) the best whole cells x, y.
        fits: (n, R, C) how well each part fits at each cell.
        component: the springs.

    Returns:
        (n, 2) cells x, y, each at most one from where it was.
    """
    moved = cells.astype(np.float64)
    for axis in (0, 1):
        slope, bend = _parabola(cells, fits, axis)
        child, parent = np.arange(1, len(cells)), component.parents[1:]
        a, b = component.springs[1:, 2 * axis], component.springs[1:, 2 * axis + 1]
        stretch = cells[parent, axis] + component.anchors[1:, axis] - cells[child, axis]
        pull = 2 * a * stretch + b
        np.add.at(slope, child, pull)
        np.subtract.at(slope, parent, pull)
        system = np.diag(_HOLD - bend)
        for i, j, sign in ((child, child, 2), (parent, parent, 2), (child, parent, -2), (parent, child, -2)):
            np.add.at(system, (i, j), sign * a)
        moved[:, axis] += np.clip(np.linalg.solve(system, slope), -1, 1)
    return moved


def _parabola(cells: NDArray[np.int64], fits: Array, axis: int) -> tuple[Floats, Floats]:
    """Slope and bend (never upward) of each part's fit along an axis; flat where a neighbour is outside the map."""
    x, y = cells.T
    step_x, step_y = (1, 0) if axis == 0 else (0, 1)
    inside = (cells[:, axis] > 0) & (cells[:, axis] < fits.shape[2 - axis] - 1)
    part, step_x, step_y = np.arange(len(cells)), step_x * inside, step_y * inside
    before = fits[part, y - step_y, x - step_x].astype(np.float64)
    after = fits[part, y + step_y, x + step_x].astype(np.float64)
    return (after - before) / 2, np.minimum(before + after - 2.0 * fits[part, y, x], 0)
