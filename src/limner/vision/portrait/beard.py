"""A face and the person's outline go in; the strokes of the beard come out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from limner.types import Face, Floats
from limner.vision.figure import Figure
from limner.vision.head import face_frame
from limner.vision.portrait.marks import Mark, runs
from limner.vision.raster import Mask, dilated, filled, whole

COVERED = 0.4
"""A beard covers at least this share of the chin."""

APART, FAR = 0.03, 1.2
"""Distance of the turns of the pen [outer-eye distances], so far from the root of the nose."""

SPREAD, REACH = np.deg2rad(110.0), 2.2
"""Hairs grow away from the root of the nose, down and to both sides up to here, so far [outer-eye distances]."""

SHORTEST, MOST = 0.06, 0.45
"""What is no longer is no beard; the pen goes up by as much as the second at most [outer-eye distances]."""

FEWEST = 4
"""Turns of a stroke; one with fewer is none."""

RAGGED = (0.6, 0.3)
"""Share of a hair by which its upper and its lower end may lie within the beard: even ends look like a saw."""

GOLDEN = 0.6180339887498949
"""Multiples of it, less their whole part, are spread evenly: chance that is the same every time."""

WORTH = 0.3
"""Less than any line of the face."""


def beard_of(face: Face, figure: Figure) -> Mask:
    """The beard (H, W), if it covers the chin: what is dark at the border of the face alone is shadow."""
    chin = filled(face.points_px[[6, 7, 8, 9, 10, 55, 57, 59]], figure.beard.shape)
    covered = chin.any() and bool(figure.beard[chin].mean() > COVERED)
    lips = dilated(filled(face.points_px[48:60], chin.shape), round(0.04 * face.outer_eye_px))
    return figure.beard & ~lips if covered else np.zeros_like(chin)


def draw_beard(face: Face, figure: Figure) -> list[Mark]:
    """Hairs to and fro without lifting the pen, in the direction they grow, from one side of the beard to the other.

    Args:
        face: in the photo.
        figure: the person.
    """
    beard = beard_of(face, figure)
    if not beard.any():
        return []
    rays = _rays(face)
    rows: list[_Row] = []
    for ray in rays:
        going, rows_here = [row for row in rows if row.open], _hairs(ray, beard, face.outer_eye_px)
        for row in going:
            row.open = False
        for hair in rows_here:
            fitting = [row for row in going if not row.open and row.overlap(hair) > 0]
            row = max(fitting, key=lambda row: row.overlap(hair), default=_Row([], []))
            if not row.hairs:
                rows.append(row)
            row.add(hair, ray)
    return [Mark(row.line(), "face", WORTH) for row in rows if len(row.hairs) >= FEWEST]


@dataclass(eq=False)
class _Row:
    """Hairs beside each other: from where to where each reaches on its ray, and where they turn the pen [px]."""

    hairs: list[tuple[int, int]]
    turns: list[Floats]
    open: bool = True

    def overlap(self, hair: tuple[int, int]) -> int:
        """How much of the last hair lies beside another."""
        return min(self.hairs[-1][1], hair[1]) - max(self.hairs[-1][0], hair[0])

    def add(self, hair: tuple[int, int], ray: Floats) -> None:
        """Go on to another hair: up on one ray, down on the next."""
        down = len(self.turns) % 2
        within = RAGGED[down] * (len(self.turns) * GOLDEN % 1) * (hair[1] - hair[0])
        self.hairs.append(hair)
        self.turns.append(ray[int(hair[1] - within if down else hair[0] + within)])
        self.open = True

    def line(self) -> Floats:
        """(n, 2) all of it [px]."""
        return np.array(self.turns)


def _rays(face: Face) -> list[Floats]:
    """Lines (n, 2) away from the root of the nose, from the left of the photo to the right, a point every pixel."""
    unit, frame = face.outer_eye_px, face_frame(face)
    angles = np.arange(SPREAD, -SPREAD, -APART / FAR)
    ways = np.stack([-np.sin(angles), np.cos(angles)], axis=1) @ frame.axes_px
    ways /= np.hypot(*ways.T)[:, None]
    return [face.points_px[27] + np.arange(REACH * unit)[:, None] * way for way in ways]


def _hairs(ray: Floats, beard: Mask, unit: float) -> list[tuple[int, int]]:
    """From where to where [px] a ray runs through a beard (H, W)."""
    x, y = whole(ray).T
    inside = (x >= 0) & (y >= 0) & (x < beard.shape[1]) & (y < beard.shape[0])
    hairy = np.zeros(len(ray), bool)
    hairy[inside] = beard[y[inside], x[inside]]
    return [
        (max(int(run[0]), int(run[-1] - MOST * unit)), int(run[-1]))
        for run in runs(hairy)
        if len(run) > SHORTEST * unit
    ]
