"""A model and the pictures of a pyramid go in; places where a face may be come out, the likeliest first.

Each view of the model is taken as one stiff template, all its parts where they rest, and laid on maps with cells of
twice the size (a coarse root as in Felzenszwalb et al. 2010, doi:10.1109/TPAMI.2009.167). That costs little beside
matching all parts: a quarter of the cells, and one correlation a view. The large cells make good for most of what the
parts would have moved.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from limner.types import Floats
from limner.vision.landmarks.fmp.hog import CHANNELS, Array, hog
from limner.vision.landmarks.fmp.model import Component, FmpModel
from limner.vision.landmarks.fmp.pyramid import FILTER, Scaled, padded

COARSE = 2
"""Cells of the model along a side of a template's cell."""

_OUTSIDE = 6
"""Empty cells around each map: a face may reach beyond the picture."""

_BATCH_CELLS = 2000
"""Cells worked on at once."""

_NEIGHBOURS = 5
"""A proposal is the best in a square of so many cells."""

_MOST_PER_MAP = 100

_SAME = 0.5
"""Of proposals whose boxes share more than this of their union the best stays."""


@dataclass(frozen=True)
class Proposal:
    """A place where a face may be.

    Attributes:
        score: of the stiff template, bias included.
        view: which component of the model.
        step: of the pyramid, where its parts would be matched.
        root_px: x, y of the middle of the root's window in the picture.
        box_px: x0, y0, x1, y1 around all parts where they rest.
    """

    score: float
    view: int
    step: int
    root_px: tuple[float, float]
    box_px: tuple[float, float, float, float]


@dataclass(frozen=True, eq=False)
class Templates:
    """The views of a model as stiff templates.

    Attributes:
        weights: (views, h, w, 32).
        first: (2,) x, y of the templates' first cell from the root's [cells of the template].
        bias: (views,) added to each view's score.
        boxes: (views, 4) x0, y0, x1, y1 of the box around all parts from the root's first cell [cells of the model].
        cell_px: side of a template's cell in the pictures of the pyramid.
    """

    weights: Array
    first: NDArray[np.int64]
    bias: Array
    boxes: NDArray[np.int64]
    cell_px: int

    @classmethod
    def of(cls, model: FmpModel, dtype: np.dtype[Any]) -> Templates:
        """Take the model's parts where no spring is under load."""
        rests = [np.rint(component.rest_cells).astype(np.int64) for component in model.components]
        boxes = np.array([[*rest.min(axis=0), *(rest.max(axis=0) + FILTER)] for rest in rests])
        first = boxes[:, :2].min(axis=0) // COARSE
        size = -(-boxes[:, 2:].max(axis=0) // COARSE) - first
        weights = np.zeros((len(rests), *(size[::-1] * COARSE), CHANNELS), dtype)
        for view, component, rest in zip(weights, model.components, rests, strict=True):
            for part, (x, y) in zip(model.filters[component.filters], rest - first * COARSE, strict=True):
                view[y : y + FILTER, x : x + FILTER] += part
        weights = weights.reshape(len(rests), size[1], COARSE, size[0], COARSE, CHANNELS).sum(axis=(2, 4))
        bias = np.array([_at_rest(component) for component in model.components], dtype)
        return cls(weights, first, bias, boxes, COARSE * model.cell_px)

    def propose(self, scaled: Scaled) -> list[Proposal]:
        """The places in a picture of the pyramid where one view fits better than around, best first."""
        features = padded(hog(scaled.image, self.cell_px, self.weights.dtype), _OUTSIDE)
        if (np.array(features.shape[:2]) < self.weights.shape[1:3]).any():
            return []
        scores = _correlate(features, self.weights) + self.bias[:, None, None]
        best = scores.max(axis=0)
        y, x = np.nonzero(best == cv2.dilate(best, np.ones((_NEIGHBOURS, _NEIGHBOURS), np.uint8)))
        order = np.argsort(-best[y, x], kind="stable")[:_MOST_PER_MAP]
        y, x = y[order], x[order]
        views = scores[:, y, x].argmax(axis=0)
        side = self.cell_px * scaled.pixel_px
        corners = scaled.corner_px + (np.stack([x, y], axis=1) - _OUTSIDE - self.first + 1) * side
        middles = corners + FILTER / 2 / COARSE * side
        boxes = np.tile(corners, 2) + self.boxes[views] * np.tile(side / COARSE, 2)
        return [
            Proposal(float(score), int(view), scaled.step, (middle[0], middle[1]), tuple(box))
            for score, view, middle, box in zip(best[y, x], views, middles.tolist(), boxes.tolist(), strict=True)
        ]


def _at_rest(component: Component) -> float:
    """Bias of a view and what its springs add where none is under load."""
    a, b = component.springs[1:, ::2], component.springs[1:, 1::2]
    return component.bias + float((b * b / (4 * a)).sum())


def _correlate(features: Array, weights: Array) -> Array:
    """The score of each template (K, h, w, 32) at each place of a map (R, C, 32): (K, R - h + 1, C - w + 1).

    One matrix product for a strip of the map gives what each row of each template has there.
    """
    count, height, width = weights.shape[:3]
    rows, cols = features.shape[0] - height + 1, features.shape[1] - width + 1
    flat = weights.reshape(count * height, -1).T
    total = np.zeros((rows, cols, count), features.dtype)
    batch = max(1, _BATCH_CELLS // cols)
    for top in range(0, len(features), batch):
        lines = sliding_window_view(features[top : top + batch], width, axis=1).transpose(0, 1, 3, 2)
        parts = np.ascontiguousarray(lines).reshape(-1, flat.shape[0]) @ flat
        parts = parts.reshape(-1, cols, count, height)
        for dy in range(height):
            first, last = max(0, top - dy), min(rows, top - dy + len(parts))
            if first < last:
                total[first:last] += parts[first + dy - top : last + dy - top, ..., dy]
    return np.ascontiguousarray(total.transpose(2, 0, 1))


def distinct(proposals: Sequence[Proposal], most: int) -> list[Proposal]:
    """The best ``most`` of proposals that do not lie on each other, best first."""
    boxes: Floats = np.array([proposal.box_px for proposal in proposals]).reshape(-1, 4)
    left = np.argsort([-proposal.score for proposal in proposals], kind="stable")
    area = (boxes[:, 2:] - boxes[:, :2]).prod(axis=1)
    kept: list[Proposal] = []
    while len(left) and len(kept) < most:
        best, left = int(left[0]), left[1:]
        kept.append(proposals[best])
        low, high = np.maximum(boxes[best, :2], boxes[left, :2]), np.minimum(boxes[best, 2:], boxes[left, 2:])
        shared = np.clip(high - low, 0, None).prod(axis=1)
        left = left[shared <= _SAME * (area[best] + area[left] - shared)]
    return kept
