"""A portrait goes in; a small picture of it, as lines beside its photo, comes out for the contact sheet."""

from __future__ import annotations

import base64
import json
import re
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from limner import geometry
from limner.errors import BadInput
from limner.pipeline import Portrait
from limner.targets.framing import frame_photo
from limner.targets.image import encode_jpeg
from limner.types import Floats

PX_PER_MM = 1.6
"""Of the photo; its page is as wide as the drawing's."""

_UNIT_MM = 0.1
_TOLERANCE_MM = 0.12
_PATH = re.compile(rb'<path d="([^"]*)"')
_NUMBER = rb"(\d{1,6}(?:\.\d{1,9})?)"
_VIEW = re.compile(rb'viewBox="0 0 ' + _NUMBER + rb" " + _NUMBER + rb'"')
_PEN = re.compile(rb'stroke-width="' + _NUMBER + rb'"')


class Tile(NamedTuple):
    """What the contact sheet shows of a portrait: the page and the pen, the lines as an SVG path, the photo as JPEG."""

    width: float
    height: float
    pen: float
    path: str
    photo: str


def tile_of(portrait: Portrait) -> bytes:
    """The tile, as JSON: page and pen [0.1 mm], the lines as an SVG path, the photo as the page frames it as JPEG."""
    page, pen = portrait.drawing.page, portrait.drawing.pen
    photo = frame_photo(portrait.photo, portrait.page_from_photo, page, PX_PER_MM)
    return _packed(
        (page.width_mm / _UNIT_MM, page.height_mm / _UNIT_MM),
        pen.width_mm / _UNIT_MM,
        _path(portrait.drawing.lines_mm, page.height_mm),
        base64.b64encode(encode_jpeg(photo.rgb, quality=72)).decode(),
    )


def tile_of_svg(data: bytes) -> bytes:
    """The tile of a drawing made before, from its file; without the photo."""
    view, pen = _VIEW.search(data), _PEN.search(data)
    size = (float(view[1]), float(view[2])) if view else (148.0, 210.0)
    path = " ".join(match.decode("utf-8", "replace") for match in _PATH.findall(data))
    return _packed(size, float(pen[1]) if pen else 0.5, path, "")


def _packed(size: tuple[float, float], pen: float, path: str, photo: str) -> bytes:
    return json.dumps(Tile(*size, pen, path, photo)._asdict()).encode()


def unpacked(tile: bytes) -> Tile:
    """What is in a tile.

    Raises:
        BadInput: it is none.
    """
    try:
        fields = json.loads(tile)
        made = Tile(**fields)
    except (TypeError, ValueError, RecursionError) as error:
        raise BadInput(f"a tile of the contact sheet is damaged ({error})") from error
    sizes, texts = ([fields[name] for name in names] for names in (Tile._fields[:3], Tile._fields[3:]))
    if not all(isinstance(value, int | float) and 0 <= value < _LARGEST for value in sizes):
        raise BadInput("a tile of the contact sheet is damaged; expected the sizes of a page and a pen")
    if not (all(isinstance(text, str) for text in texts) and _BASE64.fullmatch(made.photo)):
        raise BadInput("a tile of the contact sheet is damaged; expected a path and a photo")
    return made


_LARGEST = 1e6
_BASE64 = re.compile(r"[A-Za-z0-9+/=]*")


def _path(lines_mm: Sequence[Floats], height_mm: float) -> str:
    return "".join(_line(line, height_mm) for line in geometry.simplify_all(lines_mm, _TOLERANCE_MM))


def _line(line: Floats, height_mm: float) -> str:
    whole = np.rint(([0, height_mm] + line * [1, -1]) / _UNIT_MM).astype(int)
    steps = np.diff(whole, axis=0).tolist() or [[0, 0]]
    start = f"M{whole[0, 0]} {whole[0, 1]}l"
    return start + "".join(
        f"{' ' if k and x >= 0 else ''}{x}{' ' if y >= 0 else ''}{y}" for k, (x, y) in enumerate(steps)
    )
