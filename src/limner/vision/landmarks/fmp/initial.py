"""Positives and some background in; a first model, part by part from their statistics, out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from limner.types import Floats
from limner.vision.landmarks.fmp.layout import SIZE
from limner.vision.landmarks.fmp.model import Component
from limner.vision.landmarks.fmp.positives import Positive
from limner.vision.landmarks.fmp.pyramid import FILTER
from limner.vision.landmarks.fmp.tree import Tree, chow_liu

LEAST_VARIANCE = 0.1
"""Floor of an offset's variance [cell^2]: landmarks lie in whole cells, so each is off by 1/12 cell^2 anyway."""


def shapes(positives: Sequence[Positive]) -> Floats:
    """(faces, 68, 2) landmarks in cells."""
    return np.stack([positive.cells for positive in positives])


def patch(features: NDArray[np.float32], x: int, y: int) -> NDArray[np.float32]:
    """What a filter at cell (x, y) sees: (SIZE,)."""
    return features[y : y + FILTER, x : x + FILTER].ravel()


@dataclass(frozen=True, eq=False)
class Background:
    """What filters see where there is no face: mean (SIZE,) and covariance (SIZE, SIZE) of its patches."""

    mean: Floats
    covariance: Floats

    @classmethod
    def of(cls, maps: Sequence[NDArray[np.float32]], count: int, rng: np.random.Generator) -> Background:
        """The statistics of ``count`` random patches of some HOG maps."""
        patches = np.empty((count, SIZE))
        for k in range(count):
            features = maps[int(rng.integers(len(maps)))]
            y, x = (int(rng.integers(side - FILTER + 1)) for side in features.shape[:2])
            patches[k] = patch(features, x, y)
        return cls(patches.mean(axis=0), np.cov(patches, rowvar=False))


def whitened_filters(
    positives: Sequence[Positive], landmarks: Sequence[int], background: Background
) -> tuple[Floats, Floats]:
    """Linear discriminants of each landmark's patch against the background, whose covariance both share.

    Hariharan, Malik & Ramanan 2012 (doi:10.1007/978-3-642-33765-9_33).

    Returns:
        Filters (parts, SIZE), and offsets (parts,) such that filter . patch + offset is the log odds.
    """
    ridge = _RIDGE * np.trace(background.covariance) / SIZE
    aligned = np.array([_mean_patch(positives, mark) for mark in landmarks])
    filters = np.linalg.solve(background.covariance + ridge * np.eye(SIZE), (aligned - background.mean).T).T
    return filters, -0.5 * ((aligned + background.mean) * filters).sum(axis=1)


_RIDGE = 0.01
"""Share of the mean variance that is added to all of the background's variances."""


def _mean_patch(positives: Sequence[Positive], landmark: int) -> Floats:
    """What stands at a landmark on average; where it is a guess in some faces, the others speak for them."""
    sure = [face for face in positives if face.sure[landmark]]
    mean: Floats = np.mean([_seen(face, landmark) for face in sure or positives], axis=0, dtype=np.float64)
    return mean


def _seen(positive: Positive, landmark: int) -> NDArray[np.float32]:
    x, y = np.round(positive.cells[landmark]).astype(int)
    rows, cols = positive.features.shape[:2]
    return patch(positive.features, int(np.clip(x, 0, cols - FILTER)), int(np.clip(y, 0, rows - FILTER)))


def springs(positives: Sequence[Positive], tree: Tree, stiffness: float) -> tuple[NDArray[np.int64], Floats, float]:
    """What holds the parts of a tree, from the mean and variance of their offsets.

    Returns:
        Anchors (n, 2) [whole cells]; springs (n, 4) whose cost is ``stiffness`` times the negative logarithm of the
        Gaussian density, up to a constant; and that constant (with the sign of a score).
    """
    points = shapes(positives)[:, list(tree.landmarks)]
    offset = points[:, 1:] - points[:, list(tree.parents[1:])]
    mean, variance = offset.mean(axis=0), np.maximum(offset.var(axis=0), LEAST_VARIANCE)
    anchors = np.vstack([np.zeros(2), np.round(mean)]).astype(np.int64)
    square = stiffness / (2 * variance)
    rest = mean - anchors[1:]
    rows = np.stack([square, 2 * square * rest], axis=2).reshape(-1, 4)
    constant = -(square * rest**2).sum() - stiffness / 2 * np.log(2 * np.pi * variance).sum()
    return anchors, np.vstack([np.zeros(4), rows]), float(constant)


def mixture(
    positives: Sequence[Positive],
    first_filter: int,
    yaw_deg: float,
    stiffness: float,
    background: Background,
    shared: tuple[Floats, Floats] | None = None,
) -> tuple[Floats, Component]:
    """A tree of parts from the statistics of the faces of one pose; its score is a log odds over ``SIZE``.

    Args:
        positives: the faces.
        first_filter: the number that its first filter has in the model's pool.
        yaw_deg: turn of the head.
        stiffness: of the springs; more than 1, since the parts overlap and are counted as if each stood alone.
        background: what is no face.
        shared: filters and offsets of all landmarks, in their order, that every mixture uses; None: its own.

    Returns:
        Filters (n, SIZE) in the order of the parts, none where they are shared, and the tree.
    """
    tree = chow_liu(shapes(positives), least_variance=LEAST_VARIANCE)
    marks = np.array(tree.landmarks)
    filters, odds = whitened_filters(positives, tree.landmarks, background) if shared is None else shared
    anchors, rows, constant = springs(positives, tree, stiffness)
    pool = first_filter + (np.arange(len(marks)) if shared is None else marks)
    bias = (float(odds.sum()) + constant) / SIZE
    own = filters if shared is None else np.zeros((0, SIZE))
    return own / SIZE, Component(yaw_deg, bias, np.array(tree.parents), pool, rows / SIZE, anchors, marks)
