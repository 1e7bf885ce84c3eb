"""Faces of many people in; how well models of ever more of them place the landmarks of people kept aside, out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from limner.types import Floats
from limner.vision.landmarks.fmp import initial
from limner.vision.landmarks.fmp.hog import CHANNELS
from limner.vision.landmarks.fmp.matching import Forest
from limner.vision.landmarks.fmp.model import Component
from limner.vision.landmarks.fmp.positives import Positive
from limner.vision.landmarks.fmp.pyramid import FILTER
from limner.vision.landmarks.fmp.response import responses

SHARES = (0.05, 0.1, 0.2, 0.4, 0.8)
"""Of the people a model is made of; the rest are kept aside."""

_ASIDE = 0.2
_MOST_FACES = 60
"""Faces that are measured, of those learned from and of those kept aside."""


@dataclass(frozen=True)
class Learned:
    """How well a model from statistics alone places landmarks.

    Attributes:
        people, faces: that it was made of.
        seen_percent: mean error on some of them, in per cent of the outer-eye distance, landmarks on whole cells.
        unseen_percent: the same on people kept aside.
    """

    people: int
    faces: int
    seen_percent: float
    unseen_percent: float

    def to_dict(self) -> dict[str, Any]:
        """Plain values."""
        return asdict(self)


def learning_curve(
    faces: Sequence[Positive], stiffness: float, background: initial.Background, rng: np.random.Generator
) -> tuple[Learned, ...]:
    """The faces of the first pose: a fifth of the people aside, models of ever more of the others.

    Args:
        faces: of at least two people; empty curve for fewer.
        stiffness: of the springs, as in training.
        background: what is no face.
        rng: chooses the people.
    """
    faces = [face for face in faces if face.pose == 0]
    people = rng.permutation(sorted({face.person for face in faces})).tolist()
    aside = set(people[: max(1, round(_ASIDE * len(people)))])
    others = [person for person in people if person not in aside]
    unseen = [face for face in faces if face.person in aside][:_MOST_FACES]
    curve = []
    for count in sorted({max(1, round(share * len(people))) for share in SHARES if others}):
        chosen = set(others[:count])
        seen = [face for face in faces if face.person in chosen]
        filters, component = initial.mixture(seen, 0, 0.0, stiffness, background)
        errors = [_error_percent(some, filters, component) for some in (seen[:_MOST_FACES], unseen)]
        curve.append(Learned(len(chosen), len(seen), *errors))
    return tuple(curve)


def _error_percent(faces: Sequence[Positive], filters: Floats, component: Component) -> float:
    """Mean error where the best configuration of each face's map lies."""
    pool = filters.reshape(-1, FILTER, FILTER, CHANNELS).astype(np.float32)
    errors = []
    for face in faces:
        match = Forest((component,)).match(responses(face.features, pool))
        y, x = np.unravel_index(int(match.roots[0].argmax()), match.roots[0].shape)
        off = match.places(0, np.array([[x, y]]))[0] - face.cells[component.landmarks]
        errors.append(np.hypot(*off.T).mean() / np.hypot(*(face.cells[45] - face.cells[36])))
    return 100 * float(np.mean(errors))
