"""A photo, its face, the person and the lines drawn go in; a few strokes along dark hair come out.

Black hair shows no strands: left white between its outlines it looks like a bald head.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from limner import geometry
from limner.types import Face
from limner.vision.figure import Figure
from limner.vision.hatching.darkness import darkness_of, within
from limner.vision.hatching.direction import along_strands, around_head, halved
from limner.vision.hatching.streamlines import Ground, streamlines
from limner.vision.head import JAW, face_frame, face_outline
from limner.vision.portrait.hair import hair_of_head, places
from limner.vision.portrait.marks import Mark
from limner.vision.portrait.seen import Seen
from limner.vision.portrait.tofro import to_and_fro
from limner.vision.raster import Image, Mask, blurred, distance_to_zero, filled
from limner.vision.trace import smooth

DARK, FADE = 0.55, 0.15
"""Darkness, on the person's own scale, from which hair is drawn dark; over how much more its strokes end."""

CALM = 0.03
"""Over what darkness is averaged: single shining hairs are no light [outer-eye distances]."""

STRANDS, SHY = 0.07, 1e-4
"""Over what the direction of hair is averaged [outer-eye distances], and how strongly it runs around the head else."""

SHORTEST, LEAST = 0.2, 0.4
"""Length of the shortest stroke, and of what is drawn of them in one [outer-eye distances]."""

TURN = 1.6
"""The hand turns over so many distances of strokes."""

NARROW, CLOSEST, NEARBY = 0.6, 0.04, 0.3
"""In a narrow band strokes lie closer: this share of half its width apart, but not closer than the second, the band
being as wide as its widest place so near [outer-eye distances]."""

TEMPLES = -0.15
"""What is dark above this beside the face is hair, taken for skin or not [outer-eye distances under the eyes]."""

LOW, OUT = 0.1, 0.5
"""Dark hair ends so far above the chin, as what is lower may be clothes, and over so much not all at once
[outer-eye distances]."""

SMOOTH_PX = 5.0

WORTH = 0.04
"""Less than any line: what is dark comes last."""


def draw_masses(seen: Seen, face: Face, figure: Figure, drawn: Sequence[Mark], apart: float) -> list[Mark]:
    """Strokes that say that hair is dark, where no line says it.

    Args:
        seen: the photo.
        face: in it.
        figure: the person.
        drawn: what is there already; strokes keep away from it.
        apart: distance of the strokes [outer-eye distances]; 0 draws none.
    """
    unit = face.outer_eye_px
    hair, out = _hair(face, figure)
    if apart == 0 or not hair.any():
        return []
    tone = within(darkness_of(100 * seen.grey, face, figure), hair, CALM * unit)
    dark = hair & (tone > DARK)
    strands = along_strands(blurred(seen.grey, 0.01 * unit), around_head(face, dark.shape), STRANDS * unit, SHY)
    fade = np.minimum((tone - np.float32(DARK)) / np.float32(FADE), out)
    spacing = _spacing(dark, apart, unit)
    ground = Ground(*halved(strands), spacing, fade, dark.astype(np.uint8))
    lines = [smooth(line, SMOOTH_PX) for line in streamlines(ground, [mark.line for mark in drawn], SHORTEST * unit)]
    joined = to_and_fro(lines, np.float32(TURN) * spacing)
    return [Mark(line, "hair", WORTH) for line in joined if geometry.length(line) > LEAST * unit]


def _hair(face: Face, figure: Figure) -> tuple[Mask, Image]:
    """Where (H, W) what is dark is hair, and how far from its end below: 0 there, 1 where all strokes go on."""
    shape = figure.hair.shape
    down = places(face, shape)[..., 1]
    left = face_frame(face).from_photo(face.points_px[JAW])[:, 1].max() - LOW - down
    temples = figure.skin & ~filled(face_outline(face), shape) & (down < TEMPLES)
    hair: Mask = (hair_of_head(face, figure) & (left > 0)) | temples
    return hair, (left / OUT).astype(np.float32)


def _spacing(dark: Mask, apart: float, unit: float) -> Image:
    """Wanted distance of the strokes (H, W) [px], 0 where there are none."""
    deep = distance_to_zero(np.pad(dark, 1).astype(np.uint8))[1:-1, 1:-1]
    side = 2 * round(NEARBY / 2 * unit) + 1
    widest = np.asarray(cv2.dilate(deep, np.ones((side, side), np.uint8)))
    spacing = np.clip(NARROW * widest, min(CLOSEST, apart) * unit, apart * unit)
    return np.where(dark, spacing, 0).astype(np.float32)
