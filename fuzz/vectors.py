"""Bytes of a vector file go in, to be read as SVG."""

from __future__ import annotations

from limner import storage
from limner.targets.svg import to_svg
from limner.targets.svg_read import read_about, read_svg
from limner.types import Drawing


def svg(data: bytes) -> None:
    """Anybody's SVG; what was read can be stored and written."""
    drawing = read_svg(data)
    if drawing.points > 20_000:
        return
    assert storage.from_json(Drawing, storage.to_json(drawing)) == drawing
    to_svg(drawing)


def svg_about(data: bytes) -> None:
    """What an SVG says about itself."""
    assert isinstance(read_about(data), dict)


HARNESSES = {"svg": svg, "svg-about": svg_about}
