"""A face and its photo in; a sheet of what each correction makes of its landmarks, and words on what was moved, out."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from limner import pipeline
from limner.errors import BadInput
from limner.pipeline import Settings
from limner.targets.overlay import overlay
from limner.targets.sheet import Tile, to_sheet
from limner.types import Face, Photo
from limner.vision.refine import REFINEMENTS, names_of, refine_in_steps
from limner.vision.scale import ScaleSettings, to_working_scale

THESIS = "jaw-gradient,brows,jaw-spline"
"""What the thesis settled on for the jaw and the brows (3.3.2, 3.3.5)."""

_VIEW = ScaleSettings(outer_eye_px=260.0, beside=1.0, above=0.75, below=1.75)


def describe_refinement(found: Face, refined: Face, settings: Settings) -> str:
    """One line on how far a face's landmarks were moved by what."""
    names = names_of(pipeline.refinements(settings))
    if not names or not found.frontal:
        return "  landmarks as they were found"
    move = 100 * float(np.hypot(*(refined.points_px - found.points_px).T).mean()) / found.outer_eye_px
    if move == 0:
        return f"  {', '.join(names)}: unsure or nothing to do; landmarks as they were found"
    return f"  {', '.join(names)}: landmarks moved by {move:.1f} % of the outer-eye distance on average"


def refinement_sheet(photo: Photo, face: Face, settings: Settings) -> NDArray[np.uint8]:
    """The face as found, after each correction alone, and after the thesis's and the wanted sequence.

    Raises:
        BadInput: a profile, a face of a few pixels, or one outside the photo.
    """
    if not face.frontal:
        raise BadInput("refine-compare: a profile of 39 landmarks has no corrections; expected a frontal face")
    sequences = list(dict.fromkeys([*REFINEMENTS, THESIS, ",".join(names_of(pipeline.refinements(settings)))]))
    tiles = [Tile(_view(photo, face), "as found", f"{face.detector}, score {face.score:.2f}")]
    return to_sheet(tiles + [_tile(photo, face, names, settings) for names in sequences if names], columns=3)


def _tile(photo: Photo, face: Face, names: str, settings: Settings) -> Tile:
    steps = refine_in_steps(photo, face, names, settings.refinement)
    moves = " + ".join(f"{100 * step.move:.1f} %" for step in steps[1:])
    unsure = names == "best" and steps[-1].face is face
    return Tile(_view(photo, steps[-1].face), names, "unsure: as found" if unsure else f"moved {moves}")


def _view(photo: Photo, face: Face) -> NDArray[Any]:
    working = to_working_scale(photo, face, _VIEW)
    return overlay(working.photo, [working.face])
