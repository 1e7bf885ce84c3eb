"""Millimetres on a sheet of paper go in; poses of the pen in an arm's base frame come out, and the thesis's mapping."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from limner import transforms
from limner.errors import BadInput
from limner.types import Drawing, Floats, Page, Value, frozen_array

_FLIP = transforms.rotation((1.0, 0.0, 0.0), np.pi)
"""The pen points down: its z axis against the paper's."""

_FLAT_MM = 1.0
"""Pen-down places farther than this from their plane lie on no sheet."""

_SPREAD_MM = 3.0
"""Places less wide than this tell no plane; the pen's axis does."""

_FULL_SWING_MM = 40.0
"""A smaller drawing does not swing the pen as far, or the hand would have to move against it."""


@dataclass(frozen=True, eq=False)
class Placement(Value):
    """Where a sheet lies and how the pen is held over it.

    Attributes:
        base_from_paper: (4, 4) rigid; the paper frame has its origin at the sheet's lower left corner, x right,
            y up the sheet, z out of it [m].
        spin_rad: turn of the tool about the pen, which draws the same.
        lean_rad: how far the pen leans from upright.
        lean_towards_rad: direction in the paper frame that the pen's upper end leans to.
        swing_rad_per_mm: how far it leans besides towards a place of the sheet, for each millimetre from there: then
            the hand moves less than the pen does, as that of a person who writes.
        swing_about_mm: (x, y) of that place.
    """

    base_from_paper: Floats
    spin_rad: float = 0.0
    lean_rad: float = 0.0
    lean_towards_rad: float = 0.0
    swing_rad_per_mm: float = 0.0
    swing_about_mm: tuple[float, float] = (0.0, 0.0)

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

    def corners_m(self, size_mm: tuple[float, float]) -> Floats:
        """(4, 3) of a sheet of this size, counter-clockwise from the lower left, in the base frame."""
        width, height = size_mm
        return self.points_m([(0, 0), (width, 0), (width, height), (0, height)])

    def swung(self, swing_rad: float, points_mm: Floats) -> Placement:
        """The same, the pen leaning by up to an angle towards the middle of points (n, 2 or 3) of the paper."""
        low, high = points_mm[:, :2].min(0), points_mm[:, :2].max(0)
        x, y = (low + high) / 2
        farthest = float(np.hypot(*(points_mm[:, :2] - (x, y)).T).max())
        rate = swing_rad / max(farthest, _FULL_SWING_MM)
        return dataclasses.replace(self, swing_rad_per_mm=rate, swing_about_mm=(float(x), float(y)))

    def orientations(self, points_mm: ArrayLike) -> Floats:
        """Of the tip in the paper frame (..., 3, 3) at points (..., 2) or (..., 3) of the paper [mm]."""
        away = np.asarray(points_mm, dtype=np.float64)[..., :2] - self.swing_about_mm
        swing = leant(self.swing_rad_per_mm * np.hypot(away[..., 0], away[..., 1]), _direction(-away))
        turned: Floats = (
            swing
            @ leant(self.lean_rad, self.lean_towards_rad)
            @ transforms.rotation((0.0, 0.0, 1.0), self.spin_rad)
            @ _FLIP
        )
        return turned

    def lean_deg(self, points_mm: ArrayLike) -> float:
        """The farthest that the pen leans from upright at any of some points."""
        upright = -self.orientations(points_mm)[..., 2, 2]
        return float(np.degrees(np.arccos(np.clip(upright, -1, 1)).max()))

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
        """Poses (..., 4, 4) of the pen's tip in the base frame at points (..., 2) or (..., 3) of the paper [mm].

        A tip above or below the paper is so along the pen: lowered, it touches at the point's x and y.
        """
        points = np.asarray(points_mm, dtype=np.float64)
        turns = self.orientations(points)
        if points.shape[-1] == 3:
            pen = turns[..., 2]
            points = np.concatenate([points[..., :2], 0 * points[..., 2:]], -1) + pen * points[..., 2:] / pen[..., 2:]
        return transforms.transform(self.base_from_paper[:3, :3] @ turns, self.points_m(points))


def leant(lean_rad: ArrayLike, towards_rad: ArrayLike) -> Floats:
    """Rotations (..., 3, 3) that let the upper end of an upright pen lean by angles (...) in directions (...)."""
    towards = np.asarray(towards_rad, dtype=np.float64)
    about = np.stack([-np.sin(towards), np.cos(towards), np.zeros(towards.shape)], axis=-1)
    return transforms.rotation(about, lean_rad)


def _direction(vectors: Floats) -> Floats:
    angle: Floats = np.arctan2(vectors[..., 1], vectors[..., 0])
    return angle


def plane_of(tips: Floats) -> tuple[Floats, Floats]:
    """The plane that the tip of a drawing pen is led in.

    Args:
        tips: (n, 4, 4) its poses in the base frame.

    Returns:
        Axes (3, 3): along the sheet as the base's x is seen there, across, and the normal, against the pen;
        a point of it (3,) [m].

    Raises:
        BadInput: the poses lie in no plane.
    """
    points = tips[:, :3, 3]
    middle = points.mean(0)
    _, spread, axes = np.linalg.svd(points - middle, full_matrices=False)
    spread = 1000 * spread / np.sqrt(len(points))
    pen = tips[:, :3, 2].mean(0)
    if len(spread) < 3 or spread[1] < _SPREAD_MM:
        normal = -pen / np.linalg.norm(pen)
    else:
        normal = -axes[2] * np.sign(axes[2] @ pen)
    off = 1000 * float(np.abs((points - middle) @ normal).max())
    if off > _FLAT_MM:
        raise BadInput(
            f"trajectory: its pen-down places lie up to {off:.1f} mm off their plane, expected at most {_FLAT_MM:g};"
            " it does not draw on a flat sheet"
        )
    along = np.eye(3)[0] if abs(normal[0]) < 0.9 else np.eye(3)[1]
    x = along - (along @ normal) * normal
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(normal, x), normal], axis=1), middle


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


def thesis_sheet(drawing: Drawing, height_m: float) -> tuple[Drawing, Placement]:
    """The thesis's way of placing a picture: its corners go to those of the drawing area, which turns and scales it.

    Args:
        drawing: the picture is its page.
        height_m: of the table in ``arm_base_link``, which the thesis does not tell.

    Returns:
        The drawing at the size that it is drawn in, and where its page then lies.
    """
    page = drawing.page
    mapping = PlaneMapping.between(THESIS_AREA_M, ((0, 0), (page.width_mm, page.height_mm)))
    scale = 1000 / float(np.hypot(mapping.a, mapping.b))
    corner, right = mapping.to_table(((0, page.height_mm), (page.width_mm, page.height_mm)))
    turn = float(np.arctan2(*(right - corner)[::-1]))
    base_from_paper = transforms.transform(transforms.rotation((0.0, 0.0, 1.0), turn), (*corner, height_m))
    scaled = dataclasses.replace(
        drawing,
        lines_mm=tuple(scale * line for line in drawing.lines_mm),
        page=Page(scale * page.width_mm, scale * page.height_mm, scale * page.margin_mm),
    )
    return scaled, Placement(base_from_paper)


THESIS_AREA_M = ((-0.5221, 0.476), (-0.113, 0.264))
"""Upper left and lower right corner of the thesis's drawing area in ``arm_base_link`` (section 4.3)."""
