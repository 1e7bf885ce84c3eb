"""A model in, the one vector of all its weights (thesis eq. 3.4) out, and back; faces in that frame as features."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from limner.types import Floats
from limner.vision.landmarks.fmp.hog import CHANNELS
from limner.vision.landmarks.fmp.model import Component, FmpModel
from limner.vision.landmarks.fmp.pyramid import FILTER
from limner.vision.landmarks.fmp.solver import Penalty

SIZE = FILTER * FILTER * CHANNELS
"""Numbers in a filter."""

LEAST_SPRING = 0.01
"""Least ax and ay, so that a part never leaves its parent for nothing; also where they cost nothing."""

PENALTIES = {"filter": 1.0, "spring": 0.1, "bias": 0.01}
"""How much the weights of each kind cost (Zhu & Ramanan's release)."""


@dataclass(frozen=True, eq=False)
class Layout:
    """Where each weight of a model stands in the vector.

    Mixture after mixture: the filters that no earlier one uses, then the springs of all parts but the root, the bias.

    Attributes:
        columns: for each mixture its weights: filters in the order of its parts, springs, bias.
        length: of the vector.
    """

    columns: tuple[NDArray[np.int64], ...]
    length: int

    @classmethod
    def of(cls, components: tuple[Component, ...]) -> Layout:
        """The layout of these mixtures."""
        starts: dict[int, int] = {}
        columns, end = [], 0
        for component in components:
            for pooled in component.filters.tolist():
                if pooled not in starts:
                    starts[pooled] = end
                    end += SIZE
            own = np.arange(end, end + 4 * (len(component.parents) - 1) + 1)
            end += len(own)
            filters = [np.arange(starts[pooled], starts[pooled] + SIZE) for pooled in component.filters.tolist()]
            columns.append(np.concatenate([*filters, own]))
        return cls(tuple(columns), end)

    def pack(self, model: FmpModel) -> Floats:
        """The weights of a model: (length,)."""
        weights = np.zeros(self.length)
        for columns, component in zip(self.columns, model.components, strict=True):
            filters = model.filters[component.filters].ravel()
            weights[columns] = np.concatenate([filters, component.springs[1:].ravel(), [component.bias]])
        return weights

    def unpack(self, weights: Floats, model: FmpModel) -> FmpModel:
        """``model`` with other weights."""
        filters = np.array(model.filters, np.float64)
        components = []
        for columns, component in zip(self.columns, model.components, strict=True):
            own = weights[columns]
            n = len(component.parents)
            filters[component.filters] = own[: n * SIZE].reshape(n, FILTER, FILTER, CHANNELS)
            springs = np.vstack([np.zeros(4), own[n * SIZE : -1].reshape(n - 1, 4)])
            components.append(dataclasses.replace(component, springs=springs, bias=float(own[-1])))
        return dataclasses.replace(model, filters=filters.astype(np.float32), components=tuple(components))

    def penalty(self, prior: Floats | None = None) -> Penalty:
        """What the weights cost; without a prior, springs are drawn to ``LEAST_SPRING`` and all else to 0."""
        scale, start, lower = np.ones(self.length), np.zeros(self.length), np.full(self.length, -np.inf)
        for columns in self.columns:
            springs = columns[len(columns) - 1 - 4 * self._edges(columns) : -1]
            squares = np.concatenate([springs[0::4], springs[2::4]])
            scale[springs], scale[columns[-1]] = PENALTIES["spring"], PENALTIES["bias"]
            start[squares] = lower[squares] = LEAST_SPRING
        return Penalty(scale, start if prior is None else np.maximum(prior, lower), lower)

    @staticmethod
    def _edges(columns: NDArray[np.int64]) -> int:
        """Parts below the root of a mixture with so many weights: n SIZE + 4 (n - 1) + 1 of them."""
        return (len(columns) + 3) // (SIZE + 4) - 1


def features(component: Component, level: NDArray[np.float32], cells: NDArray[np.int64]) -> NDArray[np.float32]:
    """What the weights of a mixture meet when its parts lie at ``cells``.

    Args:
        component: the mixture.
        level: (rows, cols, 32) padded HOG map.
        cells: (n, 2) x, y of each part's filter.

    Returns:
        (n SIZE + 4 (n - 1) + 1,): the parts' patches, the negative springs' terms, 1.
    """
    patches = [level[y : y + FILTER, x : x + FILTER].ravel() for x, y in cells.tolist()]
    stretch = (cells[component.parents[1:]] + component.anchors[1:] - cells[1:]).astype(np.float32)
    terms = -np.stack([stretch[:, 0] ** 2, stretch[:, 0], stretch[:, 1] ** 2, stretch[:, 1]], axis=1)
    return np.concatenate([*patches, terms.ravel(), np.ones(1, np.float32)])
