"""Millimetres on a sheet of paper go in; poses of the pen in an arm's base frame come out, and the thesis's mapping."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from limner import transforms
from limner.errors import BadInput
from limner.types import Floats, Value, frozen_array

_FLIP = transforms.rotation((1.0, 0.0, 0.0), np.pi)
"""The pen points down: its z axis against the paper's."""


@dataclass(frozen=True, eq=False)
class Placement(Value):
    """Where a sheet lies and how the pen is held over it.

    Attributes:
        base_from_paper: (4, 4) rigid; the paper frame has its origin at the sheet's lower left corner, x right,
            y up the sheet, z out of it [m].
        spin_rad: turn of the tool about the pen, which draws the same.
        lean_rad: how far the pen leans from upright.
        lean_towards_rad: direction in the paper frame that the pen's upper end leans to.
    """

    base_from_paper: Floats
    spin_rad: float = 0.0
    lean_rad: float = 0.0
    lean_towards_rad: float = 0.0

    def __post_init__(self) -> None:
        self._freeze("base_from_paper", frozen_array(self.base_from_paper, np.float64, (4, 4), "base_from_paper"))
        turn = self.base_from_paper[:3, :3]
        rigid = np.allclose(turn.T @ turn, np.eye(3), atol=1e-6) and np.linalg.det(turn) > 0
        if not rigid or not np.array_equal(self.base_from_paper[3], (0, 0, 0, 1)):
            raise BadInput("base_from_paper: expected a rotation and a translation, got another matrix")

    @classmethod
    def flat(
        cls, centre_m: ArrayLike, size_mm: tuple[float, float], turn_rad: float = 0.0, spin_rad: float = 0.0
    ) -> Placement:
        """A level sheet, its centre (3,) in the base frame, turned about the vertical."""
        turn = transforms.rotation((0.0, 0.0, 1.0), turn_rad)
        corner = np.asarray(centre_m, dtype=np.float64) - turn @ np.array([*size_mm, 0.0]) / 2000
        return cls(transforms.transform(turn, corner), spin_rad)

    def orientation(self) -> Floats:
        """Of the tip in the base frame (3, 3), the same at every point."""
        axis = np.array([-np.sin(self.lean_towards_rad), np.cos(self.lean_towards_rad), 0.0])
        lean = transforms.rotation(axis, self.lean_rad)
        spin = transforms.rotation((0.0, 0.0, 1.0), self.spin_rad)
        turned: Floats = self.base_from_paper[:3, :3] @ lean @ spin @ _FLIP
        return turned

    def points_m(self, points_mm: ArrayLike) -> Floats:
        """Points (..., 2) or (..., 3) of the paper frame [mm] in the base frame (..., 3) [m]."""
        points = np.asarray(points_mm, dtype=np.float64) / 1000
        if points.shape[-1] == 2:
            points = np.concatenate([points, np.zeros((*points.shape[:-1], 1))], axis=-1)
        return transforms.apply(self.base_from_paper, points)

    def points_mm(self, points_m: ArrayLike) -> Floats:
        """Points (..., 3) of the base frame [m] in the paper frame [mm]."""
        return 1000 * transforms.apply(transforms.inverse(self.base_from_paper), points_m)

    def tips(self, points_mm: ArrayLike) -> Floats:
        """Poses (..., 4, 4) of the pen's tip in the base frame at points (..., 2) or (..., 3) of the paper [mm]."""
        return transforms.transform(self.orientation(), self.points_m(points_mm))


@dataclass(frozen=True)
class PlaneMapping:
    """The thesis's linear map between a picture and the drawing area (eq. 4.1): four numbers.

    x' = a x + b y + c and y' = -a y + b x + d, where (x, y) is on the table and (x', y') in the picture.
    """

    a: float
    b: float
    c: float
    d: float

    @classmethod
    def between(cls, table: ArrayLike, picture: ArrayLike) -> PlaneMapping:
        """The map that takes two points of the table (2, 2) to two of the picture (2, 2).

        Raises:
            BadInput: both points of the table lie where the four equations do not tell them apart.
        """
        (x1, y1), (x2, y2) = np.asarray(table, dtype=np.float64)
        matrix = np.array([[x1, y1, 1, 0], [-y1, x1, 0, 1], [x2, y2, 1, 0], [-y2, x2, 0, 1]])
        if abs(np.linalg.det(matrix)) < 1e-15:
            raise BadInput("mapping: both corners of the drawing area are one point; expected two places")
        a, b, c, d = np.linalg.solve(matrix, np.asarray(picture, dtype=np.float64).ravel())
        return cls(float(a), float(b), float(c), float(d))

    def to_picture(self, table: ArrayLike) -> Floats:
        """Points (..., 2) of the table in the picture."""
        points = np.asarray(table, dtype=np.float64)
        result: Floats = points @ self._matrix().T + (self.c, self.d)
        return result

    def to_table(self, picture: ArrayLike) -> Floats:
        """Points (..., 2) of the picture on the table."""
        points = np.asarray(picture, dtype=np.float64) - (self.c, self.d)
        result: Floats = points @ np.linalg.inv(self._matrix()).T
        return result

    def _matrix(self) -> Floats:
        return np.array([[self.a, self.b], [self.b, -self.a]])


THESIS_AREA_M = ((-0.5221, 0.476), (-0.113, 0.264))
"""Upper left and lower right corner of the thesis's drawing area in ``arm_base_link`` (section 4.3)."""
