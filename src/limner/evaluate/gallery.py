"""Photos of faces go in; each beside its drawing in several styles comes out, to be judged by eye."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from limner.pipeline import Portrait, Session, Settings
from limner.targets.framing import frame_photo
from limner.targets.image import to_rgb
from limner.targets.sheet import Tile
from limner.vision.photo import Source

PX_PER_MM = 4.0
"""Resolution of the drawings before the sheet makes them smaller."""


def gallery(photos: Sequence[Source], styles: Sequence[str], settings: Settings) -> Iterator[list[Tile]]:
    """The photo and its drawings, one photo after the other.

    Args:
        photos: anything ``load_photo`` reads; the largest face of each is drawn.
        styles: from left to right.
        settings: of all styles.

    Raises:
        BadInput: a photo cannot be read, or there is no such style.
        NoFace: there is no face in one.
    """
    for photo in photos:
        session = Session(photo)
        portraits = [session.draw(settings.replace(style=style)) for style in styles]
        yield [_framed(portraits[-1]), *(_tile(portrait) for portrait in portraits)]


def _framed(portrait: Portrait) -> Tile:
    """The photo as the page frames the last of its drawings."""
    page = portrait.drawing.page
    return Tile(frame_photo(portrait.photo, portrait.page_from_photo, page, PX_PER_MM).rgb, "photo")


def _tile(portrait: Portrait) -> Tile:
    drawing = portrait.drawing
    strokes = f"{len(drawing.lines_mm)} strokes, {drawing.points} points"
    return Tile(to_rgb(drawing, PX_PER_MM), portrait.settings.style, strokes)
