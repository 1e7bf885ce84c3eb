"""Photo and face in; the face with its jaw moved onto a smooth curve, out (thesis 3.3.5)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from limner.settings import SettingsGroup, setting
from limner.types import Face, Floats, Photo
from limner.vision.refine.ground import with_points
from limner.vision.splines import smoothing_spline


@dataclass(frozen=True)
class JawSplineSettings(SettingsGroup):
    """How smooth the jaw becomes."""

    spacing: float = setting(
        1.0,
        "h in p = 1 / (1 + h^3 / 6): 1 is the distance of neighbouring landmarks; more is smoother",
        low=0,
        high=100,
    )

    @property
    def p(self) -> float:
        """Weight of the landmarks against the bending, 0 to 1."""
        return 1 / (1 + self.spacing**3 / 6)


def jaw_spline(photo: Photo, face: Face, settings: JawSplineSettings) -> Face:
    """Move the jaw's 17 landmarks to the nearest points of the regularised spline through them."""
    points = face.points_px.copy()
    points[:17] = smoothed(points[:17], settings)
    return with_points(photo, face, points)


def smoothed(line: Floats, settings: JawSplineSettings) -> Floats:
    """The nearest points (n, 2) on the regularised spline to points (n, 2) in order along a feature."""
    return np.asarray(smoothing_spline(line, settings.p).nearest(line), np.float64)
