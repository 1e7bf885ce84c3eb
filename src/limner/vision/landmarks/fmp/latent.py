"""A positive and a model in; the cells at which its parts score best while each stays on its landmark, out."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from limner.errors import BadInput
from limner.types import Floats
from limner.vision.landmarks.fmp.layout import SIZE
from limner.vision.landmarks.fmp.model import Component
from limner.vision.landmarks.fmp.positives import Positive
from limner.vision.landmarks.fmp.pyramid import FILTER

Cells = NDArray[np.int64]


_AROUND = np.arange(-FILTER, FILTER + 2)
_GUESSED = 0.3
"""A part may overlap a landmark that is guessed by so much less."""


def allowed(cell: Floats, overlap: float, size: tuple[int, int]) -> Cells:
    """The cells from which a part's box overlaps its landmark's enough: (k, 2) x, y.

    Args:
        cell: (2,) where the landmark is.
        overlap: least intersection over union of the two boxes.
        size: rows and columns where a filter fits.
    """
    corner = np.floor(cell).astype(np.int64)
    near = corner + np.stack(np.meshgrid(_AROUND, _AROUND), axis=-1).reshape(-1, 2)
    common = np.clip(FILTER - np.abs(near - cell), 0, None).prod(axis=1)
    enough = common / (2 * FILTER**2 - common) > overlap
    inside = ((near >= 0) & (near < size[::-1])).all(axis=1)
    some: Cells = near[enough & inside]
    return some


def place(
    component: Component, filters: NDArray[np.float32], positive: Positive, overlap: float
) -> tuple[float, Cells]:
    """The best placing of a mixture on a face, part by part from the leaves to the root and back (exact).

    Args:
        component: the mixture.
        filters: (F, 5, 5, 32) the model's pool.
        positive: the face, all landmarks of the mixture known.
        overlap: least intersection over union of a part's box with its landmark's.

    Returns:
        The score, and (n, 2) cells x, y.

    Raises:
        BadInput: a part has no cell to go to.
    """
    room = _room(positive)
    places = [
        allowed(positive.cells[mark], overlap if positive.sure[mark] else overlap * _GUESSED, room)
        for mark in component.landmarks
    ]
    if min(map(len, places)) == 0:
        raise BadInput(f"{positive.name}: a landmark so near the border that its part has no place")
    scores = [
        _responses(filters[pooled], positive, spots) for pooled, spots in zip(component.filters, places, strict=True)
    ]
    choices: list[Cells] = [np.zeros(0, np.int64)] * len(places)
    for child in range(len(places) - 1, 0, -1):
        parent = int(component.parents[child])
        stretch = places[parent][:, None] + component.anchors[child] - places[child][None]
        ax, bx, ay, by = component.springs[child]
        cost = ax * stretch[..., 0] ** 2 + bx * stretch[..., 0] + ay * stretch[..., 1] ** 2 + by * stretch[..., 1]
        hope = scores[child][None] - cost
        choices[child] = hope.argmax(axis=1)
        scores[parent] = scores[parent] + hope.max(axis=1)
    return _read_back(component, places, scores, choices)


def _room(positive: Positive) -> tuple[int, int]:
    rows, cols = positive.features.shape[:2]
    return rows - FILTER + 1, cols - FILTER + 1


def _responses(weights: NDArray[np.float32], positive: Positive, spots: Cells) -> Floats:
    seen = np.stack([positive.features[y : y + FILTER, x : x + FILTER].ravel() for x, y in spots.tolist()])
    response: Floats = (seen @ weights.reshape(SIZE)).astype(np.float64)
    return response


def _read_back(
    component: Component, places: list[Cells], scores: list[Floats], choices: list[Cells]
) -> tuple[float, Cells]:
    chosen = [int(scores[0].argmax())]
    for part in range(1, len(places)):
        chosen.append(int(choices[part][chosen[component.parents[part]]]))
    cells = np.array([spots[k] for spots, k in zip(places, chosen, strict=True)])
    return float(scores[0].max()) + component.bias, cells
