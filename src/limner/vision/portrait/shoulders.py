"""A photo, its face and the person's outline go in; neck and shoulders come out, in one line on each side."""

from __future__ import annotations

import cv2
import numpy as np

from limner import geometry
from limner.types import Face, Floats
from limner.vision.figure import Figure
from limner.vision.head import JAW, face_frame
from limner.vision.portrait.follow import Manner, follow
from limner.vision.portrait.hair import clutter, hair_of_head
from limner.vision.portrait.marks import Mark, runs
from limner.vision.portrait.seen import Seen
from limner.vision.raster import dilated, whole
from limner.vision.trace import smooth

ABOVE, BESIDE, DEEPER = 0.45, 1.35, 0.3
"""From so far above the chin, to so far aside of it, and so much deeper than other lines of the body
[outer-eye distances]."""

SEEN, GAP, SHORTEST = 0.04, 0.5, 0.45
"""Strength from which the outline is there on a calm background, how far it goes on unseen, and how long it is at least
[outer-eye distances]."""

BUSY = 0.125
"""Where the background's lines are as strong as this the outline may be one of them, and is left alone."""

FREE = 0.1
"""The neck begins so far from the outline of the face [outer-eye distances]."""

WORTH = 0.4
"""Less than what is seen within the outline: with few points the face comes first."""

MANNER = Manner(stiff=0.1, pull=0.1, smooth_px=6, broad=True)


def draw_shoulders(seen: Seen, face: Face, figure: Figure, body: float) -> list[Mark]:
    """The outline of neck and shoulders where it is seen.

    Args:
        seen: the photo.
        face: in it.
        figure: the person.
        body: how far below the chin the body is drawn [outer-eye distances]; 0 draws none.
    """
    unit = face.outer_eye_px
    busy, marks = clutter(seen, face, figure), []
    for guide in _guides(face, figure, body) if body > 0 and busy < BUSY else []:
        found = follow(seen, guide, 0.05 * unit, seen.coarse, MANNER)
        marks += [Mark(line, "body", WORTH) for line in found.parts(max(SEEN, busy), GAP * unit, SHORTEST * unit)]
    return marks


def _guides(face: Face, figure: Figure, body: float) -> list[Floats]:
    """The outline of the figure (n, 2) below the ears, where no hair hangs over it."""
    unit, frame = face.outer_eye_px, face_frame(face)
    jaw, chin = face.points_px[JAW], frame.from_photo(face.points_px[8])
    hair = dilated(hair_of_head(face, figure), round(0.05 * unit))
    guides = []
    outlines, _ = cv2.findContours(figure.figure.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    for outline in outlines:
        line = np.asarray(outline[:, 0], np.float64)
        out = frame.from_photo(line) - chin
        x, y = whole(line).T
        border = (line < 2).any(axis=1) | (line > np.array(figure.figure.shape[::-1]) - 3).any(axis=1)
        kept = (out[:, 1] > -ABOVE) & (out[:, 1] < body + DEEPER) & (np.abs(out[:, 0]) < BESIDE)
        kept &= ~border & ~hair[y, x] & (_away(line, jaw) > FREE * unit)
        start = int(np.argmin(kept))  # an outline is closed: it begins where nothing is kept
        line, kept = np.roll(line, -start, axis=0), np.roll(kept, -start)
        guides += [smooth(line[run], 6.0) for run in runs(kept) if len(run) > SHORTEST * unit]
    return guides


def _away(points: Floats, line: Floats) -> Floats:
    """Distance (n,) of points (n, 2) to a line."""
    away: Floats = geometry.distance_to_segments(points[:, None], line[:-1], line[1:]).min(axis=1)
    return away
