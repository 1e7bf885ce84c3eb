"""A photo, a face and the names of corrections go in; the face with better landmarks comes out (thesis 3.3)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from limner.settings import SettingsGroup, group, names_in
from limner.types import Face, Photo
from limner.vision.refine.best import BestSettings, best
from limner.vision.refine.brows import BrowsSettings, brows
from limner.vision.refine.eye_corners import EyeCornersSettings, eye_corners
from limner.vision.refine.jaw_gradient import JawGradientSettings, jaw_gradient
from limner.vision.refine.jaw_outliers import JawOutliersSettings, jaw_outliers
from limner.vision.refine.jaw_spline import JawSplineSettings, jaw_spline
from limner.vision.refine.shape import ShapeSettings, shape


@dataclass(frozen=True)
class RefineSettings(SettingsGroup):
    """The settings of every correction; each group bears its name, with _ for -."""

    best: BestSettings = group(BestSettings)
    jaw_gradient: JawGradientSettings = group(JawGradientSettings)
    brows: BrowsSettings = group(BrowsSettings)
    jaw_outliers: JawOutliersSettings = group(JawOutliersSettings)
    eye_corners: EyeCornersSettings = group(EyeCornersSettings)
    jaw_spline: JawSplineSettings = group(JawSplineSettings)
    shape: ShapeSettings = group(ShapeSettings)


REFINEMENTS: dict[str, Callable[[Photo, Face, Any], Face]] = {
    "best": best,
    "jaw-gradient": jaw_gradient,
    "brows": brows,
    "jaw-outliers": jaw_outliers,
    "eye-corners": eye_corners,
    "jaw-spline": jaw_spline,
    "shape": shape,
}
"""Each takes a photo, a frontal face in it, and its own settings, and gives the face with moved landmarks."""

BEST = "best"


def names_of(text: str) -> tuple[str, ...]:
    """The corrections that a text names, separated by commas; none for ``none`` or nothing.

    Raises:
        BadInput: a name that does not exist.
    """
    return names_in(text, REFINEMENTS, "refine")


def refine(photo: Photo, face: Face, names: str, settings: RefineSettings) -> Face:
    """Correct a face's landmarks, one correction after the other.

    Args:
        photo: where the face is.
        face: to be corrected; a profile, for which there is no correction, comes back as it is.
        names: of corrections, separated by commas, in their order; ``none`` for none.
        settings: of every correction.

    Raises:
        BadInput: no such correction, a face of a few pixels, or one outside the photo.
    """
    return refine_in_steps(photo, face, names, settings)[-1].face


@dataclass(frozen=True)
class Step:
    """The face after a correction.

    Attributes:
        name: of the correction; empty for the face before the first.
        face: after it; the very face from before where nothing moved (``best`` does so when it is unsure).
        move: how far the landmarks went on average, in outer-eye distances.
    """

    name: str
    face: Face
    move: float = 0.0


def refine_in_steps(photo: Photo, face: Face, names: str, settings: RefineSettings) -> tuple[Step, ...]:
    """As ``refine``, with the face before and after every correction.

    Raises:
        BadInput: as ``refine``.
    """
    steps = [Step("", face)]
    for name in names_of(names):
        if face.frontal:
            after = REFINEMENTS[name](photo, face, getattr(settings, name.replace("-", "_")))
            move = float(np.hypot(*(after.points_px - face.points_px).T).mean()) / face.outer_eye_px
            steps.append(Step(name, after, move))
            face = after
    return tuple(steps)


__all__ = ["BEST", "REFINEMENTS", "RefineSettings", "Step", "names_of", "refine", "refine_in_steps"]
