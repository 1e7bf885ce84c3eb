"""A photo goes in, the faces that a flexible mixture of parts finds in it come out, largest first."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np

from limner.errors import BadInput
from limner.settings import SettingsGroup, setting
from limner.types import LANDMARK_COUNTS, Face, Floats, Photo
from limner.vision.landmarks.fmp.hog import Array, half_down
from limner.vision.landmarks.fmp.inference import Detection, search
from limner.vision.landmarks.fmp.matlab import import_matlab
from limner.vision.landmarks.fmp.model import FmpModel, default_model, load_model
from limner.vision.landmarks.fmp.pyramid import FILTER
from limner.vision.landmarks.fmp.refine import refine

NAME = "fmp"

_FIRST_SHARE = 0.2
"""Faces larger than this share of the photo's shorter side are looked for first, smaller ones only if there is none."""


@dataclass(frozen=True)
class FmpSettings(SettingsGroup):
    """How a flexible mixture of parts looks for faces."""

    model: str = setting(
        "", "File of the face model (.npz, or .mat of Zhu & Ramanan's release); empty for the one that is shipped"
    )
    threshold: float = setting(
        0.0, "Added to the least score of a face; lower finds more faces, and more that are none", low=-10, high=10
    )
    smallest: float = setting(
        0.1, "Smallest face to look for, as a share of the photo's shorter side", low=0.01, high=1
    )
    smallest_px: float = setting(40.0, "Smallest face to look for", unit="px", low=20, high=10_000)
    interval: int | None = setting(
        None, "Sizes tried from one size to its half; not set: as the model is meant to", low=1, high=20
    )
    overlap: float = setting(
        0.3, "Of two faces that share more than this of either's area the better one stays", low=0, high=1
    )
    refine: int = setting(
        3,
        "Sizes around the found one that landmarks are placed at, between the cells, and averaged;"
        " 0 leaves them on whole cells",
        low=0,
        high=9,
    )
    precision: str = setting("float32", "Numbers computed with", choices=("float32", "float64"))


def detect(photo: Photo, settings: FmpSettings) -> tuple[Face, ...]:
    """Find the faces, the large ones first, smaller ones only where there is none.

    Each range of sizes is searched in a copy of the photo just large enough for the smallest of them, so that neither
    time nor memory depends on how many pixels the photo has.

    Raises:
        BadInput: no usable model.
    """
    model = _model(settings.model)
    for small, large in _ranges_px(photo, settings):
        picture, pixel = _scaled(photo, model.smallest_face_px / small)
        found = search(
            picture,
            model,
            threshold=model.threshold + settings.threshold,
            interval=settings.interval,
            dtype=settings.precision,
            scale_range_px=(0, model.cell_px * large / small),
            overlap=settings.overlap,
        )
        if found:
            faces = [_face(_refined(picture, detection, model, settings), model, pixel) for detection in found]
            return tuple(sorted(faces, key=lambda face: -_area(face)))
    return ()


def looked_for(photo: Photo, settings: FmpSettings) -> str:
    """What ``detect`` looked for, for the message when there is none."""
    model = _model(settings.model)
    yaws = sorted({component.yaw_deg for component in model.components})
    view = "frontal" if yaws == [0] else f"turned {yaws[0]:+g} to {yaws[-1]:+g} degrees"
    small = _smallest_px(photo, settings)
    if small > min(photo.size_px):
        return f"{view} faces of {small:.0f} px or more, but the photo is {photo.size_px[0]} x {photo.size_px[1]} px"
    return f"{view} faces of {small:.0f} px or more with a score of at least {model.threshold + settings.threshold:.3g}"


def _model(path: str) -> FmpModel:
    if not path:
        return default_model()
    model = import_matlab(path) if path.lower().endswith(".mat") else load_model(path)
    for component in model.components:
        if len(component.parents) not in LANDMARK_COUNTS:
            raise BadInput(f"{path}: a face model of {len(component.parents)} parts; expected 68 or 39")
    return model


def _smallest_px(photo: Photo, settings: FmpSettings) -> float:
    return max(settings.smallest_px, settings.smallest * min(photo.size_px))


def _ranges_px(photo: Photo, settings: FmpSettings) -> Iterator[tuple[float, float]]:
    """From where to where the size of a face is looked for at a time: from large to small, each half the last."""
    smallest, side = _smallest_px(photo, settings), min(photo.size_px)
    large, small = math.inf, max(smallest, _FIRST_SHARE * side)
    while small <= side and large > smallest:
        yield small, large
        large, small = small, max(smallest, small / 2)


def _scaled(photo: Photo, scale: float) -> tuple[Array, Floats]:
    """The photo at another size (float32), and the size of its pixels x, y in those of the photo."""
    width, height = (max(1, half_down(length * scale)) for length in photo.size_px)
    way = cv2.INTER_AREA if scale < 1 else cv2.INTER_CUBIC
    planes = [
        cv2.resize(photo.rgb[..., channel].astype(np.float32), (width, height), interpolation=way)
        for channel in range(3)
    ]
    return cv2.merge(planes), np.array(photo.size_px) / (width, height)


def _refined(picture: Array, detection: Detection, model: FmpModel, settings: FmpSettings) -> Detection:
    if settings.refine == 0:
        return detection
    points = refine(picture, detection, model, settings.refine, settings.precision)
    return dataclasses.replace(detection, points_px=points)


def _face(detection: Detection, model: FmpModel, pixel: Floats) -> Face:
    """The detection in the photo, whose pixels are ``pixel`` times smaller than those that were searched."""
    component = model.components[detection.component]
    centres = (detection.points_px + 0.5) * pixel - 0.5
    half = FILTER / 2 * detection.scale_px * pixel
    points = np.empty_like(centres)
    points[component.landmarks] = centres
    box = np.concatenate([centres.min(axis=0) - half, centres.max(axis=0) + half])
    return Face(points, box, detection.score, component.yaw_deg, NAME)


def _area(face: Face) -> float:
    return float(np.prod(face.box_px[2:] - face.box_px[:2]))
