"""A photo and a face go in; the strokes of a line portrait come out (thesis 3.1, 3.5, 4.3)."""

from __future__ import annotations

import numpy as np

from limner.errors import BadInput
from limner.settings import NONE
from limner.stages import Stages
from limner.types import Face, Photo, Strokes
from limner.vision.completion import complete
from limner.vision.lines.settings import LineSettings
from limner.vision.lines.sitter import Sitter
from limner.vision.lines.styles import MEASURED, STYLES, WAYS
from limner.vision.tone import hatch


def draw_lines(photo: Photo, face: Face, style: str, settings: LineSettings, stages: Stages | None = None) -> Strokes:
    """Strokes of a photo, the heaviest first.

    Args:
        photo: any size.
        face: a frontal face in it.
        style: one of ``STYLES``.
        settings: of every stage.
        stages: what remembers the stages of earlier drawings; not given: all is done anew.

    Returns:
        Strokes in the pixels of the photo; none where nothing is seen.

    Raises:
        BadInput: no such style, a profile, a face of a few pixels, or one outside the photo.
    """
    if style not in STYLES:
        raise BadInput(f"style: '{style}' does not exist; choose from {', '.join(STYLES)}")
    sitter = Sitter(photo, face, settings, stages or Stages())
    strokes = WAYS[style](sitter)
    if style in MEASURED:
        return strokes
    completed = sitter.stages(
        "complete", complete, strokes, face, settings.complete, settings.completion, settings.regions
    )
    return completed if settings.tone.level == NONE else _shaded(completed, sitter)


def without_effect(style: str, settings: LineSettings) -> tuple[str, ...]:
    """A line for each setting that was changed and does nothing in a style: dots and streamlines are tone already."""
    if style not in MEASURED:
        return ()
    changed = {"--tone": settings.tone.level != NONE, "--complete": settings.complete != NONE}
    return tuple(f"{name} does nothing in the style '{style}', which is all tone" for name in changed if changed[name])


def _shaded(strokes: Strokes, sitter: Sitter) -> Strokes:
    """The strokes and hatching after them."""
    working, figure, seen = sitter.working, sitter.figure, sitter.in_working(strokes)
    tone = sitter.settings.tone
    hatching = sitter.in_photo(sitter.stages("tone", hatch, working.photo, working.face, figure, seen, tone))
    return Strokes(
        strokes.lines_px + hatching.lines_px,
        strokes.region + hatching.region,
        np.concatenate([strokes.weight, hatching.weight]),
        strokes.size_px,
        strokes.pens,
        np.concatenate([strokes.layer, np.zeros(len(hatching.lines_px), np.int64)]),
    )
