"""A photo and its face go in; the surroundings of the head at one fixed scale come out, and the way back to the photo.

The lengths of the thesis were chosen on faces about 200 px wide. Here every face is brought to that size, so they
apply as they stand, and neither the cost nor the drawing depends on how many pixels the photo has.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from limner.errors import BadInput
from limner.settings import SettingsGroup, setting
from limner.types import Face, Floats, Photo

SMALLEST_OUTER_EYE_PX = 8.0
"""Below this the eyes are a few pixels; enlarging them shows the resampling, not the person."""


@dataclass(frozen=True)
class ScaleSettings(SettingsGroup):
    """How large the face is when lines are looked for, and how much around it is looked at."""

    outer_eye_px: float = setting(
        128.0, "distance of the outer eye corners at which lines are looked for", unit="px", low=32, high=512
    )
    beside: float = setting(
        2.2, "seen left and right of the eyes, in outer-eye distances", unit="outer-eye distances", low=0.6, high=6
    )
    above: float = setting(2.3, "seen above the eyes", unit="outer-eye distances", low=0.6, high=6)
    below: float = setting(2.6, "seen below the eyes", unit="outer-eye distances", low=0.6, high=6)


@dataclass(frozen=True, eq=False)
class Working:
    """The surroundings of the head at the working scale.

    Attributes:
        photo: what is seen of the photo, resampled.
        face: the same face in its pixels.
        photo_from_working: (2, 3) affine map of its pixels to those of the photo, centres on integers in both.
    """

    photo: Photo
    face: Face
    photo_from_working: Floats


def to_working_scale(photo: Photo, face: Face, settings: ScaleSettings) -> Working:
    """Crop and resample the photo so that the outer eye corners are a fixed number of pixels apart.

    Shrinking averages areas, so that noise and fine texture go before lines are looked for; enlarging is cubic.
    The crop is whole pixels of the photo and mirrors with it.

    Args:
        photo: any size.
        face: a frontal face in the photo.
        settings: the scale and the crop.

    Raises:
        BadInput: a profile, a face of a few pixels, or one that lies outside the photo.
    """
    if face.outer_eye_px < SMALLEST_OUTER_EYE_PX:
        raise BadInput(
            f"face: the outer eye corners are {face.outer_eye_px:.3g} px apart, expected at least"
            f" {SMALLEST_OUTER_EYE_PX:g}; take a larger photo of the face"
        )
    x0, y0, x1, y1 = _crop(photo, face, settings)
    scale = settings.outer_eye_px / face.outer_eye_px
    size = max(1, round((x1 - x0) * scale)), max(1, round((y1 - y0) * scale))
    shrink = cv2.INTER_AREA if scale < 1 else cv2.INTER_CUBIC
    rgb = np.asarray(cv2.resize(photo.rgb[y0:y1, x0:x1], size, interpolation=shrink), np.uint8)
    photo_from_working = _resize_map((x1 - x0) / size[0], (y1 - y0) / size[1], x0, y0)
    return Working(Photo(rgb.reshape(size[1], size[0], 3)), _moved(face, photo_from_working), photo_from_working)


def scaled(photo: Photo, face: Face, scale: float) -> tuple[Photo, Face]:
    """All of a photo and its face in about another size."""
    width, height = photo.size_px
    size = max(1, round(width * scale)), max(1, round(height * scale))
    how = cv2.INTER_AREA if scale < 1 else cv2.INTER_CUBIC
    rgb = np.asarray(cv2.resize(photo.rgb, size, interpolation=how), np.uint8)
    back = _resize_map(width / size[0], height / size[1], 0, 0)
    return Photo(rgb.reshape(size[1], size[0], 3)), _moved(face, back)


def apply(affine: Floats, points: Floats) -> Floats:
    """Points (n, 2) through a (2, 3) affine map."""
    mapped: Floats = points @ affine[:, :2].T + affine[:, 2]
    return mapped


def _crop(photo: Photo, face: Face, settings: ScaleSettings) -> tuple[int, int, int, int]:
    """Whole pixels x0, y0, x1, y1 (the last excluded) around the head that lie within the photo."""
    width, height = photo.size_px
    unit = face.outer_eye_px
    eyes = face.points_px[36:48].mean(axis=0) + 0.5  # from pixel centres to pixel edges
    low = np.floor(eyes - unit * np.array([settings.beside, settings.above]))
    high = np.ceil(eyes + unit * np.array([settings.beside, settings.below]))
    low, high = np.clip(low, 0, None), np.clip(high, None, [width, height])
    if (high <= low).any():
        raise BadInput(
            f"face: its eyes at ({eyes[0]:.0f}, {eyes[1]:.0f}) px lie far outside the photo of"
            f" {width} x {height} px; the landmarks belong to another photo"
        )
    return int(low[0]), int(low[1]), int(high[0]), int(high[1])


def _resize_map(step_x: float, step_y: float, x0: int, y0: int) -> Floats:
    """Pixel centres after a resize to those before it: edges scale, and a centre is half a pixel from its edge."""
    return np.array([[step_x, 0, x0 + step_x / 2 - 0.5], [0, step_y, y0 + step_y / 2 - 0.5]])


def _moved(face: Face, photo_from_working: Floats) -> Face:
    working_from_photo = np.asarray(cv2.invertAffineTransform(photo_from_working), np.float64)
    return Face(
        points_px=apply(working_from_photo, face.points_px),
        box_px=apply(working_from_photo, face.box_px.reshape(2, 2)).ravel(),
        score=face.score,
        yaw_deg=face.yaw_deg,
        detector=face.detector,
    )
