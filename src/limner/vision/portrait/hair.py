"""A face and its figure go in; what is hair of the head, and how much the background looks like it, come out."""

from __future__ import annotations

import numpy as np

from limner import geometry
from limner.types import Face, Floats
from limner.vision.figure import Figure
from limner.vision.head import face_frame
from limner.vision.portrait.seen import Seen
from limner.vision.raster import Mask, Shape, dilated, distance_to_zero, pieces, whole

AROUND, BELOW = (0.15, 0.8), 0.6
"""The background shows its lines so far outside of the figure, above what is so far under the eyes
[outer-eye distances]."""

CLUTTER = 90
"""Percentile of their strength that a lock has to exceed."""

BESIDE, SHARE = 0.06, 0.3
"""A line is of the hair if hair is so near [outer-eye distances] along this share of it."""


def hair_of_head(face: Face, figure: Figure) -> Mask:
    """The pieces (H, W) of the hair that reach above the eyes: the others are dark clothes, or a beard."""
    _, labels = pieces(figure.hair)
    above = places(face, labels.shape)[..., 1] < 0
    return figure.hair & np.isin(labels, np.unique(labels[figure.hair & above]))


def places(face: Face, shape: Shape) -> Floats:
    """Each pixel (H, W, 2) in the frame of the face."""
    return face_frame(face).from_photo(np.moveaxis(np.indices(shape)[::-1], 0, -1).astype(np.float64))


def clutter(seen: Seen, face: Face, figure: Figure) -> float:
    """How strong the lines of the background are around the head: what is weaker may be one of them."""
    away = distance_to_zero((~figure.figure).astype(np.uint8)) / face.outer_eye_px
    around = (away > AROUND[0]) & (away < AROUND[1]) & (places(face, away.shape)[..., 1] < BELOW)
    return float(np.percentile(seen.both[around], CLUTTER)) if around.any() else 0.0


def beside_hair(line: Floats, hair: Mask, unit: float) -> bool:
    """Whether a line [px] runs along hair (H, W)."""
    x, y = whole(geometry.resample(line, 2.0)).T
    return bool(dilated(hair, round(BESIDE * unit))[y, x].mean() > SHARE)
