"""A photo, its face and the person's outline go in; the strokes of the style `portrait` come out, heaviest first."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from limner import geometry
from limner.types import Face, Floats, Strokes
from limner.vision.figure import Figure
from limner.vision.portrait.beard import draw_beard
from limner.vision.portrait.brows import draw_brows
from limner.vision.portrait.eyes import draw_eyes
from limner.vision.portrait.jaw import draw_jaw
from limner.vision.portrait.marks import Mark, runs
from limner.vision.portrait.masses import draw_masses
from limner.vision.portrait.mouth import draw_mouth
from limner.vision.portrait.nose import draw_nose
from limner.vision.portrait.rest import draw_rest
from limner.vision.portrait.seen import Seen
from limner.vision.portrait.settings import PortraitSettings
from limner.vision.portrait.shoulders import draw_shoulders
from limner.vision.regions import RegionSettings

NOTHING = 0.02
"""Where no line is stronger there is none."""

TOLERANCE_PX = 0.25
"""How far a line may move when points on nearly straight parts are dropped."""


def portrait_strokes(
    seen: Seen, face: Face, figure: Figure, settings: PortraitSettings, importance: RegionSettings
) -> Strokes:
    """Features where the landmarks say they are and the photo shows them, then all else that is clear.

    Args:
        seen: a photo at the working scale.
        face: a frontal one in it.
        figure: the person in it.
        settings: how much is drawn.
        importance: of the regions.

    Returns:
        Strokes in the pixels of the photo; none where nothing is seen.
    """
    size_px = seen.grey.shape[1], seen.grey.shape[0]
    if seen.coarse.max() < NOTHING:
        return Strokes((), (), np.zeros(0), size_px)
    marks: list[Mark] = [
        *draw_eyes(seen, face),
        *draw_brows(seen, face, settings.brow_strokes),
        *draw_nose(seen, face),
        *draw_mouth(seen, face, settings.flow),
        *draw_jaw(seen, face),
        *draw_shoulders(seen, face, figure, settings.body),
    ]
    marks += draw_beard(face, figure)
    marks += draw_rest(seen, face, figure, marks, settings)
    marks += draw_masses(seen, face, figure, marks, settings.dark_apart)
    return _weighed(marks, face, size_px, importance)


def _weighed(marks: Sequence[Mark], face: Face, size_px: tuple[int, int], importance: RegionSettings) -> Strokes:
    """The marks as strokes, each worth its length [outer-eye distances] times the importance of its region."""
    inside = [dataclasses.replace(mark, line=part) for mark in marks for part in _within(mark.line, size_px)]
    weights = np.array([
        geometry.length(mark.line) / face.outer_eye_px * getattr(importance, mark.region) * mark.worth
        for mark in inside
    ])  # fmt: skip
    order = np.argsort(-weights, kind="stable")
    lines = geometry.simplify_all([inside[i].line for i in order], TOLERANCE_PX)
    return Strokes(tuple(lines), tuple(inside[i].region for i in order), weights[order], size_px)


def _within(line: Floats, size_px: tuple[int, int]) -> list[Floats]:
    """The parts of a line in the picture."""
    free = np.asarray(((line >= -0.5) & (line <= np.array(size_px) - 0.5)).all(axis=1), np.bool_)
    return [line] if free.all() else [line[run] for run in runs(free) if len(run) > 1]
