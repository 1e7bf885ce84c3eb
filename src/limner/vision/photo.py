"""A picture as file, bytes, numpy array or Pillow image goes in; an upright sRGB ``Photo`` comes out."""

from __future__ import annotations

import contextlib
import io
import logging
import os
import sys
import threading
import warnings
from collections.abc import Callable, Iterator
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageCms, UnidentifiedImageError

from limner.errors import BadInput, LimnerError, MissingExtra
from limner.storage import read_bytes
from limner.types import Photo

MAX_PIXELS = 40_000_000
"""A larger picture is scaled down while it is loaded."""

REFUSED_PIXELS = 250_000_000
"""A file that claims more is refused before any of it is decoded: a decoder takes four bytes a pixel, 1 GB."""

PIXELS_PER_BYTE = 1000
"""A file larger than ``MAX_PIXELS`` has no more: photos have about ten, and 34 bytes of WebP can ask for a gigabyte."""

FORMATS = ("JPEG", "MPO", "PNG", "WEBP", "AVIF", "TIFF", "BMP", "DIB", "GIF", "PPM", "JPEG2000")
"""Pillow's decoders that are let near a file, HEIC aside; others call outside programs or match almost any bytes."""

Source = str | os.PathLike[str] | bytes | bytearray | memoryview | BinaryIO | NDArray[Any] | Image.Image
Pixels = NDArray[np.uint8]
Box = tuple[int, int, int, int]

_BAND_PIXELS = 2**20
_STREAM_BYTES = 512 * 2**20
_HEIC_BRANDS = (b"heic", b"heix", b"hevc", b"hevx", b"heim", b"heis", b"hevm", b"hevs")
_ORIENTATION_TAG = 0x0112
# Several pictures in one file of another format are pages, sizes or views.
_MOVING = ("GIF", "PNG", "WEBP", "AVIF")

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

_pillow_globals = threading.RLock()

# What it says of broken files while it raises an error is said by the error.
logging.getLogger("PIL").addHandler(logging.NullHandler())


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
        return Photo(_from_array(source))
    if isinstance(source, Image.Image):
        with _decoding("photo"):
            return Photo(_from_image(source, "photo"))
    data, name = _read(source)
    with _decoding(name), _open(data, name) as image:
        if still and image.format in _MOVING and getattr(image, "is_animated", False):
            raise BadInput(f"{name}: is an animation; use a single picture")
        pixels = _from_image(image, name)
    return Photo(pixels)


def photo_size(source: Source) -> tuple[int, int]:
    """Width and height [px] of what ``load_photo`` makes of a file, without decoding it (TIFF aside).

    Raises:
        BadInput: as ``load_photo``, as far as a file's head tells.
    """
    data, name = _read(source)
    with _decoding(name), _open(data, name) as image:
        if image.format == "TIFF":
            image.load()  # by which Pillow turns these upright itself
        factor = _factor(image.size)
        width, height = (-(-side // factor) for side in image.size)
        return (height, width) if _TURNS[_orientation(image)][0] else (width, height)


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


@contextlib.contextmanager
def _decoding(name: str) -> Iterator[None]:
    """Pillow with neither warnings nor its own size limit (ours names the file), and one kind of error.

    Both are global to the process, hence the lock.
    """
    with _pillow_globals, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        limit, Image.MAX_IMAGE_PIXELS = Image.MAX_IMAGE_PIXELS, None
        try:
            yield
        except LimnerError:
            raise
        except UnidentifiedImageError as error:
            raise BadInput(
                f"{name}: is no picture that can be read; expected JPEG, PNG, WebP, HEIC, AVIF, TIFF, BMP or GIF"
            ) from error
        except Exception as error:  # decoders raise whatever broken bytes lead them to
            reason = " ".join(str(error).split())[:120] or type(error).__name__
            raise BadInput(f"{name}: is broken or cut short ({reason}); use a whole copy of it") from error
        finally:
            Image.MAX_IMAGE_PIXELS = limit


def _open(data: bytes, name: str) -> Image.Image:
    Image.init()
    formats = [name for name in FORMATS if name in Image.OPEN]
    if _is_heic(data):
        formats = [_heic_format(name)]
    image = Image.open(io.BytesIO(data), formats=formats)
    width, height = image.size
    if width * height > REFUSED_PIXELS:
        raise BadInput(
            f"{name}: {width} x {height} px is {width * height / 1e6:.0f} megapixels, more than the"
            f" {REFUSED_PIXELS // 10**6} that are read; scale it down first"
        )
    if width * height > MAX_PIXELS + PIXELS_PER_BYTE * len(data):
        raise BadInput(
            f"{name}: {width} x {height} px in {len(data)} bytes is no photo; a picture of one colour cannot be drawn"
        )
    if image.format in ("JPEG", "MPO"):
        halving = next((s for s in (1, 2, 4, 8) if (width // s + 1) * (height // s + 1) <= MAX_PIXELS), 8)
        if halving > 1:
            image.draft(None, (width // halving, height // halving))
    return image


def _is_heic(data: bytes) -> bool:
    """By the brands of an ISO base media file (ISO/IEC 23008-12); AVIF has the same container."""
    if data[4:8] != b"ftyp":
        return False
    brands = data[8 : min(int.from_bytes(data[:4], "big"), 256)]
    return any(brands[i : i + 4] in _HEIC_BRANDS for i in range(0, len(brands), 4))


def _heic_format(name: str) -> str:
    try:
        import pillow_heif
    except ImportError as error:
        raise MissingExtra(f"{name}: a HEIC photo", "heic") from error
    pillow_heif.register_heif_opener()
    return "HEIF"


def _from_image(image: Image.Image, name: str) -> Pixels:
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


def _from_array(array: NDArray[Any]) -> Pixels:
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


def _eight_bit(values: NDArray[Any]) -> Pixels:
    """Rounded to 0..255 from uint8, uint16 or floats in [0, 1]."""
    if values.dtype.kind == "f":
        return np.rint(values.astype(np.float64) * 255).astype(np.uint8)
    if values.dtype.itemsize == 2:
        return ((values.astype(np.uint32) * 255 + 32767) // 65535).astype(np.uint8)
    return np.ascontiguousarray(values)
