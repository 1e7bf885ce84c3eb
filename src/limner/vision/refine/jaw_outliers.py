"""Photo and face in; the face without the landmarks that break the jaw's smoothness, out (thesis 3.3.3)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from limner.settings import SettingsGroup, setting
from limner.types import Face, Floats, Photo
from limner.vision.raster import Image
from limner.vision.refine.ground import UNIT_PX, gradient, grey_face, put_back, read
from limner.vision.splines import Spline, natural_spline

JAW = np.arange(17)
_STEP_PX = 1.0


@dataclass(frozen=True)
class JawOutliersSettings(SettingsGroup):
    """Which landmarks of the jaw are outliers; lengths in outer-eye distances."""

    score: str = setting(
        "distance",
        "distance = off the splines through the others; path = off the spline along which the picture changes most",
        choices=("distance", "path"),
    )
    threshold: float = setting(
        0.05, "a landmark farther than this from the spline is moved onto it", unit="outer-eye distances", low=0, high=1
    )
    removed: int = setting(4, "landmarks taken out at a time", low=1, high=12)
    trials: int = setting(60, "how often some are taken out, at random", low=1, high=1000)
    blur: float = setting(0.01, "blur before the slope is taken (path)", unit="outer-eye distances", low=0, high=0.2)
    seed: int = setting(0, "start of the random numbers", low=0)


def jaw_outliers(photo: Photo, face: Face, settings: JawOutliersSettings) -> Face:
    """Take landmarks out at random, lay a spline through the rest, and put what is far from it onto it.

    With ``path`` the one spline is believed along which the gradient magnitudes sum up to the most.

    Raises:
        BadInput: a profile, a face of a few pixels, or one that lies outside the photo.
    """
    grey = grey_face(photo, face)
    jaw = grey.points[:17]
    if settings.score == "path":
        magnitude = np.hypot(*gradient(grey.image, settings.blur * UNIT_PX)).astype(np.float32)
        moved = _onto(jaw, _best_path(jaw, magnitude, settings), settings)
    else:
        moved = _without_outliers(jaw, settings)
    return put_back(photo, face, grey, JAW, moved)


def _kept(settings: JawOutliersSettings) -> Iterator[NDArray[np.intp]]:
    """For each trial the landmarks that are left, in order; the ends are never taken out."""
    random = np.random.default_rng(settings.seed)
    for _ in range(settings.trials):
        out = 1 + random.choice(15, settings.removed, replace=False)
        yield np.setdiff1d(JAW, out)


def _spline(jaw: Floats, kept: NDArray[np.intp]) -> Spline:
    return natural_spline(jaw[kept], kept.astype(np.float64))


def _without_outliers(jaw: Floats, settings: JawOutliersSettings) -> Floats:
    """Move the worst onto the spline through the others, then look again: one outlier makes its neighbours look bad."""
    jaw = jaw.copy()
    for _ in JAW:
        far = _distances(jaw, settings)
        worst = int(far.argmax())
        if far[worst] <= settings.threshold * UNIT_PX:
            break
        jaw[worst] = _spline(jaw, np.setdiff1d(JAW, worst)).nearest(jaw[worst : worst + 1])[0]
    return jaw


def _distances(jaw: Floats, settings: JawOutliersSettings) -> Floats:
    """The median distance (17,) of each landmark to the splines that it is not part of."""
    far = np.full((settings.trials, 17), np.nan)
    for trial, kept in enumerate(_kept(settings)):
        out = np.setdiff1d(JAW, kept)
        far[trial, out] = np.hypot(*(_spline(jaw, kept).nearest(jaw[out]) - jaw[out]).T)
    ever = ~np.isnan(far).all(axis=0)
    median = np.zeros(17)
    median[ever] = np.nanmedian(far[:, ever], axis=0)
    return median


def _best_path(jaw: Floats, magnitude: Image, settings: JawOutliersSettings) -> Spline:
    splines = [_spline(jaw, JAW), *(_spline(jaw, kept) for kept in _kept(settings))]
    # The mean, since the sum would favour the longest way.
    scores = [round(float(read(magnitude, spline.line(_STEP_PX)).mean()), 6) for spline in splines]
    return splines[int(np.argmax(scores))]


def _onto(jaw: Floats, spline: Spline, settings: JawOutliersSettings) -> Floats:
    nearest = spline.nearest(jaw)
    far = np.hypot(*(nearest - jaw).T) > settings.threshold * UNIT_PX
    return np.where(far[:, None], nearest, jaw)
