"""A photo and its face go in; the outline of the face from ear to ear comes out."""

from __future__ import annotations

from limner.types import Face
from limner.vision.head import JAW
from limner.vision.portrait.follow import Manner, follow
from limner.vision.portrait.marks import Mark, curve, taken
from limner.vision.portrait.seen import Seen

SEEN = 0.05
"""Strength from which the outline is there; between such places it goes on unseen."""

MANNER = Manner(stiff=0.12, pull=0.08, smooth_px=7, broad=True)


def draw_jaw(seen: Seen, face: Face) -> list[Mark]:
    """The outline of the face from ear to ear, in one line."""
    unit = face.outer_eye_px
    guide = curve(face.points_px[JAW])
    found = follow(seen, guide, 0.14 * unit, seen.coarse, MANNER)
    parts = found.parts(SEEN, 9 * unit, 0.3 * unit)
    return [Mark(max(parts, key=len), "jaw")] if parts else [Mark(taken(guide, 0.2, 0.8), "jaw")]
