"""Scenes and a model in; the configurations that it takes for faces and should not, with their features, out."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from limner.types import Floats
from limner.vision.landmarks.fmp.inference import Detection, search_level, suppress
from limner.vision.landmarks.fmp.layout import features
from limner.vision.landmarks.fmp.model import FmpModel
from limner.vision.landmarks.fmp.positives import cells_to_points
from limner.vision.landmarks.fmp.pyramid import Level, pyramid, resize
from limner.vision.landmarks.fmp.scenes import Scene

RIGHT = 0.3
"""A configuration that overlaps a face's box (intersection over union) by more is not wrong."""

CROWDED = 0.5
"""Of two configurations on one level that share more than this of either's area only the better one is kept."""


@dataclass(frozen=True, eq=False)
class Negative:
    """A configuration that is no face.

    Attributes:
        scene: its name.
        found: where.
        clear: whether it touches no face at all.
        features: what the weights of its mixture meet there.
    """

    scene: str
    found: Detection
    clear: bool
    features: NDArray[np.float32]

    def scored(self, score: float) -> Negative:
        """The same with another score."""
        return dataclasses.replace(self, found=dataclasses.replace(self.found, score=score))


def levels(scene: Scene, size_px: int, interval: int, cell_px: int) -> tuple[list[Level], Floats]:
    """The HOG pyramid of a scene whose longer side is brought down to ``size_px``, and its faces' boxes there."""
    picture = np.asarray(scene.read(), np.float32)
    shrink = min(1.0, size_px / max(picture.shape[:2]))
    picture = resize(picture, shrink)
    return list(pyramid(picture, interval, cell_px=cell_px, dtype=np.float32)), scene.faces_px * shrink


def mine(scene: Scene, model: FmpModel, threshold: float, size_px: int, interval: int, most: int) -> list[Negative]:
    """The ``most`` best wrong configurations of a scene above the threshold, and the best clear one; best first."""
    maps, faces = levels(scene, size_px, interval, model.cell_px)
    found = [negative for level in maps for negative in _mine_level(scene.name, level, model, threshold, faces)]
    found.sort(key=lambda negative: -negative.found.score)
    return found[:most] + [negative for negative in found[most:] if negative.clear][:1]


def _mine_level(name: str, level: Level, model: FmpModel, threshold: float, faces: Floats) -> Iterator[Negative]:
    everywhere = (2**30, 2**30)
    wrong = [found for found in search_level(level, model, threshold) if not is_right(found, faces)]
    for found in suppress(wrong, everywhere, CROWDED):
        row = features(model.components[found.component], level.features, found.cells)
        yield Negative(name, found, not _share(found, faces), row)


def points_of(found: Detection) -> Floats:
    """(n, 2) the parts' centres in the photo, in the order of the parts."""
    return cells_to_points(found.cells.astype(np.float64), found.scale_px)


def box_of(points: Floats) -> Floats:
    """(4,) x0, y0, x1, y1 around points."""
    return np.concatenate([points.min(axis=0), points.max(axis=0)])


def is_right(found: Detection, faces: Floats) -> bool:
    """Whether a configuration lies on a face."""
    return _share(found, faces) > RIGHT


def _share(found: Detection, faces: Floats) -> float:
    """The largest overlap of a configuration with a face."""
    box = box_of(points_of(found))
    return max((overlap(box, face) for face in faces), default=0.0)


def overlap(a: NDArray[Any], b: NDArray[Any]) -> float:
    """Intersection over union of two boxes x0, y0, x1, y1."""
    shared = float(np.clip(np.minimum(a[2:], b[2:]) - np.maximum(a[:2], b[:2]), 0, None).prod())
    whole = float((a[2:] - a[:2]).prod() + (b[2:] - b[:2]).prod()) - shared
    return shared / whole if whole > 0 else 0.0
