"""Labelled pictures go in; one contact sheet of them comes out."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from limner.errors import BadInput
from limner.targets.image import encode_png

if TYPE_CHECKING:
    from PIL import Image, ImageDraw

_INK, _FAINT, _FRAME, _PAPER = (28, 30, 34), (110, 114, 122), (222, 224, 228), (255, 255, 255)

# In parts of a tile's width.
_GAP, _TITLE, _NOTE, _LEADING = 0.07, 0.05, 0.038, 1.35
_TALLEST = 1.6


@dataclass(frozen=True)
class Tile:
    """A picture on the sheet and what stands under it.

    Attributes:
        rgb: (H, W, 3) uint8.
        title: the first line.
        note: the second, smaller and fainter; may be empty.
    """

    rgb: NDArray[np.uint8]
    title: str
    note: str = ""


def to_sheet(tiles: Sequence[Tile], columns: int | None = None, tile_px: int = 480) -> NDArray[np.uint8]:
    """Put the tiles on white, evenly spaced, row by row, each with its lines beneath.

    Args:
        tiles: at least one; each is scaled to ``tile_px`` wide, less where it would be very tall.
        columns: how many side by side; not given: four at most, and as even rows as that allows.
        tile_px: width of a tile.

    Returns:
        (H, W, 3) uint8 RGB.

    Raises:
        BadInput: no tile, or a size that is not positive.
    """
    from PIL import Image

    if not tiles or tile_px < 16 or (columns is not None and columns < 1):
        raise BadInput(
            f"sheet: {len(tiles)} tiles of {tile_px} px in {columns} columns; expected some, of 16 px or more"
        )
    columns = min(columns or math.ceil(len(tiles) / math.ceil(len(tiles) / 4)), len(tiles))
    gap = round(tile_px * _GAP)
    rows = [
        _row([(tile, _fitted(tile.rgb, tile_px)) for tile in tiles[k : k + columns]], tile_px, gap)
        for k in range(0, len(tiles), columns)
    ]
    sheet = Image.new("RGB", (gap + columns * (tile_px + gap), gap + sum(row.height for row in rows)), _PAPER)
    top = gap
    for row in rows:
        sheet.paste(row, (0, top))
        top += row.height
    return np.array(sheet)


def to_png(rgb: NDArray[np.uint8]) -> bytes:
    """A sheet, or any (H, W, 3) uint8 RGB, as PNG file."""
    return encode_png(rgb)


def _row(tiles: list[tuple[Tile, Image.Image]], tile_px: int, gap: int) -> Image.Image:
    """Tiles side by side, their lower edges and captions in line, and the gap below."""
    from PIL import Image, ImageDraw

    floor = 1 + max(picture.height for _, picture in tiles)
    sizes = (_TITLE, _NOTE) if any(tile.note for tile, _ in tiles) else (_TITLE,)
    height = floor + gap // 3 + math.ceil(sum(_font_px(tile_px, size) for size in sizes) * _LEADING) + gap
    row = Image.new("RGB", (gap + len(tiles) * (tile_px + gap), height), _PAPER)
    pen = ImageDraw.Draw(row)
    for k, (tile, picture) in enumerate(tiles):
        left = gap + k * (tile_px + gap)
        _place(row, pen, picture, left + (tile_px - picture.width) // 2, floor - picture.height)
        _caption(pen, tile, left + tile_px / 2, floor + gap // 3, tile_px)
    return row


def _fitted(rgb: NDArray[np.uint8], width: int) -> Image.Image:
    from PIL import Image

    picture = Image.fromarray(rgb)
    scale = min(width / picture.width, width * _TALLEST / picture.height)
    size = max(1, round(picture.width * scale)), max(1, round(picture.height * scale))
    return picture.resize(size, Image.Resampling.LANCZOS, reducing_gap=3.0)


def _place(sheet: Image.Image, pen: ImageDraw.ImageDraw, picture: Image.Image, left: int, top: int) -> None:
    sheet.paste(picture, (left, top))
    # A drawing is white on white: its frame shows where the paper ends.
    pen.rectangle((left - 1, top - 1, left + picture.width, top + picture.height), outline=_FRAME)


def _caption(pen: ImageDraw.ImageDraw, tile: Tile, middle: float, top: float, width: int) -> None:
    from PIL import ImageFont

    for text, size, color in ((tile.title, _TITLE, _INK), (tile.note, _NOTE, _FAINT)):
        font = ImageFont.load_default(_font_px(width, size))
        pen.text((middle, top), _shortened(text, pen, font, width), fill=color, font=font, anchor="ma")
        top += _font_px(width, size) * _LEADING


def _font_px(width: int, size: float) -> float:
    return max(8.0, width * size)


def _shortened(text: str, pen: ImageDraw.ImageDraw, font: Any, width: int) -> str:
    text = " ".join(text.split())
    if pen.textlength(text, font) <= width:
        return text
    while text and pen.textlength(text + "...", font) > width:
        text = text[:-1]
    return text.rstrip() + "..."
