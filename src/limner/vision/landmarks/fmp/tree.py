"""Shapes of many faces in; the tree of landmarks that explains them best (Chow-Liu) out, root first."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from limner.errors import BadInput
from limner.types import Floats

NOSE_BASE = 33
"""The iBUG landmark from which the trees hang (the authors' root too)."""


@dataclass(frozen=True)
class Tree:
    """A rooted tree of landmarks.

    Attributes:
        landmarks: (n,) landmark of each part; the root first, parents before children.
        parents: (n,) part that each part hangs from; the root's is -1.
    """

    landmarks: tuple[int, ...]
    parents: tuple[int, ...]


def mutual_information(shapes: Floats, least_variance: float) -> Floats:
    """How much two landmarks tell about each other, up to one constant for all pairs.

    A face may lie anywhere, so a landmark alone has a flat distribution, and under the Gaussian assumption the
    information of a pair is that constant less the entropy of their offset. The offset's covariance is taken along
    the axes, as the springs are (thesis 3.2.1; Chow & Liu 1968, doi:10.1109/TIT.1968.1054142).

    Args:
        shapes: (faces, n, 2) landmarks, all faces at one scale.
        least_variance: floor of the variances [unit of shapes squared], what measuring cannot tell apart.

    Returns:
        (n, n) information [nat], symmetric; the diagonal is -inf.
    """
    offsets = shapes[:, :, None, :] - shapes[:, None, :, :]
    variance = np.maximum(offsets.var(axis=0), least_variance)
    information: Floats = -0.5 * np.log(2 * np.pi * np.e * variance).sum(axis=-1)
    np.fill_diagonal(information, -np.inf)
    return information


def spanning_tree(weight: Floats, root: int) -> Tree:
    """The spanning tree with the largest sum of weights (Prim 1957), hung from ``root``.

    Args:
        weight: (n, n) symmetric.
        root: index of the root.
    """
    n = len(weight)
    best = weight[root].astype(np.float64).copy()
    towards: NDArray[np.int64] = np.full(n, root)
    best[root] = -np.inf
    free = np.ones(n, bool)
    free[root] = False
    landmarks, parents, part = [root], [-1], {root: 0}
    while free.any():
        new = int(np.where(free, best, -np.inf).argmax()) if np.isfinite(best[free]).any() else int(free.argmax())
        part[new] = len(landmarks)
        landmarks.append(new)
        parents.append(part[int(towards[new])])
        free[new] = False
        closer = free & (weight[new] > best)
        best[closer], towards[closer] = weight[new][closer], new
    return Tree(tuple(landmarks), tuple(parents))


def chow_liu(shapes: Floats, root: int = NOSE_BASE, least_variance: float = 0.01) -> Tree:
    """The tree of landmarks with the largest likelihood over the shapes.

    Args:
        shapes: (faces, n, 2) landmarks, all faces at one scale (cells).
        root: landmark to hang it from.
        least_variance: floor of the offsets' variances [cell^2].

    Raises:
        BadInput: no face, a landmark that is not known, or a root that does not exist.
    """
    if shapes.ndim != 3 or shapes.shape[0] < 1 or shapes.shape[2] != 2:
        raise BadInput(f"tree: expected shapes of (faces, n, 2), got {shapes.shape}")
    if not np.isfinite(shapes).all():
        raise BadInput("tree: a landmark is not known in one of the shapes; expected all of them")
    if not 0 <= root < shapes.shape[1]:
        raise BadInput(f"tree: landmark {root} as root, expected 0 to {shapes.shape[1] - 1}")
    return spanning_tree(mutual_information(shapes, least_variance), root)
