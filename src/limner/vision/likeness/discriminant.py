"""Descriptors of people in go in; the directions in which people differ, but one person's pictures do not, come out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from limner.errors import BadInput
from limner.types import Value, frozen_array

Descriptors = NDArray[np.float32]

COMPONENTS = 150
"""Principal components that are looked at; fewer than half as many as pictures, so that noise does not rule."""

SHRINK = 0.1
"""Share of the within-person scatter that is taken as alike in all directions: people are few."""


@dataclass(frozen=True, eq=False)
class Discriminant(Value):
    """Linear discriminants of people (Fisher 1936; for faces Belhumeur et al. 1997, doi:10.1109/34.598228).

    Attributes:
        photo_mean: (n,) the mean photo.
        drawing_mean: (n,) the mean drawing.
        directions: (n, k) what tells people apart, scaled so that pictures of one person scatter alike in each.
    """

    photo_mean: Descriptors
    drawing_mean: Descriptors
    directions: Descriptors

    def __post_init__(self) -> None:
        self._freeze("directions", frozen_array(self.directions, np.float32, (None, None), "discriminant: directions"))
        length = len(self.directions)
        for name in ("photo_mean", "drawing_mean"):
            mean = frozen_array(getattr(self, name), np.float32, (length,), f"discriminant: {name}")
            self._freeze(name, mean)

    def of_photos(self, descriptors: Descriptors) -> Descriptors:
        """Photos (..., n) as unit vectors (..., k), whose products are likenesses."""
        return _unit((descriptors - self.photo_mean) @ self.directions)

    def of_drawings(self, descriptors: Descriptors) -> Descriptors:
        """Drawings (..., n) as unit vectors (..., k)."""
        return _unit((descriptors - self.drawing_mean) @ self.directions)


def train_discriminant(
    photos: Sequence[Descriptors], drawings: Sequence[Descriptors], directions: int = 60
) -> Discriminant:
    """Learn from several photos and drawings of each of some people.

    Args:
        photos: sets (people, n); row i is person i in each.
        drawings: sets likewise; may be none.
        directions: how many to keep.

    Raises:
        BadInput: fewer than three people, or one set.
    """
    sets = [*photos, *drawings]
    people = len(sets[0]) if sets else 0
    if people < 3 or len(sets) < 2 or not photos:
        raise BadInput(f"likeness: {people} people in {len(sets)} sets; expected three or more, in two pictures each")
    photo_mean = np.concatenate(photos).mean(axis=0)
    drawing_mean = np.concatenate(drawings).mean(axis=0) if drawings else photo_mean
    centred = [rows - photo_mean for rows in photos] + [rows - drawing_mean for rows in drawings]
    basis = _principal(np.concatenate(centred))
    rows = np.stack(centred) @ basis  # sets, people, components
    person = rows.mean(axis=0)
    apart = (rows - person).reshape(-1, rows.shape[-1])
    within = apart.T @ apart / len(apart)
    within = (1 - SHRINK) * within + SHRINK * np.trace(within) / len(within) * np.eye(len(within))
    spread, axes = np.linalg.eigh(within)
    white = axes / np.sqrt(spread)
    _, order = np.linalg.eigh(white.T @ (person.T @ person / people) @ white)
    chosen = basis @ white @ order[:, ::-1][:, :directions]
    return Discriminant(photo_mean, drawing_mean, chosen)


def _principal(rows: Descriptors) -> NDArray[np.float64]:
    """Unit columns (n, k) along which rows differ most, by way of their products: they are fewer than their length."""
    products = (rows @ rows.T).astype(np.float64)
    squared, axes = np.linalg.eigh(products)
    real = squared > 1e-6 * squared[-1]
    count = min(COMPONENTS, int(real.sum()))
    columns: NDArray[np.float64] = rows.T.astype(np.float64) @ (axes[:, -count:] / np.sqrt(squared[-count:]))
    return columns


def _unit(vectors: NDArray[Any]) -> Descriptors:
    return np.asarray(vectors / (np.linalg.norm(vectors, axis=-1, keepdims=True) + 1e-9), np.float32)
