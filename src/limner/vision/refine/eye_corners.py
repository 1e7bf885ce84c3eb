"""Photo and face in; the face with its eye corners moved to corners of the picture, out (thesis 3.3.4)."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from limner.settings import SettingsGroup, setting
from limner.types import Face, Floats, Photo
from limner.vision.raster import Image, filtered
from limner.vision.refine.ground import UNIT_PX, grey_face, put_back

EYE_CORNERS = np.array([36, 39, 42, 45])

SHARPEN = np.array(
    [[-0.166, -0.666, -0.166], [-0.666, 4.333, -0.666], [-0.166, -0.666, -0.166]],
    np.float32,
)
"""The unsharp kernel of the thesis."""

_HARRIS_K = 0.04
_HARRIS_LEAST = 0.01  # of the strongest response around


@dataclass(frozen=True)
class EyeCornersSettings(SettingsGroup):
    """What a corner is and how far it may be; lengths in outer-eye distances."""

    detector: str = setting(
        "harris",
        "harris = Harris & Stephens 1988, between pixels; fast = the sharpened picture, then FAST (Rosten 2006)",
        choices=("harris", "fast"),
    )
    threshold: int = setting(20, "FAST: least difference of the ring of pixels to its centre", low=1, high=254)
    window: float = setting(
        0.04, "Harris: the window over which slopes are gathered", unit="outer-eye distances", low=0.01, high=0.3
    )
    reach: float = setting(
        0.1, "a corner farther away than this is another one", unit="outer-eye distances", low=0, high=1
    )


def eye_corners(photo: Photo, face: Face, settings: EyeCornersSettings) -> Face:
    """Move both corners of each eye to the nearest corner of the picture; a landmark with none around stays.

    Raises:
        BadInput: a profile, a face of a few pixels, or one that lies outside the photo.
    """
    grey = grey_face(photo, face)
    corners = fast_corners(grey.image, settings) if settings.detector == "fast" else _harris(grey.image, settings)
    nearest = _nearest(grey.points[EYE_CORNERS], corners, settings.reach * UNIT_PX)
    return put_back(photo, face, grey, EYE_CORNERS, nearest)


def _nearest(points: Floats, corners: Floats, reach_px: float) -> Floats:
    if not len(corners):
        return points
    far = np.hypot(*(points[:, None] - corners).transpose(2, 0, 1))
    return np.where((far.min(axis=1) <= reach_px)[:, None], corners[far.argmin(axis=1)], points)


def fast_corners(image: Image, settings: EyeCornersSettings) -> Floats:
    """Corners (n, 2) that FAST finds in a sharpened grey picture [px]."""
    sharp = np.clip(np.rint(filtered(image, SHARPEN)), 0, 255).astype(np.uint8)
    found = cv2.FastFeatureDetector.create(settings.threshold, nonmaxSuppression=True).detect(sharp)
    return np.array([corner.pt for corner in found], np.float64).reshape(-1, 2)


def _harris(image: Image, settings: EyeCornersSettings) -> Floats:
    window = max(2, round(settings.window * UNIT_PX))
    response = np.asarray(cv2.cornerHarris(image, window, 3, _HARRIS_K), np.float32)
    peaks = (response == cv2.dilate(response, np.ones((3, 3), np.uint8))) & (response > _HARRIS_LEAST * response.max())
    corners = np.argwhere(peaks)[:, ::-1].astype(np.float32)
    if not len(corners) or min(image.shape) < 2 * window + 5:
        return corners.astype(np.float64)
    stop = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_MAX_ITER, 40, 0.001)
    eight_bit = np.clip(np.rint(image), 0, 255).astype(np.uint8)
    exact = cv2.cornerSubPix(eight_bit, corners[:, None].copy(), (window, window), (-1, -1), stop)
    return np.asarray(exact, np.float64).reshape(-1, 2)
