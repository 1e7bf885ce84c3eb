"""Score maps of every part of one or more trees go in, the best place of every part for each root cell comes out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from limner.vision.landmarks.fmp.hog import Array
from limner.vision.landmarks.fmp.model import Component
from limner.vision.landmarks.fmp.transform import spread

_BATCH_CELLS = 40_000
"""Cells worked on at once: small maps together, large ones one by one, so that they stay in the cache."""


class Forest:
    """The trees of some components, ready for matching; parts are numbered through, component after component.

    Along each axis the cost of a displacement d, ``a d^2 + b d``, is that of ``e = d + t``, ``a e^2 + beta e + gamma``,
    with t whole and ``|beta| <= a``. The part in beta is linear in the two cells' coordinates and goes to the parts'
    own scores once and for all, so that the distance transform has only ``a e^2`` and a shift.

    Attributes:
        components: the trees.
        filters: (N,) of all parts.
        roots: (components,) number of each root.
    """

    def __init__(self, components: Sequence[Component]) -> None:
        self.components = tuple(components)
        sizes = [len(component.parents) for component in components]
        self.roots = np.cumsum([0, *sizes[:-1]])
        self.filters = np.concatenate([component.filters for component in components])
        self._parents = np.concatenate(
            [np.where(c.parents < 0, -1, c.parents + root) for c, root in zip(components, self.roots, strict=True)]
        )
        springs = np.concatenate([component.springs for component in components])
        anchors = np.concatenate([component.anchors for component in components])
        springs[self.roots] = (1, 0, 1, 0)
        self._a, b = springs[:, ::2], springs[:, 1::2]
        t = np.rint(b / (2 * self._a)).astype(np.int64)
        self._shift = anchors + t
        beta, gamma = b - 2 * self._a * t, (self._a * t * t - b * t).sum(1)
        self._slope, self._offset = beta.copy(), np.zeros(len(beta))
        self._offset[self.roots] = [component.bias for component in components]
        children = np.flatnonzero(self._parents >= 0)
        np.subtract.at(self._slope, self._parents[children], beta[children])
        lost = gamma + (beta * self._shift).sum(1)
        np.subtract.at(self._offset, self._parents[children], lost[children])
        self._depths = self._by_depth()

    def _by_depth(self) -> list[Array]:
        depth = np.zeros(len(self._parents), np.int64)
        for part, parent in enumerate(self._parents):
            depth[part] = depth[parent] + 1 if parent >= 0 else 0
        return [np.flatnonzero(depth == d) for d in range(1, depth.max() + 1)]

    def match(self, scores: Array) -> Match:
        """Pass the messages from the leaves to the roots (thesis 3.2.1, Inference).

        Args:
            scores: (N, R, C) appearance score of every part at every cell; overwritten. May hold -inf.
        """
        rows, cols = scores.shape[1:]
        y, x = np.arange(rows, dtype=scores.dtype), np.arange(cols, dtype=scores.dtype)
        slope = self._slope.astype(scores.dtype)
        scores += (slope[:, 1:] * y + self._offset.astype(scores.dtype)[:, None])[:, :, None]
        scores += (slope[:, :1] * x)[:, None, :]
        reach = np.zeros((len(scores), 2), np.int64)
        batch = max(1, _BATCH_CELLS // max(1, rows * cols))
        for parts in reversed(self._depths):
            for start in range(0, len(parts), batch):
                some = parts[start : start + batch]
                maps, reach[some] = spread(scores[some], self._a[some], self._shift[some])
                for part, message in zip(some, maps, strict=True):
                    scores[self._parents[part]] += message
        return Match(self, scores, reach)

    def _parts(self, tree: int) -> range:
        root = int(self.roots[tree])
        return range(root, root + len(self.components[tree].parents))


@dataclass(frozen=True, eq=False)
class Match:
    """The result of passing the messages.

    Attributes:
        forest: the trees.
        scores: (N, R, C) of each part with all parts below it, but for terms that no choice below depends on.
        reach: (N, 2) how far each part can be from where its parent wants it, x, y [cells].
    """

    forest: Forest
    scores: Array
    reach: NDArray[np.int64]

    @property
    def roots(self) -> Array:
        """(components, R, C): the best score of a whole tree for each place of its root."""
        roots: Array = self.scores[self.forest.roots]
        return roots

    def places(self, tree: int, root_cells: NDArray[np.int64]) -> NDArray[np.int64]:
        """Where the parts are in the best configuration.

        Args:
            tree: which component.
            root_cells: (M, 2) x, y of the root.

        Returns:
            (M, n, 2) x, y of each part.
        """
        forest, parts, cols = self.forest, self.forest._parts(tree), self.scores.shape[2]
        places = np.empty((len(root_cells), len(parts), 2), np.int64)
        places[:, 0] = root_cells
        for i, part in enumerate(parts[1:], start=1):
            x, y = places[:, forest._parents[part] - parts[0]].T
            different, back = np.unique(y * cols + x, return_inverse=True)
            wanted = np.stack([different % cols, different // cols], axis=1) + forest._shift[part]
            places[:, i] = self._best(part, wanted)[back]
        return places

    def _best(self, part: int, wanted: NDArray[np.int64]) -> NDArray[np.int64]:
        """The best cells (M, 2) for a part that is wanted at the cells ``wanted`` (M, 2)."""
        scores, (reach_x, reach_y) = self.scores[part], self.reach[part]
        x = np.clip(wanted[:, :1] + np.arange(-reach_x, reach_x + 1), 0, scores.shape[1] - 1)
        y = np.clip(wanted[:, 1:] + np.arange(-reach_y, reach_y + 1), 0, scores.shape[0] - 1)
        ax, ay = self.forest._a[part]
        cost = (ay * (y - wanted[:, 1:]) ** 2)[:, :, None] + (ax * (x - wanted[:, :1]) ** 2)[:, None, :]
        best = (scores[y[:, :, None], x[:, None, :]] - cost).reshape(len(wanted), -1).argmax(axis=1)
        row, col = np.divmod(best, x.shape[1])
        each = np.arange(len(wanted))
        return np.stack([x[each, col], y[each, row]], axis=1)
