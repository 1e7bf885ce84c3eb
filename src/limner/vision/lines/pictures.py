"""A photo and a face go in; a picture in colours comes out, in the styles that have one."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from limner.errors import BadInput
from limner.types import Face, Photo
from limner.vision.cartoon.style import abstracted
from limner.vision.figure import find_figure
from limner.vision.lines.settings import LineSettings
from limner.vision.painterly.style import painted
from limner.vision.scale import scaled

LARGEST_PICTURE_PX = 1600
"""Longer side of such a picture at most."""

PAINTED_UNIT_PX = 160.0
"""Distance of the outer eye corners in a painting at least, where that is not too large."""


def _painting(photo: Photo, face: Face, settings: LineSettings) -> NDArray[np.uint8]:
    """All of the photo; a small face is painted larger, or its eyes would be dabs."""
    grow = min(PAINTED_UNIT_PX / face.outer_eye_px, LARGEST_PICTURE_PX / max(photo.size_px))
    if grow > 1:
        photo, face = scaled(photo, face, grow)
    return painted(photo, face, settings.painterly, find_figure(photo, face, settings.figure).figure).canvas


PICTURES: dict[str, Callable[[Photo, Face, LineSettings], NDArray[np.uint8]]] = {
    "cartoon": lambda photo, face, settings: abstracted(photo, face, settings.cartoon).rgb(),
    "painterly": _painting,
}
"""Styles that have a picture in colours, too."""


def draw_picture(photo: Photo, face: Face, style: str, settings: LineSettings) -> NDArray[np.uint8]:
    """The picture in colours (H, W, 3) of a style that has one.

    Args:
        photo: any size; the picture of a large one is smaller, and of a small one may be larger.
        face: in it.
        style: one of ``PICTURES``.
        settings: of the style.

    Raises:
        BadInput: the style has none.
    """
    if style not in PICTURES:
        raise BadInput(f"style: '{style}' has no picture in colours; choose from {', '.join(PICTURES)}")
    scale = min(1.0, LARGEST_PICTURE_PX / max(photo.size_px))
    if scale < 1:
        photo, face = scaled(photo, face, scale)
    return PICTURES[style](photo, face, settings)
