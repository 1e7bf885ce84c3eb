"""Bytes of a picture go in, to be read as a photo."""

from __future__ import annotations

from limner.vision.photo import MAX_PIXELS, load_photo


def photo(data: bytes) -> None:
    """A file of any format."""
    width, height = load_photo(data).size_px
    assert width * height <= MAX_PIXELS


HARNESSES = {"photo": photo}
