"""A face goes in; smooth curves through its landmarks come out as strokes, without a look at the photo (thesis 3.4)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from limner import geometry
from limner.settings import SettingsGroup, setting
from limner.types import Face, Floats, Photo, Strokes
from limner.vision.head import BROWS, JAW, NOSTRILS
from limner.vision.regions import RegionSettings
from limner.vision.splines import natural_spline

BRIDGE = [27, 28, 29, 30]

LIDS = (([36, 37, 38, 39], [39, 40, 41, 36]), ([42, 43, 44, 45], [45, 46, 47, 42]))
OUTER_LIPS = ([*range(48, 55)], [*range(54, 60), 48])
INNER_LIPS = ([*range(60, 65)], [*range(64, 68), 60])
"""Closed features as two splines each, which meet in the corners: one through all would round the corners off."""

FEATURES: tuple[tuple[str, tuple[list[int], ...]], ...] = (
    *(("eye", lid) for lid in LIDS),
    *(("brow", (brow,)) for brow in BROWS),
    ("mouth", OUTER_LIPS),
    ("mouth", INNER_LIPS),
    ("nose", (BRIDGE,)),
    ("nose", (NOSTRILS,)),
    ("jaw", (JAW,)),
)
"""Region, and the landmarks of each spline that together make one stroke."""


@dataclass(frozen=True)
class SplinesSettings(SettingsGroup):
    """Curves through the landmarks."""

    step: float = setting(
        0.02, "vertices of a curve are no farther apart than this", unit="outer-eye distances", low=0.001, high=1
    )
    tolerance: float = setting(
        0.002, "vertices that bend the curve less than this go", unit="outer-eye distances", low=0, high=0.5
    )


def spline_strokes(photo: Photo, face: Face, settings: SplinesSettings, regions: RegionSettings) -> Strokes:
    """Natural cubic splines through the landmarks of each feature, the heaviest stroke first.

    Args:
        photo: only its size counts.
        face: a frontal one.
        settings: how fine the curves are.
        regions: how much a line of each region matters.

    Raises:
        BadInput: a profile, or both outer eye corners are one point.
    """
    unit = face.outer_eye_px
    lines = [(region, _curve(face.points_px, parts, unit, settings)) for region, parts in FEATURES]
    weights = np.array([geometry.length(line) / unit * getattr(regions, region) for region, line in lines])
    order = np.argsort(-weights, kind="stable")
    return Strokes(tuple(lines[i][1] for i in order), tuple(lines[i][0] for i in order), weights[order], photo.size_px)


def _curve(points: Floats, parts: tuple[list[int], ...], unit: float, settings: SplinesSettings) -> Floats:
    pieces = [natural_spline(points[part]).line(settings.step * unit) for part in parts]
    line = np.concatenate([pieces[0], *(piece[1:] for piece in pieces[1:])])
    return geometry.simplify(line, settings.tolerance * unit)
