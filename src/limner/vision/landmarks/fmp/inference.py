"""A picture and a model go in, every face the model sees in it comes out, best first."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import DTypeLike, NDArray

from limner.types import Floats
from limner.vision.landmarks.fmp.hog import Array
from limner.vision.landmarks.fmp.matching import Forest
from limner.vision.landmarks.fmp.model import FmpModel
from limner.vision.landmarks.fmp.pyramid import FILTER, PAD, Level, pyramid
from limner.vision.landmarks.fmp.response import responses
from limner.vision.landmarks.fmp.threads import in_parallel

_GROUP_CELLS = 10_000_000
"""Score maps held at once [cells of all parts]: trees are matched in groups of about this size."""


@dataclass(frozen=True, eq=False)
class Detection:
    """One configuration of parts.

    Attributes:
        score: of the whole, bias included.
        component: which of the model's.
        level: of the pyramid.
        scale_px: pixels per cell there.
        cells: (n, 2) x, y of each part's window in the padded map, 0-based.
        points_px: (n, 2) x, y of each part's centre in the picture, pixel centres on integers; exact, where the boxes
            share the release's nominal scale.
    """

    score: float
    component: int
    level: int
    scale_px: float
    cells: NDArray[np.int64]
    points_px: Floats

    @property
    def part_boxes(self) -> Floats:
        """(n, 4) x0, y0, x1, y1 of each part: first and last pixel as in Zhu & Ramanan's release, but 0-based."""
        start = (self.cells - (PAD - 1)) * self.scale_px
        return np.concatenate([start, start + (FILTER * self.scale_px - 1)], axis=1)

    @property
    def box(self) -> Floats:
        """(4,) x0, y0, x1, y1 around all parts, as ``part_boxes``."""
        boxes = self.part_boxes
        return np.concatenate([boxes[:, :2].min(axis=0), boxes[:, 2:].max(axis=0)])


@dataclass(frozen=True)
class SearchSettings:
    """What of a picture is searched, and how closely.

    Attributes:
        threshold: least score; None for the model's own.
        interval: levels of the pyramid per octave; None for the model's own.
        dtype: float64, or float32 for speed.
        scale_range_px: pixels per cell, from and to: faces come in at ``model.face_cells`` times this.
        overlap: of two faces that share more than this of either's area the better one stays.
    """

    threshold: float | None = None
    interval: int | None = None
    dtype: DTypeLike = np.float32
    scale_range_px: tuple[float, float] = (0.0, math.inf)
    overlap: float = 0.3

    def least_score(self, model: FmpModel) -> float:
        """Of a face of this model."""
        return model.threshold if self.threshold is None else self.threshold

    def levels_per_octave(self, model: FmpModel) -> int:
        """Of the pyramid in which this model is looked for."""
        return self.interval or model.interval


EVERYTHING = SearchSettings()
"""Faces of any size, as the model is meant to find them."""


def search(image: Array, model: FmpModel, settings: SearchSettings = EVERYTHING) -> list[Detection]:
    """Find all configurations of parts above the threshold that no better one covers.

    Args:
        image: (H, W, 3), values 0..255.
        model: what to look for.
        settings: where and how closely.

    Returns:
        Best first.
    """
    threshold, interval = settings.least_score(model), settings.levels_per_octave(model)
    levels = pyramid(
        image, interval, cell_px=model.cell_px, dtype=settings.dtype, scale_range_px=settings.scale_range_px
    )
    found = [
        candidates
        for some in in_parallel(lambda level: list(_candidates(level, model, threshold)), levels)
        for candidates in some
    ]
    if not found:
        return []
    boxes = np.concatenate([_clipped(candidates.boxes, image.shape) for candidates in found])
    scores = np.concatenate([candidates.scores for candidates in found])
    owner = np.repeat(np.arange(len(found)), [len(candidates.scores) for candidates in found])
    first = np.searchsorted(owner, np.arange(len(found)))
    return [found[owner[k]].detection(k - first[owner[k]]) for k in _keep(boxes, scores, settings.overlap)]


