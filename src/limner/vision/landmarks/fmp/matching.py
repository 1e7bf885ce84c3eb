"""Score maps of every part of one or more trees go in, the best place of every part for each root cell comes out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from limner.vision.landmarks.fmp.hog import Array
from limner.vision.landmarks.fmp.model import Component
from limner.vision.landmarks.fmp.transform import spread

_BATCH_CELLS = 100_000
"""Cells worked on at once: small maps together, large ones one by one, so that they stay in the cache."""

_BATCH_WINDOWS = 1_000_000
"""Candidate places compared at once."""


class Forest:
    """The trees of some components, ready for matching; parts are numbered through, component after component.

    Along each axis the cost of a displacement d, ``a d^2 + b d``, is that of ``e = d + t``, ``a e^2 + beta e + gamma``,
    with t whole and ``|beta| <= a``. What is linear in the two cells' coordinates goes to the parts' own scores, what
    is constant to the root's, so that the distance transform has only ``a e^2``, a shift and a slope.

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
        self._slope = beta.copy()
        children = np.flatnonzero(self._parents >= 0)
        np.subtract.at(self._slope, self._parents[children], beta[children])
        constant = -gamma - (beta * self._shift).sum(1)
        constant[self.roots] = [component.bias for component in components]
        self._offset = np.add.reduceat(constant, self.roots)
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
        reach = np.zeros((len(scores), 2), np.int64)
        batch = max(1, _BATCH_CELLS // max(1, rows * cols))
        for parts in reversed(self._depths):
            for start in range(0, len(parts), batch):
                some = parts[start : start + batch]
                maps, reach[some] = spread(scores[some], self._a[some], self._shift[some], self._slope[some])
                for part, message in zip(some, maps, strict=True):
                    scores[self._parents[part]] += message
        return Match(self, scores, reach)


@dataclass(frozen=True, eq=False)
class Match:
    """The result of passing the messages.

    Attributes:
        forest: the trees.
        scores: (N, R, C) of each part with all parts below it, but for the forest's slopes and constants.
        reach: (N, 2) how far each part can be from where its parent wants it, x, y [cells].
    """

    forest: Forest
    scores: Array
    reach: NDArray[np.int64]

    @property
    def roots(self) -> Array:
        """(components, R, C): the best score of a whole tree for each place of its root."""
        scores: Array = self.scores[self.forest.roots]
        offset, slope = self.forest._offset, self.forest._slope[self.forest.roots]
        y, x = np.arange(scores.shape[1])[:, None], np.arange(scores.shape[2])
        scores += offset[:, None, None] + slope[:, 1, None, None] * y + slope[:, 0, None, None] * x
        return scores

    def places(self, tree: int, root_cells: NDArray[np.int64]) -> NDArray[np.int64]:
        """Where the parts are in the best configuration.

        Args:
            tree: which component.
            root_cells: (M, 2) x, y of the root.

        Returns:
            (M, n, 2) x, y of each part.
        """
        forest, (rows, cols) = self.forest, self.scores.shape[1:]
        root, count = int(forest.roots[tree]), len(forest.components[tree].parents)
        cells = np.empty((len(root_cells), count), np.int64)
        cells[:, 0] = root_cells[:, 1] * cols + root_cells[:, 0]
        for parts in forest._depths:
            parts = parts[(parts >= root) & (parts < root + count)]
            at_parents = cells[:, forest._parents[parts] - root] + np.arange(len(parts)) * (rows * cols)
            # Of many roots several may ask the same of a part; of one none does.
            alone = len(root_cells) == 1
            different, back = (
                (at_parents[0], np.arange(len(parts))) if alone else np.unique(at_parents, return_inverse=True)
            )
            which, cell = np.divmod(different, rows * cols)
            best = self._best(parts[which], np.stack([cell % cols, cell // cols], axis=1) + forest._shift[parts[which]])
            cells[:, parts - root] = best[back.reshape(at_parents.shape)]
        return np.stack([cells % cols, cells // cols], axis=2)

    def _best(self, parts: Array, wanted: Array) -> Array:
        """The best cell, counted row by row, for each of some parts (M,) that are wanted at cells x, y (M, 2)."""
        if not len(parts):
            return np.empty(0, np.int64)
        reach_x, reach_y = self.reach[parts].max(axis=0)
        batch = max(1, _BATCH_WINDOWS // ((2 * reach_x + 1) * (2 * reach_y + 1)))
        around_x, around_y = np.arange(-reach_x, reach_x + 1), np.arange(-reach_y, reach_y + 1)
        starts = range(0, len(parts), int(batch))
        found = [self._best_of(parts[s : s + batch], wanted[s : s + batch], around_x, around_y) for s in starts]
        return np.concatenate(found)

    def _best_of(self, parts: Array, wanted: Array, around_x: Array, around_y: Array) -> Array:
        (rows, cols), forest = self.scores.shape[1:], self.forest
        x = np.minimum(np.maximum(wanted[:, :1] + around_x, 0), cols - 1)  # np.clip takes ten times as long
        y = np.minimum(np.maximum(wanted[:, 1:] + around_y, 0), rows - 1)
        a, slope = forest._a[parts], forest._slope[parts]
        gain_x = slope[:, :1] * x - a[:, :1] * (x - wanted[:, :1]) ** 2
        gain_y = slope[:, 1:] * y - a[:, 1:] * (y - wanted[:, 1:]) ** 2
        places = (parts[:, None] * rows + y)[:, :, None] * cols + x[:, None, :]
        total = self.scores.reshape(-1)[places] + gain_y[:, :, None] + gain_x[:, None, :]
        best = total.reshape(len(parts), -1).argmax(axis=1)
        found: Array = places.reshape(len(parts), -1)[np.arange(len(parts)), best] - parts * (rows * cols)
        return found
