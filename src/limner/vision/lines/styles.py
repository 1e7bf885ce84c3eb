"""A sitter goes in; strokes in the pixels of the photo come out, in one of the named styles."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from limner.types import Strokes
from limner.vision.cartoon.style import abstracted, cartoon_edges, cartoon_strokes, with_features
from limner.vision.edges import EXTRACTORS, IN_TWO
from limner.vision.lines.sitter import Sitter
from limner.vision.lines.traced import edges_to_strokes
from limner.vision.painterly.style import painterly_strokes
from limner.vision.spline_style import spline_strokes
from limner.vision.tonal.scribble import scribble
from limner.vision.tonal.stipple import stipple

Way = Callable[[Sitter], Strokes]
"""From a sitter to strokes in the pixels of the photo, the heaviest first."""


def _extracted(style: str, sitter: Sitter) -> Strokes:
    """By an edge map."""
    working, stages = sitter.working, sitter.stages
    chosen = sitter.settings.of_style(style)
    if style in IN_TWO:
        look, lines_in = IN_TWO[style]
        sight = stages("sight", look, working.photo, working.face, chosen.seeing())
        edges = stages("edges", lines_in, sight, chosen)
    else:
        edges = stages("edges", EXTRACTORS[style], working.photo, working.face, chosen)
    return sitter.in_photo(edges_to_strokes(edges, working.face, sitter.settings, stages))


def _splines(sitter: Sitter) -> Strokes:
    settings = sitter.settings
    return sitter.stages("splines", spline_strokes, sitter.photo, sitter.face, settings.splines, settings.regions)


def _portrait(sitter: Sitter) -> Strokes:
    return sitter.in_photo(sitter.portrait)


def _dots(style: str, sitter: Sitter) -> Strokes:
    ink, face, settings = sitter.ink, sitter.working.face, sitter.settings
    return sitter.in_photo(sitter.stages(style, stipple, ink, face, settings.of_style(style), settings.regions))


def _scribble(sitter: Sitter) -> Strokes:
    ink, face, settings = sitter.ink, sitter.working.face, sitter.settings
    return sitter.in_photo(
        sitter.stages("scribble", scribble, ink, sitter.seen, face, settings.scribble, settings.regions)
    )


def _cartoon(sitter: Sitter) -> Strokes:
    working, figure, stages, settings = sitter.working, sitter.figure, sitter.stages, sitter.settings
    made = stages("abstracted", abstracted, working.photo, working.face, settings.cartoon)
    edges = stages("edges", cartoon_edges, made, figure, settings.cartoon)
    traced = edges_to_strokes(edges, working.face, settings, stages)
    # The features are drawn by who knows them; what frames them by the picture's own edges.
    lines = stages("joined", with_features, traced, sitter.portrait)
    seen = (working.photo, working.face, figure)
    return sitter.in_photo(stages("cartoon", cartoon_strokes, made, lines, seen, settings.cartoon, settings.regions))


def _painterly(sitter: Sitter) -> Strokes:
    settings, seen = sitter.settings, (sitter.working.photo, sitter.working.face, sitter.figure)
    return sitter.in_photo(sitter.stages("painterly", painterly_strokes, *seen, settings.painterly, settings.regions))


OWN_WAYS: dict[str, Way] = {
    "cartoon": _cartoon,
    "painterly": _painterly,
    "portrait": _portrait,
    "splines": _splines,
}
"""Styles that are more than an extractor."""

MEASURED: dict[str, Way] = {
    "stipple": partial(_dots, "stipple"),
    "one-line": partial(_dots, "one-line"),
    "scribble": _scribble,
}
"""Styles made to measure; of ``one-line`` the dots, which are joined on the page."""

WAYS: dict[str, Way] = {style: partial(_extracted, style) for style in EXTRACTORS} | OWN_WAYS | MEASURED
"""Every style."""

STYLES = tuple(WAYS)
"""Their names."""
