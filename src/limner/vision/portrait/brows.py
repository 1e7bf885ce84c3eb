"""A photo and its face go in; both brows come out."""

from __future__ import annotations

from limner.types import Face
from limner.vision.head import BROWS, face_frame
from limner.vision.portrait.band import fill, measure, tapered
from limner.vision.portrait.follow import Manner, follow, settle
from limner.vision.portrait.marks import Mark, curve
from limner.vision.portrait.seen import Seen

HAIRS_PX = 2.1
"""Distance of the strokes of a brow: paper shows between them."""

MANNER = Manner(stiff=0.05, smooth_px=4, broad=True)


def draw_brows(seen: Seen, face: Face, most: int) -> list[Mark]:
    """Each brow as a few strokes along its hairs, as many as it is thick."""
    unit, marks = face.outer_eye_px, []
    down = face_frame(face).axes_px[1]
    for brow in (BROWS[0][::-1], BROWS[1]):  # from the nose outward
        guide = curve(face.points_px[brow]) + 0.03 * down
        guide = guide + settle(seen, [guide], 0.08 * unit, seen.coarse)
        found = follow(seen, guide, 0.045 * unit, seen.coarse, MANNER)
        band = tapered(measure(seen, found.line, 0.075 * unit), 0.1, 0.45)
        strokes = fill(band, HAIRS_PX, most)
        marks += [Mark(line, "brow", 1.0 if i == len(strokes) // 2 else 0.7) for i, line in enumerate(strokes)]
    return marks
