"""A photo and its face go in; wings, base and nostrils of the nose come out."""

from __future__ import annotations

import numpy as np

from limner.types import Face
from limner.vision.head import face_frame
from limner.vision.portrait.band import lenses
from limner.vision.portrait.follow import follow, settle
from limner.vision.portrait.marks import Mark, curve
from limner.vision.portrait.seen import Seen

SEEN = 0.025
"""Strength from which wings and base are there."""


def draw_nose(seen: Seen, face: Face) -> list[Mark]:
    """Wings and base in one line where they are seen, the nostrils dark."""
    unit, frame = face.outer_eye_px, face_frame(face)
    base = frame.from_photo(face.points_px[31:36])
    wing = np.array([[-0.03, -0.13], [-0.065, -0.06], [-0.045, 0.0]])
    around = np.concatenate([base[0] + wing, base, base[-1] + wing[::-1] * [-1, 1]])
    guide = curve(frame.to_photo(around))
    guide = guide + settle(seen, [guide], 0.08 * unit, seen.coarse)
    found = follow(seen, guide, 0.04 * unit, seen.coarse)
    marks = []
    for part in found.parts(SEEN, 0.08 * unit, 0.06 * unit):
        marks.append(Mark(part, "nose"))
        marks += [Mark(line, "nose", 1.0) for line in lenses(seen, part, unit)]
    return marks
