"""A picture as file, bytes, numpy array or Pillow image goes in; an upright sRGB ``Photo`` comes out."""

from __future__ import annotations

import os
import sys
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from limner.errors import BadInput
from limner.storage import read_bytes
from limner.types import Photo
from limner.vision.photo.decode import decoding, open_image
from limner.vision.photo.pixels import from_array, from_image, upright_size

Source = str | os.PathLike[str] | bytes | bytearray | memoryview | BinaryIO | NDArray[Any] | Image.Image
"""Whatever a photo can be read from."""

_STREAM_BYTES = 512 * 2**20
# Several pictures in one file of another format are pages, sizes or views.
_MOVING = ("GIF", "PNG", "WEBP", "AVIF")


def load_photo(source: Source, *, still: bool = False) -> Photo:
    """Read a picture, turn it upright and bring it to sRGB.

    The EXIF orientation is applied, an embedded colour profile converted, transparency laid on white; of
    several frames the first is taken. Pictures of more than ``MAX_PIXELS`` come back smaller: a JPEG by its
    decoder's own halving, others as the mean of square blocks.

    Args:
        source: a path, ``-`` for standard input, the bytes of a file, an open binary file, a Pillow image, or
            an array: (H, W) grey, (H, W, 3) RGB or (H, W, 4) RGBA of uint8, uint16 or floats in [0, 1].
        still: refuse a picture that moves.

    Raises:
        BadInput: it cannot be read, is no picture, is broken, or claims more than ``REFUSED_PIXELS`` or than a photo
            has in so few bytes.
        MissingExtra: a HEIC file, and the package that reads them is not installed.
    """
    if isinstance(source, np.ndarray):
        return Photo(from_array(source))
    if isinstance(source, Image.Image):
        with decoding("photo"):
            return Photo(from_image(source, "photo"))
    data, name = _read(source)
    with decoding(name), open_image(data, name) as image:
        if still and image.format in _MOVING and getattr(image, "is_animated", False):
            raise BadInput(f"{name}: is an animation; use a single picture")
        pixels = from_image(image, name)
    return Photo(pixels)


def photo_size(source: Source) -> tuple[int, int]:
    """Width and height [px] of what ``load_photo`` makes of a file, without decoding it (TIFF aside).

    Raises:
        BadInput: as ``load_photo``, as far as a file's head tells.
    """
    data, name = _read(source)
    with decoding(name), open_image(data, name) as image:
        if image.format == "TIFF":
            image.load()  # by which Pillow turns these upright itself
        return upright_size(image)


def _read(source: Any) -> tuple[bytes, str]:
    if isinstance(source, bytes | bytearray | memoryview):
        data, name = bytes(source), "photo"
    elif isinstance(source, str) and source == "-":
        data, name = _read_stream(sys.stdin.buffer, "standard input")
    elif isinstance(source, str | os.PathLike):
        data, name = read_bytes(os.fspath(source)), os.fspath(source)
    elif hasattr(source, "read"):
        data, name = _read_stream(source, getattr(source, "name", None))
    else:
        raise BadInput(
            f"photo: expected a path, bytes, a binary file, an array or a Pillow image, got {type(source).__name__}"
        )
    if not data:
        raise BadInput(f"{name}: is empty; expected a picture")
    return data, name


def _read_stream(stream: BinaryIO, name: Any) -> tuple[bytes, str]:
    name = name if isinstance(name, str) else "photo"
    try:
        data = stream.read(_STREAM_BYTES + 1)
    except (OSError, ValueError) as error:
        raise BadInput(f"{name}: cannot be read ({error})") from error
    if not isinstance(data, bytes):
        raise BadInput(f"{name}: is open as text; open it in binary mode")
    if len(data) > _STREAM_BYTES:
        raise BadInput(f"{name}: larger than {_STREAM_BYTES // 2**20} MB, the limit for a picture")
    return data, name
