"""A Pillow image or an array goes in; its pixels come out upright, sRGB, 8 bits a channel, not too many."""

from __future__ import annotations

import io
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageCms

from limner.errors import BadInput
from limner.vision.photo.decode import MAX_PIXELS

Pixels = NDArray[np.uint8]
"""(H, W, 3)."""

_BAND_PIXELS = 2**20
_ORIENTATION_TAG = 0x0112

# EXIF orientation -> whether rows and columns are exchanged, then the steps along y and x.
_TURNS = {
    1: (False, 1, 1),
    2: (False, 1, -1),
    3: (False, -1, -1),
    4: (False, -1, 1),
    5: (True, 1, 1),
    6: (True, 1, -1),
    7: (True, -1, -1),
    8: (True, -1, 1),
}


def from_image(image: Image.Image, name: str) -> Pixels:
    """The pixels of an image; ``name`` is what it is called in an error.

    Raises:
        BadInput: pixels of another kind than photos have.
    """
    if image.mode == "F":
        raise BadInput(f"{name}: has floating-point pixels; save it with 8 or 16 bits a channel")
    image.load()
    if image.mode == "I":
        values = np.asarray(image)
        low, high = int(values.min()), int(values.max())
        if low < 0 or high > 65535:
            raise BadInput(f"{name}: has pixels from {low} to {high}; save it with 8 or 16 bits a channel")
    profile = _to_srgb(image)
    width = image.size[0]
    pixels = _assemble(image.size, lambda top, bottom: _plain(image.crop((0, top, width, bottom)), profile))
    return _upright(pixels, _orientation(image))


def from_array(array: NDArray[Any]) -> Pixels:
    """The pixels of an array: (H, W) grey, (H, W, 3) RGB or (H, W, 4) RGBA of uint8, uint16 or floats in [0, 1].

    Raises:
        BadInput: another shape or type, no pixel, or floats beyond [0, 1].
    """
    known = array.dtype.kind == "f" or (array.dtype.kind == "u" and array.dtype.itemsize <= 2)
    if not known or array.ndim not in (2, 3) or (array.ndim == 3 and array.shape[2] not in (3, 4)):
        raise BadInput(
            f"photo: expected an array (H, W), (H, W, 3) or (H, W, 4) of uint8, uint16 or floats in [0, 1],"
            f" got {array.shape} of {array.dtype}"
        )
    if 0 in array.shape:
        raise BadInput(f"photo: expected at least one pixel, got an array {array.shape}")
    if array.dtype.kind == "f" and not (array.min() >= 0 and array.max() <= 1):
        raise BadInput(f"photo: expected floats in [0, 1], got {array.min():g} to {array.max():g}")
    size = (array.shape[1], array.shape[0])
    return _assemble(size, lambda top, bottom: _plain(Image.fromarray(_eight_bit(array[top:bottom])), None))


def upright_size(image: Image.Image) -> tuple[int, int]:
    """Width and height [px] of what ``from_image`` makes of an image."""
    factor = _factor(image.size)
    width, height = (-(-side // factor) for side in image.size)
    return (height, width) if _TURNS[_orientation(image)][0] else (width, height)


def _assemble(size: tuple[int, int], band: Callable[[int, int], Image.Image]) -> Pixels:
    """The whole picture from bands of rows in RGB, reduced until it has at most ``MAX_PIXELS``.

    In bands, since the conversions need several copies of what they work on.
    """
    width, height = size
    factor = _factor(size)
    pixels = np.empty((-(-height // factor), -(-width // factor), 3), np.uint8)
    rows = factor * max(1, _BAND_PIXELS // (width * factor))
    for top in range(0, height, rows):
        part = band(top, min(top + rows, height))
        part = part.reduce(factor) if factor > 1 else part
        pixels[top // factor : top // factor + part.height] = np.asarray(part)
    return pixels


def _factor(size: tuple[int, int]) -> int:
    """By how much a picture is reduced."""
    factor = 1
    while -(-size[0] // factor) * -(-size[1] // factor) > MAX_PIXELS:
        factor += 1
    return factor


def _plain(band: Image.Image, profile: ImageCms.ImageCmsTransform | None) -> Image.Image:
    """Eight-bit sRGB on white, from a band of any mode."""
    if band.mode.startswith("I"):
        band = Image.fromarray(_eight_bit(np.asarray(band).astype(np.uint16)))
    alpha = None
    if band.has_transparency_data:
        band = (band.convert("LA") if band.mode == "La" else band).convert("RGBA")
        alpha = band.getchannel("A")
    band = band if band.mode == _colour_mode(band) else band.convert("RGB")
    if profile is not None:
        band = ImageCms.applyTransform(band, profile) or band
    band = band if band.mode == "RGB" else band.convert("RGB")
    if alpha is None:
        return band
    white = Image.new("RGB", band.size, "white")
    white.paste(band, mask=alpha)
    return white


def _colour_mode(image: Image.Image) -> str:
    """The mode in which an image's profile is applied."""
    if image.has_transparency_data:
        return "RGB"
    grey = image.mode == "L" or image.mode.startswith("I")
    return "L" if grey else "CMYK" if image.mode == "CMYK" else "RGB"


def _to_srgb(image: Image.Image) -> ImageCms.ImageCmsTransform | None:
    """The way from an image's embedded profile to sRGB; none where it has none, a broken one, or sRGB itself."""
    embedded = image.info.get("icc_profile")
    if not isinstance(embedded, bytes):
        return None
    try:
        profile = ImageCms.ImageCmsProfile(io.BytesIO(embedded))
        if "sRGB" in ImageCms.getProfileDescription(profile):
            return None
        return ImageCms.buildTransform(profile, ImageCms.createProfile("sRGB"), _colour_mode(image), "RGB")
    except (ImageCms.PyCMSError, OSError, ValueError, TypeError):
        return None


def _orientation(image: Image.Image) -> int:
    try:
        value = image.getexif().get(_ORIENTATION_TAG, 1)
    except Exception:  # the parser's of broken data, which is no reason to refuse a good picture
        return 1
    return value if value in _TURNS else 1


def _upright(pixels: Pixels, orientation: int) -> Pixels:
    exchange, step_y, step_x = _TURNS[orientation]
    turned = pixels.transpose(1, 0, 2) if exchange else pixels
    return np.ascontiguousarray(turned[::step_y, ::step_x])


def _eight_bit(values: NDArray[Any]) -> Pixels:
    """Rounded to 0..255 from uint8, uint16 or floats in [0, 1]."""
    if values.dtype.kind == "f":
        return np.rint(values.astype(np.float64) * 255).astype(np.uint8)
    if values.dtype.itemsize == 2:
        return ((values.astype(np.uint32) * 255 + 32767) // 65535).astype(np.uint8)
    return np.ascontiguousarray(values)
