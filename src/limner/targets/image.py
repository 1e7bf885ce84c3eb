"""A drawing goes in; a picture of it on white paper comes out, the pen's width drawn true."""

from __future__ import annotations

import io
import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from limner.errors import BadInput
from limner.types import Drawing, Floats

MAX_PIXELS = 200_000_000
"""A larger picture is refused."""

MM_PER_INCH = 25.4

_PEN_SUBPIXELS = 16  # across the pen, so that a whole sub-pixel more or less does not show
_SHIFT = 6  # bits of fraction in OpenCV's coordinates
_BAND_SUBPIXELS = 2**23
_REACH = 2.0**20  # sub-pixels; OpenCV's fixed-point coordinates overflow not far beyond


def to_rgb(drawing: Drawing, px_per_mm: float = 10.0) -> NDArray[np.uint8]:
    """Draw lines with round ends and joins, and dots, on white, in the pens' colours; where they cross, inks add up.

    Each pixel is the mean of up to 8 x 8 sub-pixels; drawn in bands, since those take much memory.

    Args:
        drawing: strokes in the page frame; what lies off the page is cut off.
        px_per_mm: resolution.

    Returns:
        (H, W, 3) uint8 RGB, the page's upper left corner first.

    Raises:
        BadInput: the resolution is not positive, or gives more than ``MAX_PIXELS``.
    """
    if _is_black(drawing):
        return np.repeat(_grey(drawing, px_per_mm)[..., None], 3, axis=2)
    picture = np.full((*_size_px(drawing, px_per_mm)[::-1], 3), 255, np.uint8)
    for part in drawing.by_pen():
        white = _grey(part, px_per_mm)[..., None] / np.float32(255)
        ink = np.array(drawing.pens[int(part.layer[0])].rgb, np.float32) / 255
        picture = np.rint(picture * (white + (1 - white) * ink)).astype(np.uint8)
    return picture


def _is_black(drawing: Drawing) -> bool:
    return all(drawing.pens[k].rgb == (0, 0, 0) for k in np.unique(drawing.layer).tolist())


def to_png(drawing: Drawing, dpi: float = 300.0) -> bytes:
    """The picture as a PNG file, grey if all ink is black, that knows its resolution, so that it prints at its size.

    Args:
        drawing: strokes in the page frame.
        dpi: resolution [pixels per inch].

    Raises:
        BadInput: as ``to_rgb``.
    """
    px_per_mm = dpi / MM_PER_INCH
    return encode_png(_grey(drawing, px_per_mm) if _is_black(drawing) else to_rgb(drawing, px_per_mm), dpi)


def encode_png(image: NDArray[np.uint8], dpi: float | None = None) -> bytes:
    """A grey (H, W) or RGB (H, W, 3) picture as PNG file, with its resolution when given."""
    from PIL import Image

    out = io.BytesIO()
    Image.fromarray(image).save(out, "PNG", **({} if dpi is None else {"dpi": (dpi, dpi)}))
    return out.getvalue()


def encode_webp(image: NDArray[np.uint8], quality: int = 86) -> bytes:
    """An RGB (H, W, 3) picture as WebP file: photos and lines on one sheet in a fifth of a PNG."""
    from PIL import Image

    out = io.BytesIO()
    Image.fromarray(image).save(out, "WEBP", quality=quality, method=6)
    return out.getvalue()


def encode_jpeg(image: NDArray[np.uint8], quality: int = 88) -> bytes:
    """An RGB (H, W, 3) picture as JPEG file."""
    from PIL import Image

    out = io.BytesIO()
    Image.fromarray(image).save(out, "JPEG", quality=quality)
    return out.getvalue()


def _grey(drawing: Drawing, px_per_mm: float) -> NDArray[np.uint8]:
    import cv2

    width, height = _size_px(drawing, px_per_mm)
    pens = [drawing.pens[k].width_mm * px_per_mm for k in drawing.layer.tolist()]
    fine = min(max(math.ceil(_PEN_SUBPIXELS / min(pens, default=_PEN_SUBPIXELS)), 2), 8)
    lines = [_to_subpixels(line, drawing, px_per_mm * fine) for line in drawing.lines_mm]
    wide = [(line, pen * fine) for line, pen in zip(lines, pens, strict=True)]
    rows = max(1, _BAND_SUBPIXELS // (width * fine * fine))
    image = np.empty((height, width), np.uint8)
    for top in range(0, height, rows):
        count = min(rows, height - top)
        band = np.full((count * fine, width * fine), 255, np.uint8)
        for line, pen in _near_band(wide, top * fine, (top + count) * fine):
            _draw_line(band, line - [0, top * fine], pen)
        image[top : top + count] = cv2.resize(band, (width, count), interpolation=cv2.INTER_AREA)
    return image


def _size_px(drawing: Drawing, px_per_mm: float) -> tuple[int, int]:
    page = drawing.page
    if not (math.isfinite(px_per_mm) and px_per_mm > 0):
        raise BadInput(f"image: a resolution of {px_per_mm:g} pixels per mm; expected more than 0")
    width, height = page.width_mm * px_per_mm, page.height_mm * px_per_mm
    if width * height > MAX_PIXELS:
        raise BadInput(
            f"image: {width:.0f} x {height:.0f} px at {px_per_mm:.3g} pixels per mm is more than"
            f" {MAX_PIXELS // 10**6} megapixels; choose a lower resolution"
        )
    return max(1, round(width)), max(1, round(height))


def _to_subpixels(line: Floats, drawing: Drawing, per_mm: float) -> Floats:
    """Sub-pixels, y down, centres on integers; from the page frame, in which the page's edges are pixels' edges."""
    place = np.stack([line[:, 0], drawing.page.height_mm - line[:, 1]], axis=1) * per_mm - 0.5
    return np.clip(place, -_REACH, _REACH)


def _near_band(lines: list[tuple[Floats, float]], top: int, bottom: int) -> Iterator[tuple[Floats, float]]:
    for line, pen in lines:
        if line[:, 1].max() >= top - pen and line[:, 1].min() <= bottom + pen:
            yield line, pen


def _draw_line(band: NDArray[np.uint8], line: Floats, pen: float) -> None:
    """A disc at each point and a rectangle along each segment; OpenCV's own thick lines come in odd widths only.

    Its fills take in every sub-pixel that their border touches, so the border is drawn half a sub-pixel inside.
    """
    import cv2

    half = max(pen - 1, 0) / 2
    along = np.diff(line, axis=0)
    unit = along / np.maximum(np.hypot(*along.T), 1e-9)[:, None]
    side = half * np.stack([-unit[:, 1], unit[:, 0]], axis=1)
    a, b = line[:-1], line[1:]
    for rectangle in _fixed(np.stack([a + side, b + side, b - side, a - side], axis=1)):
        cv2.fillConvexPoly(band, rectangle, 0, cv2.LINE_8, _SHIFT)
    radius = round(half * 2**_SHIFT)
    for x, y in _fixed(line).tolist():
        cv2.circle(band, (x, y), radius, 0, cv2.FILLED, cv2.LINE_8, _SHIFT)


def _fixed(places: Floats) -> NDArray[np.int32]:
    fixed: NDArray[np.int32] = np.rint(places * 2**_SHIFT).astype(np.int32)
    return fixed
