"""Photos of faces go in; each beside its drawing in several styles comes out, to be judged by eye."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import cv2
import numpy as np

from limner.pipeline import PICTURES, Portrait, Session, Settings
from limner.targets.framing import frame_photo
from limner.targets.image import to_rgb
from limner.targets.sheet import Tile
from limner.types import Photo
from limner.vision.photo import Source

PX_PER_MM = 4.0
"""Resolution of the drawings before the sheet makes them smaller."""


def gallery(
    photos: Sequence[Source], styles: Sequence[str], settings: Settings, *, pictures: bool = False
) -> Iterator[list[Tile]]:
    """The photo and its drawings, one photo after the other.

    Args:
        photos: anything ``load_photo`` reads; the largest face of each is drawn.
        styles: from left to right.
        settings: of all styles.
        pictures: a style that has a picture in colours shows it before its drawing.

    Raises:
        BadInput: a photo cannot be read, or there is no such style.
        NoFace: there is no face in one.
    """
    for photo in photos:
        session = Session(photo)
        portraits = [session.draw(settings.replace(style=style)) for style in styles]
        yield [
            _framed(portraits[-1], portraits[-1].photo, "photo"),
            *(tile for portrait in portraits for tile in (*_pictures(portrait, pictures), _tile(portrait))),
        ]


def columns(styles: Sequence[str], *, pictures: bool = False) -> int:
    """How many tiles each photo has."""
    return 1 + len(styles) + (sum(style in PICTURES for style in styles) if pictures else 0)


def _pictures(portrait: Portrait, wanted: bool) -> Iterator[Tile]:
    style = portrait.settings.style
    if wanted and style in PICTURES:
        picture = np.asarray(cv2.resize(portrait.picture(), portrait.photo.size_px), np.uint8)
        yield _framed(portrait, Photo(picture), f"{style}, in colours")


def _framed(portrait: Portrait, photo: Photo, title: str) -> Tile:
    """A photo as the page frames a drawing of it."""
    return Tile(frame_photo(photo, portrait.page_from_photo, portrait.drawing.page, PX_PER_MM).rgb, title)


def _tile(portrait: Portrait) -> Tile:
    drawing = portrait.drawing
    strokes = f"{len(drawing.lines_mm)} strokes, {drawing.points} points"
    return Tile(to_rgb(drawing, PX_PER_MM), portrait.settings.style, strokes)
