"""Points probed on a table go in; the plane of the paper, its tilt and what did not fit come out (thesis chapter 5)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from limner import transforms
from limner.errors import BadInput
from limner.types import Floats, Value, frozen_array

MOST_POINTS = 1000

FARTHEST_M = 100.0
"""From the base of any arm."""


@dataclass(frozen=True, eq=False)
class Calibration(Value):
    """A sheet's place, found by probing.

    Attributes:
        base_from_paper: (4, 4) origin and axes of the sheet in the base frame [m].
        used: (n,) which points lie on the plane; the others were left out.
        residual_mm: (n,) distance of each point from the plane.
        tilt_deg: of the plane against the base frame's horizontal.
    """

    base_from_paper: Floats
    used: NDArray[np.bool_]
    residual_mm: Floats
    tilt_deg: float

    def __post_init__(self) -> None:
        self._freeze("base_from_paper", frozen_array(self.base_from_paper, np.float64, (4, 4), "base_from_paper"))
        self._freeze("used", frozen_array(self.used, np.bool_, (None,), "used"))
        self._freeze("residual_mm", frozen_array(self.residual_mm, np.float64, (None,), "residual_mm"))

    @property
    def rms_mm(self) -> float:
        """Root mean square distance of the points used."""
        return float(np.sqrt((self.residual_mm[self.used] ** 2).mean()))


def calibrate(points_m: ArrayLike, outlier_mm: float = 2.0) -> Calibration:
    """The sheet through probed points.

    The first point is its lower left corner, the second one lies on its lower edge (or as near as it could be
    probed), all lie on its plane: least squares over the largest set of points that agree on one plane to
    ``outlier_mm`` (every plane through three points is tried; Fischler & Bolles 1981, doi:10.1145/358669.358692).

    Args:
        points_m: (n, 3) at least three in the base frame.
        outlier_mm: points farther than this from the plane are left out.

    Raises:
        BadInput: fewer than three points, all nearly on a line, not finite, or the first two do not fit the plane.
    """
    points = frozen_array(points_m, np.float64, (None, 3), "calibration points")
    if len(points) < 3:
        raise BadInput(f"calibration: {len(points)} points, expected at least 3 that are not on a line")
    if len(points) > MOST_POINTS or np.abs(points).max() > FARTHEST_M:
        raise BadInput(
            f"calibration: expected up to {MOST_POINTS} points, none farther than {FARTHEST_M:g} m; they are in metres"
        )
    used = _agreeing(points, outlier_mm / 1000)
    if not used[:2].all():
        wrong = "first" if not used[0] else "second"
        raise BadInput(
            f"calibration: the {wrong} point is more than {outlier_mm:g} mm off the plane of the others; probe it again"
        )
    centre, normal = _plane(points[used])
    residual = 1000 * (points - centre) @ normal
    return Calibration(_frame(points, centre, normal), used, residual, _tilt_deg(normal))


def _agreeing(points: Floats, limit_m: float) -> NDArray[np.bool_]:
    """Most points that lie within a distance of one plane through three of them."""
    i, j, k = _triples(len(points))
    normals = np.cross(points[j] - points[i], points[k] - points[i])
    size = np.linalg.norm(normals, axis=1)
    span = float(np.linalg.norm(np.ptp(points, axis=0)))
    wide = size > 1e-3 * max(span, 1e-9) ** 2
    if not wide.any():
        raise BadInput("calibration: all points lie nearly on a line or at one place; probe one well beside them")
    normals, anchors = normals[wide] / size[wide, None], points[i[wide]]
    distance = np.abs(np.einsum("tc,ntc->tn", normals, points[:, None] - anchors))
    near = distance <= limit_m
    best = np.lexsort((np.where(near, distance, 0).sum(1), -near.sum(1)))[0]
    agreeing: NDArray[np.bool_] = near[best]
    return agreeing


def _triples(n: int, at_most: int = 3000) -> tuple[NDArray[np.int64], ...]:
    i, j, k = (a.ravel() for a in np.meshgrid(*[np.arange(min(n, 60))] * 3, indexing="ij"))
    ordered = (i < j) & (j < k)
    i, j, k = i[ordered], j[ordered], k[ordered]
    step = max(1, len(i) // at_most)
    return i[::step], j[::step], k[::step]


def _plane(points: Floats) -> tuple[Floats, Floats]:
    """Centre and upward unit normal of the least-squares plane."""
    centre = points.mean(0)
    normal = np.linalg.svd(points - centre)[2][-1]
    return centre, normal if normal[2] >= 0 else -normal


def _frame(points: Floats, centre: Floats, normal: Floats) -> Floats:
    """The sheet's frame: origin and x axis from the first two points, laid onto the plane."""
    origin, along = (point - ((point - centre) @ normal) * normal for point in points[:2])
    x = along - origin
    if np.linalg.norm(x) < 1e-3:
        raise BadInput("calibration: the first two points are one place; expected two corners of the lower edge")
    x = x / np.linalg.norm(x)
    return transforms.transform(np.stack([x, np.cross(normal, x), normal], axis=1), origin)


def _tilt_deg(normal: Floats) -> float:
    return float(np.degrees(np.arctan2(np.hypot(normal[0], normal[1]), normal[2])))