def search_level(level: Level, model: FmpModel, threshold: float) -> Iterator[Detection]:
    """Every configuration above the threshold on one map of the pyramid, the best one for each place of the root."""
    for candidates in _candidates(level, model, threshold):
        yield from map(candidates.detection, range(len(candidates.scores)))


@dataclass(frozen=True, eq=False)
class _Candidates:
    """Configurations of one component on one level: scores (M,) and cells (M, n, 2), as in ``Detection``."""

    level: Level
    component: int
    scores: Array
    cells: NDArray[np.int64]

    @property
    def boxes(self) -> Floats:
        """(M, 4) the box around all parts of each."""
        low = (self.cells.min(axis=1) - (PAD - 1)) * self.level.scale_px
        high = (self.cells.max(axis=1) - (PAD - 1) + FILTER) * self.level.scale_px - 1
        return np.concatenate([low, high], axis=1)

    def detection(self, k: int) -> Detection:
        score, cells, level = float(self.scores[k]), self.cells[k], self.level
        return Detection(score, self.component, level.index, level.scale_px, cells, level.centres_px(cells))


def _candidates(level: Level, model: FmpModel, threshold: float) -> Iterator[_Candidates]:
    used = np.unique(np.concatenate([component.filters for component in model.components]))
    fits = responses(level.features, model.filters[used])
    for first, forest in _groups(model, fits[0].size):
        match = forest.match(fits[np.searchsorted(used, forest.filters)])
        for tree, scores in enumerate(match.roots):
            y, x = np.nonzero(scores >= threshold)
            if len(y):
                cells = match.places(tree, np.stack([x, y], axis=1))
                yield _Candidates(level, first + tree, scores[y, x], cells)


def _groups(model: FmpModel, cells: int) -> Iterator[tuple[int, Forest]]:
    """The components in groups whose score maps are not too large together, each with the index of its first."""
    first, parts = 0, 0
    for k, component in enumerate(model.components):
        n = len(component.parents)
        if k > first and (parts + n) * cells > _GROUP_CELLS:
            yield first, Forest(model.components[first:k])
            first, parts = k, 0
        parts += n
    yield first, Forest(model.components[first:])


def suppress(found: list[Detection], size: tuple[int, ...], overlap: float) -> list[Detection]:
    """Keep the best of detections that cover each other.

    Args:
        found: in any order.
        size: height and width of the picture, which the boxes are clipped to [px].
        overlap: share of either box's area above which the worse one is dropped.

    Returns:
        Best first; of equals the first given.
    """
    if not found:
        return []
    around = np.array([detection.box for detection in found])
    scores = np.array([detection.score for detection in found])
    return [found[k] for k in _keep(_clipped(around, size), scores, overlap)]


def _clipped(boxes: Floats, size: tuple[int, ...]) -> Floats:
    """Boxes x0, y0, x1, y1 (first and last pixel) as far as they lie in a picture of ``size`` (height, width)."""
    low, high = np.maximum(boxes[:, :2], 0), np.minimum(boxes[:, 2:], (size[1] - 1, size[0] - 1))
    return np.concatenate([low, high], axis=1)


def _keep(boxes: Floats, scores: Array, overlap: float) -> list[int]:
    area = np.clip(boxes[:, 2:] - boxes[:, :2] + 1, 0, None).prod(axis=1)
    left = np.argsort(-scores, kind="stable")
    kept = []
    while len(left):
        best, left = int(left[0]), left[1:]
        kept.append(best)
        low, high = np.maximum(boxes[best, :2], boxes[left, :2]), np.minimum(boxes[best, 2:], boxes[left, 2:])
        shared = np.clip(high - low + 1, 0, None).prod(axis=1)
        left = left[shared <= overlap * np.minimum(area[best], area[left])]
    return kept
