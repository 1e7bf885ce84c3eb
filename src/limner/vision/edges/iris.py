"""A photo, a face and its edge map go in; the edge map with irises and pupils drawn as circles comes out.

An iris is a few pixels wide: filters for lines see a tangle of its rim, the pupil, reflections and lashes there. But
it is a dark disc of known size in a bright eye, so the disc itself is looked for, as Daugman 1993
(doi:10.1109/34.244676) does: where the brightness jumps most from inside a circle to outside.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from limner.types import EdgeMap, Face, Floats
from limner.vision.raster import Image, Shape, blurred, depth, filtered

Index = NDArray[np.int64]

RADII = np.linspace(0.054, 0.08, 7)
"""Radius of an iris [outer-eye distances]: 11.7 mm across in people, whose outer corners are some 90 mm apart."""

PUPIL = 0.018
"""Radius at which the pupil is drawn [outer-eye distances], about a pen's width: it reads as a dot."""

LID = 0.015
"""How far beyond the landmarks of the lids the rim may show [outer-eye distances]."""

CLEAR_OF_LID_PX = 2
"""What is nearer than this to the landmarks of the lids is taken for a lid, and stays."""

SIDE_RAD = np.deg2rad(50.0)
"""The rim is looked for left and right, this far up and down from level; the lids cover the rest."""

LEAST_JUMP = 0.05
"""Jump of lightness (of black to white) below which there is no iris to be seen, as in a closed eye."""


@dataclass(frozen=True, eq=False)
class Disc:
    """A circle in a photo [px]: centre (2,) and radius."""

    centre: Floats
    radius: float


def find_irises(grey: Image, face: Face) -> tuple[Disc | None, ...]:
    """The iris of each eye in a picture (H, W) of the lightness, as ``find_iris`` has it."""
    return tuple(find_iris(grey, eye, face.outer_eye_px) for eye in _eyes(face))


def _eyes(face: Face) -> tuple[Floats, Floats]:
    return face.points_px[36:42], face.points_px[42:48]


def with_irises(edges: EdgeMap, irises: Sequence[Disc | None], face: Face) -> EdgeMap:
    """Replace what is drawn within each iris by its rim, as far as the lids leave it free, and the pupil.

    Args:
        edges: of the photo.
        irises: of each eye; none at all for no eye.
        face: in that photo.

    Returns:
        The edge map, unchanged where no iris is found.
    """
    mask, strength, angle = edges.mask.copy(), edges.strength.copy(), edges.angle_rad.copy()
    unit = face.outer_eye_px
    for eye, disc in zip(_eyes(face), irises, strict=False):
        if disc is None:
            continue
        opening = depth(eye, mask.shape, 2 * LID * unit)
        rows, columns = np.nonzero(opening > CLEAR_OF_LID_PX)
        tangle = np.hypot(columns - disc.centre[0], rows - disc.centre[1]) < disc.radius + CLEAR_OF_LID_PX
        mask[rows[tangle], columns[tangle]] = False
        for radius in (disc.radius, PUPIL * unit):
            columns, rows, tangent = _circle(disc.centre, radius, mask.shape)
            free = opening[rows, columns] >= -LID * unit
            columns, rows, tangent = columns[free], rows[free], tangent[free]
            mask[rows, columns], strength[rows, columns], angle[rows, columns] = True, 1, tangent
    return EdgeMap(mask, strength, angle)


def find_iris(grey: Image, eye_px: Floats, outer_eye_px: float) -> Disc | None:
    """The dark disc near the middle of an eye.

    Args:
        grey: (H, W) lightness.
        eye_px: (6, 2) landmarks of the eye.
        outer_eye_px: the unit of length on the face.

    Returns:
        None where no circle is darker inside than outside on both sides.
    """
    part, x0, y0 = _around(blurred(grey, 0.8), eye_px, 0.12 * outer_eye_px)
    if min(part.shape) < 3:
        return None
    likely = _likely(part.shape, eye_px - [x0, y0], outer_eye_px)
    best, found = 0.0, None
    for radius in RADII * outer_eye_px:
        sides = [filtered(part, kernel) for kernel in _jump_kernels(radius)]
        weaker = np.minimum(*sides)
        score = (weaker + 0.25 * np.maximum(*sides)) * likely
        row, column = np.unravel_index(score.argmax(), score.shape)
        if score[row, column] > best and weaker[row, column] >= LEAST_JUMP:
            best, found = float(score[row, column]), Disc(np.array([x0 + column, y0 + row], np.float64), float(radius))
    return found


def _around(grey: Image, eye_px: Floats, margin: float) -> tuple[Image, int, int]:
    """The part of the picture around an eye, and its upper left pixel."""
    height, width = grey.shape
    x0, y0 = np.clip(np.floor(eye_px.min(axis=0) - margin), 0, [width, height]).astype(int).tolist()
    x1, y1 = np.clip(np.ceil(eye_px.max(axis=0) + margin) + 1, 0, [width, height]).astype(int).tolist()
    return grey[y0:y1, x0:x1], x0, y0


def _likely(shape: Shape, eye_px: Floats, outer_eye_px: float) -> Image:
    """How likely the eye looks that way (H, W): far to the side, little up and down."""
    y, x = np.indices(shape)
    middle, width = eye_px.mean(axis=0), float(np.ptp(eye_px[:, 0]))
    beside = (x - middle[0]) / max(0.35 * width, 1)
    above = (y - middle[1]) / (0.04 * outer_eye_px)
    likely: Image = np.exp(-(beside**2 + above**2) / 2).astype(np.float32)
    return likely


def _jump_kernels(radius: float) -> list[Image]:
    """Filters for the mean brightness just outside a circle minus just inside, on its right and on its left."""
    reach = int(np.ceil(radius + 4))
    y, x = np.mgrid[-reach : reach + 1, -reach : reach + 1].astype(np.float64)
    distance, level = np.hypot(x, y), np.abs(np.arctan2(y, np.abs(x))) < SIDE_RAD
    kernels = []
    for side in (x > 0, x < 0):
        outer, inner = (np.exp(-(((distance - radius - d) / 0.8) ** 2)) * (level & side) for d in (1.5, -1.5))
        kernels.append((outer / outer.sum() - inner / inner.sum()).astype(np.float32))
    return kernels


def _circle(centre: Floats, radius: float, shape: Shape) -> tuple[Index, Index, Floats]:
    """Columns, rows and tangents of the pixels on a circle, those within the picture."""
    turn = 2 * np.pi * np.arange(256) / 256
    columns = np.rint(centre[0] + radius * np.cos(turn)).astype(np.int64)
    rows = np.rint(centre[1] + radius * np.sin(turn)).astype(np.int64)
    within = (columns >= 0) & (columns < shape[1]) & (rows >= 0) & (rows < shape[0])
    tangent = np.mod(turn + np.pi / 2, np.pi)
    return columns[within], rows[within], tangent[within]
