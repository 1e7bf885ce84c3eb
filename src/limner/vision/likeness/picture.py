"""A photo or strokes and a face's landmarks in them go in; a small grey picture of that face, upright, comes out.

Photos and drawings of all people come at one size with eyes and nose at one place, so that they can be compared.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from limner.types import Floats, Photo
from limner.vision.raster import Image, whole
from limner.vision.refine.shape import inverse, moved, shipped_shape, similarity

OUTER_EYE_PX = 64.0
"""Distance of the outer eye corners: lines of 0.5 mm on a face of 200 mm are half a pixel wide there."""

SIZE_PX = (192, 208)
"""Width and height: the face from the hairline to below the chin, and the ears."""

EYES_PX = (96.0, 83.0)
"""The middle between the outer eye corners."""

STILL = slice(27, 48)
"""The landmarks of nose and eyes, which a smile hardly moves."""

PAPER = 255.0

_FINE = 4  # sub-pixels across a pixel when strokes are drawn
_SHIFT = 4  # bits of fraction in OpenCV's coordinates
_BORDER_PX = 4


def upright_from_photo(points_px: Floats) -> Floats:
    """The turn, scale and shift (2, 3) that lays the eyes and nose of a face where they are in every such picture.

    Args:
        points_px: (68, 2) landmarks; only those of eyes and nose count.

    Raises:
        BadInput: they are one point.
    """
    mean = shipped_shape().mean
    middle = (mean[36] + mean[45]) / 2
    return similarity(points_px[STILL], (mean[STILL] - middle) * OUTER_EYE_PX + np.array(EYES_PX))


def photo_picture(photo: Photo, upright: Floats) -> Image:
    """The face (H, W) in a photo, grey; paper where the photo shows none of it.

    Args:
        photo: any size.
        upright: (2, 3), of ``upright_from_photo``.
    """
    corners = moved(np.array([[0, 0], [1, 0], [0, 1], [1, 1]]) * SIZE_PX, inverse(upright))
    low = np.clip(np.floor(corners.min(axis=0)) - _BORDER_PX, 0, photo.size_px).astype(int)
    high = np.clip(np.ceil(corners.max(axis=0)) + _BORDER_PX, 0, photo.size_px).astype(int)
    if (high <= low).any():
        return np.full(SIZE_PX[::-1], PAPER, np.float32)
    grey = cv2.cvtColor(photo.rgb[low[1] : high[1], low[0] : high[0]], cv2.COLOR_RGB2GRAY)
    scale = float(np.hypot(*upright[:, 0]))
    size = np.maximum(np.rint((high - low) * min(scale, 1.0)), 1).astype(int)
    small = cv2.resize(grey, (int(size[0]), int(size[1])), interpolation=cv2.INTER_AREA)
    step = (high - low) / size  # photo pixels for each pixel of `small`
    to_photo = np.column_stack([np.diag(step), low + step / 2 - 0.5])
    chained = np.column_stack([upright[:, :2] @ to_photo[:, :2], moved(to_photo[:, 2:].T, upright)[0]])
    return np.asarray(cv2.warpAffine(small, chained, SIZE_PX, borderMode=cv2.BORDER_REPLICATE), np.float32)


def drawing_picture(lines_px: Sequence[Floats], pen_px: float, upright: Floats) -> Image:
    """The face (H, W) in a drawing, black lines on paper.

    Args:
        lines_px: polylines (n, 2) in the pixels of the photo.
        pen_px: width of the line in these pixels.
        upright: (2, 3), of ``upright_from_photo``.
    """
    ink: NDArray[np.uint8] = np.zeros((SIZE_PX[1] * _FINE, SIZE_PX[0] * _FINE), np.uint8)
    width = max(1, round(pen_px * float(np.hypot(*upright[:, 0])) * _FINE))
    fine = [
        whole(((moved(line if len(line) > 1 else line.repeat(2, axis=0), upright) + 0.5) * _FINE - 0.5) * 2**_SHIFT)
        for line in lines_px
    ]
    cv2.polylines(ink, fine, isClosed=False, color=(255,), thickness=width, lineType=cv2.LINE_8, shift=_SHIFT)
    return np.float32(PAPER) - np.asarray(cv2.resize(ink, SIZE_PX, interpolation=cv2.INTER_AREA), np.float32)
