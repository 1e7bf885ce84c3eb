"""A photo and a box or a size go in; a part of it, or a smaller copy, comes out."""

from __future__ import annotations

import numpy as np
from PIL import Image

from limner.errors import BadInput
from limner.types import Photo

Box = tuple[int, int, int, int]
"""x, y, width, height [px], x and y of the upper left pixel."""


def crop_photo(photo: Photo, box: Box) -> Photo:
    """The part of a photo in ``box`` = (x, y, width, height) [px], x and y of its upper left pixel.

    Raises:
        BadInput: the box is not whole pixels, is empty, or leaves the photo.
    """
    width, height = photo.size_px
    try:
        x, y, w, h = (int(value) for value in box)
        whole = (x, y, w, h) == tuple(box)
    except (TypeError, ValueError, OverflowError):
        whole = False
    if not whole:
        raise BadInput(f"crop: expected four whole numbers x, y, width, height [px], got {box!r}")
    if x < 0 or y < 0 or w < 1 or h < 1 or x + w > width or y + h > height:
        raise BadInput(
            f"crop: {x},{y},{w},{h} leaves the photo; expected x and y from 0, width and height from 1,"
            f" x + width up to {width} and y + height up to {height} px"
        )
    return Photo(photo.rgb[y : y + h, x : x + w])


def shrink_photo(photo: Photo, side_px: int) -> Photo:
    """The photo with no side longer than ``side_px``; itself where none is."""
    if max(photo.size_px) <= side_px:
        return photo
    image = Image.fromarray(photo.rgb)
    image.thumbnail((side_px, side_px), Image.Resampling.BOX, reducing_gap=None)
    return Photo(np.asarray(image))
