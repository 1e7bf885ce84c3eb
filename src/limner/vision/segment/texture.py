"""A photo goes in; how much its lightness changes over a few pixels comes out: much in hair, little on a wall."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from limner.types import Photo
from limner.vision.raster import blurred, resized

Levels = NDArray[np.int64]

COARSEST = 0.02
"""Changes over more than this are shading [outer-eye distances]."""

LEVELS = 8
"""Levels of texture, from smooth as a wall to rough as fur."""

SMOOTHEST, ROUGHEST = 0.003, 0.12
"""Mean change of lightness at the ends of the levels, as a share of the photo's own range."""

LEAST_RANGE = 25.0
"""A photo with a smaller range of lightness (of 255) is not stretched further: that would be noise."""


def texture(photo: Photo, size: tuple[int, int], outer_eye_px: float) -> Levels:
    """The level of texture (H, W), 0 to ``LEVELS`` - 1, the same in a darker photo.

    Args:
        photo: in full size, since a small copy has lost its texture.
        size: width and height of the result.
        outer_eye_px: size of the face in the photo.
    """
    light = np.asarray(cv2.cvtColor(photo.rgb, cv2.COLOR_RGB2LAB)[..., 0], np.float32)
    low, high = np.percentile(light[::4, ::4], [1, 99])
    change = np.abs(light - blurred(light, COARSEST * outer_eye_px)) / np.float32(max(high - low, LEAST_RANGE))
    mean = blurred(resized(change, size, cv2.INTER_AREA), 1.0)
    level = np.log(mean / SMOOTHEST + 1e-6) / np.log(ROUGHEST / SMOOTHEST) * LEVELS
    levels: Levels = np.clip(level, 0, LEVELS - 1).astype(np.int64)
    return levels
