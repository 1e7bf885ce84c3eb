"""What every correction stands on: the grey face at one scale, pictures read between pixels, landmarks put back."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from limner.types import Face, Floats, Photo
from limner.vision.head import face_frame
from limner.vision.raster import Image, blurred
from limner.vision.scale import ScaleSettings, apply, to_working_scale

UNIT_PX = 128.0
"""Outer-eye distance of the face when corrections look at it [px]; the thesis's faces had about 150."""

_AROUND = ScaleSettings(outer_eye_px=UNIT_PX, beside=1.4, above=1.1, below=2.1)


@dataclass(frozen=True, eq=False)
class Grey:
    """The surroundings of a face at the scale of corrections.

    Attributes:
        image: (H, W) float32, 0 to 255.
        points: (68, 2) the landmarks in its pixels.
        down: (2,) unit vector from the eyes to the chin, at right angles to the line of the eyes.
        photo_from_grey: (2, 3) affine map of its pixels to those of the photo.
    """

    image: Image
    points: Floats
    down: Floats
    photo_from_grey: Floats


def grey_face(photo: Photo, face: Face) -> Grey:
    """Bring a face to the scale of corrections.

    Raises:
        BadInput: a profile, a face of a few pixels, or one that lies outside the photo.
    """
    working = to_working_scale(photo, face, _AROUND)
    image = np.asarray(cv2.cvtColor(working.photo.rgb, cv2.COLOR_RGB2GRAY), np.float32)
    down = face_frame(working.face).axes_px[1]
    return Grey(image, working.face.points_px, down / np.hypot(*down), working.photo_from_working)


def gradient(image: Image, sigma_px: float) -> tuple[Image, Image]:
    """The slope of a picture along x and along y (H, W) after a Gaussian blur [grey levels per px]."""
    smooth = blurred(image, sigma_px) if sigma_px > 0 else image
    along_x, along_y = (cv2.Sobel(smooth, cv2.CV_32F, dx, 1 - dx, scale=1 / 8) for dx in (1, 0))
    return np.asarray(along_x, np.float32), np.asarray(along_y, np.float32)


def read(image: Image, points: Floats) -> Floats:
    """The picture (...) at points (..., 2), linear between pixels, its border continued."""
    flat = np.asarray(points, np.float32).reshape(1, -1, 2)
    values = cv2.remap(image, flat[..., 0], flat[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(values, np.float64).reshape(points.shape[:-1])


def put_back(photo: Photo, face: Face, grey: Grey, which: NDArray[np.intp], points: Floats) -> Face:
    """The face with the landmarks ``which`` moved to ``points`` of the grey picture."""
    moved = face.points_px.copy()
    moved[which] = apply(grey.photo_from_grey, points)
    return with_points(photo, face, moved)


def with_points(photo: Photo, face: Face, points_px: Floats) -> Face:
    """The face with other landmarks; none that moved ends outside the photo, one that is no number stays."""
    points = np.where(np.isfinite(points_px), points_px, face.points_px)
    stays = np.abs(points - face.points_px).max(axis=1) < 1e-9
    inside = np.clip(points, 0, np.array(photo.size_px) - 1.0)
    return dataclasses.replace(face, points_px=np.where(stays[:, None], face.points_px, inside))
