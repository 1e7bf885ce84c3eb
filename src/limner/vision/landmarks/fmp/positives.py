"""Annotated faces in; HOG maps of them at the model's scale, in many views, with each landmark's cell, out."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from limner.errors import BadInput
from limner.types import Floats
from limner.vision.landmarks.fmp.dataset import Sample, transform
from limner.vision.landmarks.fmp.hog import hog
from limner.vision.landmarks.fmp.pyramid import FILTER, PAD, padded, resize
from limner.vision.landmarks.fmp.turning import turn
from limner.vision.landmarks.mirror import MIRROR

MARGIN_CELLS = 7
"""Picture around the outermost landmarks: room for half a filter and for parts that stray."""


@dataclass(frozen=True)
class View:
    """How a face is shown.

    Attributes:
        mirrored: first of all.
        yaw_deg: turn of the head that is shown; positive = the nose points to image right.
        tilt_deg: slope of the eyes that is shown; positive = clockwise.
        zoom: factor on the template's size.
        shift_px: of the picture against the cells, x, y.
        pose: which mixture it is for.
    """

    mirrored: bool = False
    yaw_deg: float = 0.0
    tilt_deg: float = 0.0
    zoom: float = 1.0
    shift_px: tuple[float, float] = (0.0, 0.0)
    pose: int = 0


@dataclass(frozen=True, eq=False)
class Positive:
    """A face at the model's scale.

    Attributes:
        features: (rows, cols, 32) float32, padded as levels of a pyramid are.
        cells: (68, 2) x, y of the filter's top-left cell in ``features`` that would centre it on each landmark;
            fractions of cells.
        sure: (68,) which landmarks are more than a guess.
        pose: which mixture it is for.
        name: of the photo.
        person: who it is.
    """

    features: NDArray[np.float32]
    cells: Floats
    sure: NDArray[np.bool_]
    pose: int
    name: str
    person: str


def show(sample: Sample, image: NDArray[Any], views: Sequence[View], eye_cells: float, cell_px: int) -> list[Positive]:
    """HOG maps of one face.

    Args:
        sample: its landmarks, all known.
        image: (H, W, 3) the whole photo.
        views: how to show it.
        eye_cells: distance of the outer eye corners at zoom 1, for a face seen from the front [cells].
        cell_px: side of a cell [px].

    Raises:
        BadInput: a landmark is not known.
    """
    if not sample.known.all():
        raise BadInput(f"{sample.path}: {int((~sample.known).sum())} of 68 landmarks are not known")
    eye_px = sample.outer_eye_px / np.cos(np.radians(sample.yaw_deg))
    result = []
    for view in views:
        scale = eye_cells * cell_px * view.zoom / eye_px
        picture, points = render(sample, image, view, scale, MARGIN_CELLS * cell_px)
        features = padded(hog(picture, cell_px, np.float32))
        sure = ~(sample.guessed[MIRROR] if view.mirrored else sample.guessed)
        cells = points_to_cells(points, cell_px)
        result.append(Positive(features, cells, sure, view.pose, sample.path.name, sample.person))
    return result


def render(
    sample: Sample, image: NDArray[Any], view: View, scale: float, margin_px: int
) -> tuple[NDArray[np.float32], Floats]:
    """The face as ``view`` shows it, ``scale`` times as large as in the photo: a picture and the landmarks in it."""
    small, start, shrink = _scaled(image, sample.points_px, min(scale, 1.0))
    points = (sample.points_px - start + 0.5) * shrink - 0.5
    matrix = _matrix(view, scale / float(shrink.mean()), sample.tilt_deg)
    placed = transform(matrix, points)
    if view.mirrored:
        placed = placed[MIRROR]
    low, high = placed.min(axis=0) - margin_px, placed.max(axis=0) + margin_px
    matrix[:, 2] += np.array(view.shift_px) - np.floor(low)
    placed += np.array(view.shift_px) - np.floor(low)
    width, height = (int(side) for side in np.ceil(high - low))
    aside = view.yaw_deg - (-sample.yaw_deg if view.mirrored else sample.yaw_deg)
    turned = turn(placed, aside, (width, height))
    back = cv2.invertAffineTransform(matrix)
    map_x = (back[0, 0] * turned.back_x + back[0, 1] * turned.back_y + back[0, 2]).astype(np.float32)
    map_y = (back[1, 0] * turned.back_x + back[1, 1] * turned.back_y + back[1, 2]).astype(np.float32)
    picture = cv2.remap(small, map_x, map_y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(picture, np.float32), turned.points


def _scaled(image: NDArray[Any], points: Floats, scale: float) -> tuple[NDArray[Any], Floats, Floats]:
    """The face and its surroundings at ``scale`` (area averages), where the cut starts, and the exact scale (x, y)."""
    low, high = points.min(axis=0), points.max(axis=0)
    reach = (high - low).max()
    start = np.maximum(low - reach, 0).astype(int)
    stop = np.minimum(high + reach, image.shape[1::-1]).astype(int)
    cut = np.ascontiguousarray(image[start[1] : stop[1], start[0] : stop[0]]).astype(np.float32)
    small = resize(cut, scale)
    return small, start.astype(np.float64), np.array(small.shape[1::-1]) / np.array(cut.shape[1::-1])


def _matrix(view: View, scale: float, tilt_deg: float) -> Floats:
    """Mirror, then turn in the picture plane to the wanted tilt, and scale: (2, 3)."""
    angle = np.radians(view.tilt_deg - (-tilt_deg if view.mirrored else tilt_deg))
    matrix = scale * np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0]])
    return matrix * [-1, 1, 1] if view.mirrored else matrix


def points_to_cells(points: Floats, cell_px: float) -> Floats:
    """Where (in a padded map) a filter's top-left cell must be to centre the filter on each point, in cells.

    The map's cell PAD covers the pixels from ``cell_px`` on (the outermost cells of the picture are left out).
    """
    return (points + 0.5) / cell_px - 1 - FILTER / 2 + PAD


def cells_to_points(cells: Floats, cell_px: float) -> Floats:
    """The inverse of ``points_to_cells``."""
    return (cells - PAD + FILTER / 2 + 1) * cell_px - 0.5


@dataclass(frozen=True)
class Pose:
    """The view of a mixture, and how far the faces it learns from may be off it."""

    yaw_deg: float = 0.0
    tilt_deg: float = 0.0
    yaw_reach_deg: float = 0.0
    tilt_reach_deg: float = 0.0


def views(poses: Sequence[Pose], count: int, zoom: float, rng: np.random.Generator) -> Iterator[View]:
    """``count`` random views around each pose, and as many of the mirrored face, zoomed by up to ``zoom``."""
    for k, pose in enumerate(poses):
        for mirrored in (False, True) * count:
            yaw = pose.yaw_deg + pose.yaw_reach_deg * rng.uniform(-1, 1)
            tilt = pose.tilt_deg + pose.tilt_reach_deg * rng.uniform(-1, 1)
            shift = (float(rng.uniform(0, 4)), float(rng.uniform(0, 4)))
            yield View(mirrored, yaw, tilt, float(zoom ** rng.uniform(-1, 1)), shift, k)
