"""Photo and face in; the face with its jaw moved to where the picture changes most, out (thesis 3.3.1)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from limner.settings import SettingsGroup, setting
from limner.types import Face, Floats, Photo
from limner.vision.raster import Image, blurred
from limner.vision.refine.ground import UNIT_PX, gradient, grey_face, put_back, read

_STEP_PX = 0.5


@dataclass(frozen=True)
class JawGradientSettings(SettingsGroup):
    """Where the jaw's edge is looked for; lengths in outer-eye distances."""

    reach: float = setting(
        0.16,
        "how far along the gradient the edge is looked for, to both sides",
        unit="outer-eye distances",
        low=0,
        high=1,
    )
    beside: float = setting(
        0.01, "how far across the gradient it is looked for", unit="outer-eye distances", low=0, high=0.5
    )
    blur: float = setting(0.01, "blur before the slope is taken", unit="outer-eye distances", low=0, high=0.2)
    ears: int = setting(3, "landmarks next to each ear that stay: hair and ear disturb there", low=0, high=8)


def jaw_gradient(photo: Photo, face: Face, settings: JawGradientSettings) -> Face:
    """Move each landmark of the jaw to the largest gradient magnitude in a rectangle along the gradient's direction.

    Raises:
        BadInput: a profile, a face of a few pixels, or one that lies outside the photo.
    """
    grey = grey_face(photo, face)
    which = np.arange(settings.ears, 17 - settings.ears)
    slope = gradient(grey.image, settings.blur * UNIT_PX)
    magnitude = np.hypot(*slope).astype(np.float32)
    directions = _directions(slope, grey.points[which], settings.reach * UNIT_PX)
    found = [
        _strongest(magnitude, point, along, settings)
        for point, along in zip(grey.points[which], directions, strict=True)
    ]
    return put_back(photo, face, grey, which, np.array(found))


def _directions(slope: tuple[Image, Image], points: Floats, reach_px: float) -> Floats:
    """Unit vectors (n, 2) along the prevailing gradient around each point (structure tensor); (0, 0) where flat.

    The slope at the point itself is mostly noise, since a point to be corrected is not on the edge.
    """
    x, y = slope
    xx, yy, xy = (read(blurred(product, max(reach_px / 2, 1)), points) for product in (x * x, y * y, x * y))
    angle = np.arctan2(2 * xy, xx - yy) / 2
    along = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return np.where((xx + yy > 1e-6)[:, None], along, 0.0)


def _strongest(magnitude: Image, point: Floats, along: Floats, settings: JawGradientSettings) -> Floats:
    """The place of the largest value in the rectangle; of equal ones the nearest to the point."""
    offsets = _symmetric(settings.reach * UNIT_PX)
    aside = _symmetric(settings.beside * UNIT_PX)
    across = np.array([-along[1], along[0]])
    grid = point + offsets[:, None, None] * along + aside[None, :, None] * across
    values = np.round(read(magnitude, grid), 6)
    far = np.hypot(*(grid - point).transpose(2, 0, 1))
    best = np.lexsort((far.ravel(), -values.ravel()))[0]
    place: Floats = grid.reshape(-1, 2)[best]
    return place


def _symmetric(reach_px: float) -> Floats:
    count = int(reach_px / _STEP_PX)
    offsets: Floats = _STEP_PX * np.arange(-count, count + 1, dtype=np.float64)
    return offsets
