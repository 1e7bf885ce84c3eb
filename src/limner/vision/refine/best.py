"""Photo and face in; the face with the best landmarks we know how to find, or the same face where unsure, out."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from importlib import resources

import numpy as np

from limner.settings import SettingsGroup, setting
from limner.storage import read_bytes
from limner.types import Face, Floats, Photo
from limner.vision.landmarks.mirror import MIRROR
from limner.vision.refine.descent import Descent, Pictures, unpacked
from limner.vision.refine.ground import Grey, grey_face, put_back

_ZOOMS, _SHIFTS = (1.06, 0.94), (0.03, -0.03)
"""Where the two passes begin: larger and lower, smaller and higher than the landmarks [outer-eye distances]."""

_ALL = np.arange(68)


@dataclass(frozen=True)
class BestSettings(SettingsGroup):
    """When the result is believed; lengths in outer-eye distances."""

    spread: float = setting(
        0.045,
        "two passes that end farther apart on average than this are not believed",
        unit="outer-eye distances",
        low=0,
        high=1,
    )
    move: float = setting(
        0.2, "nor a result this far from the input on average", unit="outer-eye distances", low=0, high=2
    )
    model: str = setting("", "file of the model (.npz of `limner train best`); empty for the one that is shipped")


@dataclass(frozen=True)
class Verdict:
    """What came of a face.

    Attributes:
        face: the refined face; the input where it is not trusted.
        spread: how far apart two passes from different starts ended, in outer-eye distances.
        move: how far they moved the landmarks on average, in outer-eye distances.
        trusted: whether both are small enough.
    """

    face: Face
    spread: float
    move: float
    trusted: bool


def best(photo: Photo, face: Face, settings: BestSettings) -> Face:
    """Refine all landmarks together by a learnt cascade; the same face comes back where the result is not believed.

    Raises:
        BadInput: a profile, a face of a few pixels, or one that lies outside the photo; or no usable model.
    """
    return judge(photo, face, settings).face


def judge(photo: Photo, face: Face, settings: BestSettings) -> Verdict:
    """As ``best``, with what it was decided by.

    Two passes, one of them in the mirror, start on both sides of the landmarks. Where there is a face they end
    in one place, and their mean is better than either.

    Raises:
        BadInput: as ``best``.
    """
    model = load_best(settings.model) if settings.model else shipped_best()
    grey = grey_face(photo, face)
    one, other = passes(grey, model)
    points = (one + other) / 2
    unit = max(float(np.hypot(*(points[45] - points[36]))), 1e-6)
    spread = float(np.hypot(*(one - other).T).mean()) / unit
    move = float(np.hypot(*(points - grey.points).T).mean()) / unit
    if not (spread <= settings.spread and move <= settings.move):
        return Verdict(face, spread, move, False)
    return Verdict(put_back(photo, face, grey, _ALL, points), spread, move, True)


def passes(grey: Grey, model: Descent) -> tuple[Floats, Floats]:
    """Where two passes from different starts end, (68, 2) each, in the grey picture."""
    one = model.run(Pictures(grey.image), _start(grey, 0))
    flipped = Pictures(np.ascontiguousarray(grey.image[:, ::-1]))
    other = model.run(flipped, _mirrored(_start(grey, 1), grey))
    return one, _mirrored(other, grey)


def _start(grey: Grey, number: int) -> Floats:
    centre = grey.points.mean(axis=0)
    unit = float(np.hypot(*(grey.points[45] - grey.points[36])))
    start: Floats = centre + (grey.points - centre) * _ZOOMS[number] + grey.down * _SHIFTS[number] * unit
    return start


def _mirrored(points: Floats, grey: Grey) -> Floats:
    flipped: Floats = (np.array([grey.image.shape[1] - 1, 0]) + np.array([-1, 1]) * points)[MIRROR]
    return flipped


@cache
def load_best(path: str) -> Descent:
    """Read a model.

    Raises:
        BadInput: no such file, or no model of `limner train best`.
    """
    return unpacked(read_bytes(path), path)


@cache
def shipped_best() -> Descent:
    """The model that limner ships."""
    return unpacked((resources.files(__package__) / "best.npz").read_bytes(), "the shipped model of 'best'")
