"""A photo and its face go in; both brows come out."""

from __future__ import annotations

import numpy as np

from limner.types import Face
from limner.vision.head import BROWS, face_frame
from limner.vision.portrait.band import Band, fill, measure, tapered
from limner.vision.portrait.follow import Manner, follow, settle
from limner.vision.portrait.marks import Mark, curve
from limner.vision.portrait.seen import Seen
from limner.vision.portrait.tofro import to_and_fro

HAIRS_PX = 2.1
"""Distance of the strokes of a brow: paper shows between them."""

TURN_PX = 8.0
"""The pen goes on with the next stroke of a brow over such a distance."""

FAINT, BEYOND = 0.4, 0.12
"""A brow ends where it is less dark than this share of what it usually is, but so much of it at most is left out at
either end."""

MANNER = Manner(stiff=0.05, smooth_px=4, broad=True)


def draw_brows(seen: Seen, face: Face, most: int) -> list[Mark]:
    """Each brow as a few strokes along its hairs, as many as it is thick."""
    unit, marks = face.outer_eye_px, []
    down, reach = face_frame(face).axes_px[1], np.full(seen.grey.shape, TURN_PX, np.float32)
    for brow in (BROWS[0][::-1], BROWS[1]):  # from the nose outward
        guide = curve(face.points_px[brow]) + 0.03 * down
        guide = guide + settle(seen, [guide], 0.08 * unit, seen.coarse)
        found = follow(seen, guide, 0.045 * unit, seen.coarse, MANNER)
        band = tapered(_dark(measure(seen, found.line, 0.075 * unit)), 0.1, 0.45)
        strokes = fill(band, HAIRS_PX, most)
        marks += [Mark(line, "brow", 0.8) for line in to_and_fro(strokes, reach)]
    return marks


def _dark(band: Band) -> Band:
    """The band without ends that are no darker than skin: landmarks may lie beyond the hairs."""
    most = int(BEYOND * len(band.axis))
    dark = np.flatnonzero(band.contrast >= FAINT * np.median(band.contrast))
    return band.part(np.arange(min(dark[0], most), max(dark[-1] + 1, len(band.axis) - most)))
