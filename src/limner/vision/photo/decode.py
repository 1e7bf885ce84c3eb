"""The bytes of a picture go in; a Pillow image comes out, of a known format and a size that can be borne."""

from __future__ import annotations

import contextlib
import io
import logging
import threading
import warnings
from collections.abc import Iterator

from PIL import Image, UnidentifiedImageError

from limner.errors import BadInput, LimnerError, MissingExtra
from limner.vision.photo.tiff import silent_tiff

MAX_PIXELS = 40_000_000
"""A larger picture is scaled down while it is loaded."""

REFUSED_PIXELS = 250_000_000
"""A file that claims more is refused before any of it is decoded: a decoder takes four bytes a pixel, 1 GB."""

PIXELS_PER_BYTE = 1000
"""A file larger than ``MAX_PIXELS`` has no more: photos have about ten, and 34 bytes of WebP can ask for a gigabyte."""

FORMATS = ("JPEG", "MPO", "PNG", "WEBP", "AVIF", "TIFF", "BMP", "DIB", "GIF", "PPM", "JPEG2000")
"""Pillow's decoders that are let near a file, HEIC aside; others call outside programs or match almost any bytes."""

_HEIC_BRANDS = (b"heic", b"heix", b"hevc", b"hevx", b"heim", b"heis", b"hevm", b"hevs")

_pillow_globals = threading.RLock()

# What it says of broken files while it raises an error is said by the error.
logging.getLogger("PIL").addHandler(logging.NullHandler())


@contextlib.contextmanager
def decoding(name: str) -> Iterator[None]:
    """Pillow with neither warnings nor its own size limit (ours names the file), and one kind of error.

    These are global to the process, hence the lock.
    """
    with _pillow_globals, warnings.catch_warnings(), silent_tiff():
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


def open_image(data: bytes, name: str) -> Image.Image:
    """The image in a file, not yet decoded; a large JPEG is set to be halved while it is.

    Raises:
        BadInput: it claims more pixels than can be read, or than a photo has in so few bytes.
        MissingExtra: a HEIC file, and the package that reads them is not installed.
    """
    Image.init()
    formats = [name for name in FORMATS if name in Image.OPEN]
    if _is_heic(data):
        formats = [_heic_format(name)]
    image = Image.open(io.BytesIO(data), formats=formats)
    _refuse_huge(image.size, len(data), name)
    if image.format in ("JPEG", "MPO"):
        _halve(image)
    return image


def _refuse_huge(size: tuple[int, int], file_bytes: int, name: str) -> None:
    width, height = size
    if width * height > REFUSED_PIXELS:
        raise BadInput(
            f"{name}: {width} x {height} px is {width * height / 1e6:.0f} megapixels, more than the"
            f" {REFUSED_PIXELS // 10**6} that are read; scale it down first"
        )
    if width * height > MAX_PIXELS + PIXELS_PER_BYTE * file_bytes:
        raise BadInput(
            f"{name}: {width} x {height} px in {file_bytes} bytes is no photo; a picture of one colour cannot be drawn"
        )


def _halve(image: Image.Image) -> None:
    """Have the decoder of a large JPEG halve it as often as needed, which saves most of the work."""
    width, height = image.size
    halving = next((s for s in (1, 2, 4, 8) if (width // s + 1) * (height // s + 1) <= MAX_PIXELS), 8)
    if halving > 1:
        image.draft(None, (width // halving, height // halving))


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
