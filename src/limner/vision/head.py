"""A face goes in; its upright frame and the ellipse around the whole head come out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from limner.types import Face, Floats

EYES = ([36, 37, 38, 39, 40, 41, 36], [42, 43, 44, 45, 46, 47, 42])
BROWS = ([17, 18, 19, 20, 21], [22, 23, 24, 25, 26])
NOSTRILS = [31, 32, 33, 34, 35]
LIPS, INNER_LIPS = [*range(48, 60), 48], [*range(60, 68), 60]
JAW = list(range(17))
"""Landmarks along the features, closed ones back to the first."""

HAIR = 1.15
"""Height of the head with its hair above the eyes over that of the chin below them (1 for the skull alone)."""

EARS = 1.04
"""Width of the head over the distance of the jaw's upper ends, which iBUG puts in front of the ears."""

FOREHEAD = 0.45
"""How far above the brows the face goes on before hair is more likely [outer-eye distances]."""


@dataclass(frozen=True, eq=False)
class Frame:
    """The face set upright: origin between the eyes, x along them to image right, y down, one outer-eye distance long.

    Attributes:
        origin_px: (2,) in the photo.
        axes_px: (2, 2) its x and y axes as rows, each one outer-eye distance long.
    """

    origin_px: Floats
    axes_px: Floats

    def from_photo(self, points_px: Floats) -> Floats:
        """Points (..., 2) of the photo [px] in this frame [outer-eye distances]."""
        inside: Floats = (points_px - self.origin_px) @ self.axes_px.T / (self.axes_px[0] ** 2).sum()
        return inside

    def to_photo(self, points: Floats) -> Floats:
        """Points (..., 2) of this frame [outer-eye distances] in the photo [px]."""
        outside: Floats = points @ self.axes_px + self.origin_px
        return outside


@dataclass(frozen=True, eq=False)
class Ellipse:
    """An upright ellipse in the frame of a face [outer-eye distances].

    Attributes:
        centre: (2,).
        radii: (2,) half width and half height.
    """

    centre: Floats
    radii: Floats

    def points(self, count: int) -> Floats:
        """``count`` points (count, 2) around it."""
        turn = 2 * np.pi * np.arange(count) / count
        around: Floats = self.centre + self.radii * np.stack([np.sin(turn), -np.cos(turn)], axis=1)
        return around

    def level(self, points: Floats) -> Floats:
        """How far out points (..., 2) lie: 0 at the centre, 1 on the ellipse."""
        relative = (points - self.centre) / self.radii
        far: Floats = np.hypot(relative[..., 0], relative[..., 1])
        return far


def face_frame(face: Face) -> Frame:
    """The upright frame of a frontal face.

    Raises:
        BadInput: a profile, or both outer eye corners are one point.
    """
    unit = face.outer_eye_px
    along = (face.points_px[45] - face.points_px[36]) / unit
    down = np.array([-along[1], along[0]])
    if (face.points_px[8] - face.points_px[27]) @ down < 0:  # the photo is mirrored or upside down: the chin decides
        down = -down
    return Frame((face.points_px[36] + face.points_px[45]) / 2, unit * np.stack([along, down]))


def head_ellipse(face: Face) -> Ellipse:
    """The ellipse around the whole head (thesis 3.5), in the face's frame.

    The landmarks end at the brows. A head is about as high above its eyes as below them, so the jaw says how high the
    top is; the width is that of the jaw at the ears.
    """
    jaw = face_frame(face).from_photo(face.points_px[:17])
    left, right = jaw[:, 0].min(), jaw[:, 0].max()
    bottom = max(float(jaw[:, 1].max()), 0.1)
    radii = np.array([max(EARS * (right - left) / 2, 0.1), (1 + HAIR) * bottom / 2])
    return Ellipse(np.array([(left + right) / 2, bottom - radii[1]]), radii)


def face_outline(face: Face) -> Floats:
    """Corners (n, 2) [px] around the face: the jaw, and up to half of the forehead, where hair may begin."""
    frame = face_frame(face)
    jaw, brows = frame.from_photo(face.points_px[:17]), frame.from_photo(face.points_px[17:27])
    top = brows[:, 1].min() - FOREHEAD
    corners = [[jaw[16, 0], top + 0.25], [0.5, top], [-0.5, top], [jaw[0, 0], top + 0.25]]
    return frame.to_photo(np.concatenate([jaw, corners]))


def inside(points: Floats, polygon: Floats) -> NDArray[np.bool_]:
    """Which points (n, 2) lie inside a polygon (m, 2): a ray to the right crosses its sides an odd number of times."""
    x, y = points[:, 0, None], points[:, 1, None]
    a, b = polygon, np.roll(polygon, -1, axis=0)
    spans = (a[:, 1] > y) != (b[:, 1] > y)
    rise = np.where(a[:, 1] == b[:, 1], 1.0, b[:, 1] - a[:, 1])
    crossing = a[:, 0] + (y - a[:, 1]) / rise * (b[:, 0] - a[:, 0])
    odd: NDArray[np.bool_] = (spans & (x < crossing)).sum(axis=1) % 2 == 1
    return odd
