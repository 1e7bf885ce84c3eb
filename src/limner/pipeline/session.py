"""A photo and settings go in, a portrait comes out: every stage in one readable function, every result kept."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

from limner.drawing.clean import clean
from limner.drawing.compose import compose, grown, page_from_photo
from limner.drawing.order import order
from limner.drawing.select import select
from limner.drawing.thread import thread
from limner.drawing.within import made_within_time
from limner.errors import NothingToDraw
from limner.pipeline.budget import clock_of, finished, timed
from limner.pipeline.faces import Part, faces_in, refinements
from limner.pipeline.portrait import Portrait
from limner.pipeline.settings import Settings, changed
from limner.stages import Stages
from limner.types import Drawing, Face, Floats, Photo, Strokes
from limner.vision.landmarks import choose
from limner.vision.likeness.candidates import AUTO, AUTO_STYLES, best, candidate
from limner.vision.lines import MEASURED, draw_lines
from limner.vision.photo import Box, Source, load_photo
from limner.vision.refine import refine

_MOST_POINTS = 20_000
"""Of a drawing that is made to measure for a time."""


class Session:
    """A photo, drawn as often as one likes: a changed setting costs only what follows it.

    It keeps the photo and the last result of each stage. Files that settings name (landmarks, models) count as the
    same while their names are. One drawing at a time.
    """

    def __init__(self, source: Source | Photo, keep: int = 1, before: Callable[[], None] = lambda: None) -> None:
        """Take a photo; it is read for the first drawing.

        Args:
            source: a photo, or anything ``load_photo`` reads.
            keep: how many results of each stage are held, the latest.
            before: called before each stage; what it raises ends the drawing there.
        """
        self._source = source
        self._stages = Stages(keep, before)

    def draw(
        self,
        settings: Settings | None = None,
        *,
        crop: Box | None = None,
        number: int = 1,
        face: Face | None = None,
        **changes: Any,
    ) -> Portrait:
        """Draw the person: arguments, result and errors are those of ``limner.draw``."""
        settings = changed(settings or Settings(), changes)
        if settings.style == AUTO:
            return self._draw_best(settings, crop, number, face)
        stages = self._stages
        photo = stages("photo", _loaded, self._source)
        part = stages("crop", Part.of, photo, crop)
        faces = (face,) if face else stages("face", faces_in, photo, settings.detect, crop)
        chosen = choose(faces, number, part.photo, settings.detect)
        if not face:
            chosen = stages("refine", refine, photo, chosen, refinements(settings), settings.refinement)
        page, pen = settings.page.page(), settings.page.pen()
        if settings.style in MEASURED:
            drawing, strokes = self._made_to_measure(part, photo, part.from_whole(chosen), settings)
            affine = page_from_photo(strokes, page, settings.compose, pen)
            return Portrait(photo, faces, chosen, strokes, drawing, affine, settings, stages.take_seconds())
        strokes = draw_lines(part.photo, part.from_whole(chosen), settings.style, settings, stages)
        strokes = part.to_whole(strokes, photo)
        placed = stages("compose", compose, strokes, page, settings.compose, pen)
        cleaned = stages("clean", clean, placed, settings.clean)
        drawing, growth = self._within_budget(cleaned, settings)
        affine = grown(page_from_photo(strokes, page, settings.compose, pen), growth, page)
        return Portrait(photo, faces, chosen, strokes, drawing, affine, settings, stages.take_seconds())

    def _within_budget(self, drawing: Drawing, settings: Settings) -> tuple[Drawing, Floats]:
        """What of a drawing the budget allows, in order, and the map (2, 3) of the page that enlarged it."""
        if settings.select.minutes is None:
            selected = self._stages("select", select, drawing, settings.select)
            return self._stages("order", finished, selected, settings.compose, settings.order)
        budget = (settings.machine, settings.select, settings.compose, settings.order)
        return self._stages("order", timed, drawing, *budget)

    def _made_to_measure(self, part: Part, photo: Photo, face: Face, settings: Settings) -> tuple[Drawing, Strokes]:
        """A drawing of a style that is made for its budget, and what was seen for it; the face is the part's."""
        budget, style, stages = settings.select, settings.style, self._stages
        page, pen = settings.page.page(), settings.page.pen()
        joined = style == "one-line"

        def make(points: int) -> tuple[Drawing, Strokes]:
            count = points // settings.thread.points_per_dot if joined else points
            sized = settings.with_points(style, max(1, count))
            strokes = part.to_whole(draw_lines(part.photo, face, style, sized, stages), photo)
            placed = stages("compose", compose, strokes, page, settings.compose, pen)
            if joined:
                placed = stages("thread", thread, placed, settings.thread)
            return stages("order", order, placed, settings.order), strokes

        usual = settings.of_style(style).points
        if budget.minutes is None:
            return make(budget.points or usual)
        # Few points tell what one costs as well as many do.
        most, few = budget.points or _MOST_POINTS, usual // 3
        return made_within_time(make, few, most, 60 * budget.minutes, clock_of(settings.machine))

    def _draw_best(self, settings: Settings, crop: Box | None, number: int, face: Face | None) -> Portrait:
        """Draw in each of ``AUTO_STYLES`` within the budget, and keep the best; a style that draws nothing is out."""
        portraits, nothing = [], None
        for style in AUTO_STYLES:
            try:
                portraits.append(self.draw(settings.replace(style=style), crop=crop, number=number, face=face))
            except NothingToDraw as error:
                nothing = error
        if not portraits:
            raise nothing or NothingToDraw("no style drew anything")
        seen = [candidate(p.settings.style, p.likeness, p.ink_px(), p.drawing.region, p.face) for p in portraits]
        names = dict.fromkeys(name for portrait in portraits for name in portrait.seconds)
        seconds = {name: sum(portrait.seconds.get(name, 0.0) for portrait in portraits) for name in names}
        return dataclasses.replace(portraits[best(seen)], seconds=seconds, candidates=tuple(seen))


def draw(
    source: Source | Photo,
    settings: Settings | None = None,
    *,
    crop: Box | None = None,
    number: int = 1,
    face: Face | None = None,
    **changes: Any,
) -> Portrait:
    """Draw the person in a photo, once; a ``Session`` draws it again and again.

    Args:
        source: a photo, or anything ``load_photo`` reads.
        settings: of every stage.
        crop: x, y, width, height [px]: look and draw only there.
        number: which face, 1 = the largest.
        face: draw this one as it is, in the photo's pixels before the crop, instead of looking for one.
        changes: single settings by name, dots as double underscores: ``style="canny"``, ``points=600``,
            ``gabor__orientations=4``; ``points``, ``minutes`` and ``page`` are short for ``select.points``,
            ``select.minutes`` and ``page.size``.

    Raises:
        BadInput: the photo cannot be read, or a setting is outside its limits.
        NoFace: there is no such face.
        NothingToDraw: no line was found.
    """
    return Session(source).draw(settings, crop=crop, number=number, face=face, **changes)


def _loaded(source: Source | Photo) -> Photo:
    return source if isinstance(source, Photo) else load_photo(source)
