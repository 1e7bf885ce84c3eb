"""A line goes in; its versions with fewer and fewer points come out, each worth the points it has."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from limner import geometry
from limner.types import Floats


@dataclass(frozen=True)
class Coarsening:
    """Versions of a line, the coarsest first.

    Attributes:
        lines: each with more points than the one before, the last in the exact shape.
        values: of each, rising, in [0, 1]; the gain per point falls from each to the next (a concave hull).
    """

    lines: tuple[Floats, ...]
    values: tuple[float, ...]


def coarsenings(line: Floats, coarsest: float, shape_value: float) -> Coarsening:
    """Versions of a line from the coarsest within a tolerance to itself.

    The value of a version with error e is 1 - shape_value * (e / coarsest)^2; those that are not worth their points
    are left out. A ring stays a triangle at least.

    Args:
        line: (n, 2) in any unit.
        coarsest: the largest error of a version, in the same unit.
        shape_value: what the coarsest version lacks, in [0, 1].
    """
    error = drop_errors(line)
    if geometry.is_closed(line):
        corners = np.argsort(-error[1:-1], kind="stable")[:2] + 1
        error[corners[error[corners] > 0]] = np.inf
    tolerances = np.unique(error[error <= coarsest])[::-1]
    sizes = np.array([np.count_nonzero(error > t) for t in tolerances] + [len(line)])
    left = np.append(tolerances, 0.0)
    values = 1 - shape_value * (left / coarsest) ** 2 if coarsest > 0 else np.ones(len(left))
    kept = _hull(sizes, values)
    lines = tuple(line[error > left[k]] if k < len(tolerances) else line for k in kept)
    return Coarsening(lines, tuple(float(values[k]) for k in kept))


def drop_errors(line: Floats) -> Floats:
    """For each point the largest tolerance at which Douglas & Peucker's simplification drops it; ends never: (n,).

    ``line[drop_errors(line) > t]`` is ``geometry.simplify(line, t)``, for all t from one pass.
    """
    error = np.full(len(line), np.inf)
    todo = [(0, len(line) - 1, np.inf)]
    while todo:
        i, j, above = todo.pop()
        if j - i < 2:
            continue
        distance = geometry.distance_to_segments(line[i + 1 : j], line[i], line[j])
        k = int(distance.argmax())
        here = min(above, float(distance[k]))
        error[i + 1 + k] = here
        todo += [(i, i + 1 + k, here), (i + 1 + k, j, here)]
    return error


def _hull(sizes: Floats, values: Floats) -> list[int]:
    """Which versions lie on the upper concave hull of value over size, seen from no points and no value."""
    kept: list[int] = []
    for k in range(len(sizes)):
        while kept:
            before = (sizes[kept[-2]], values[kept[-2]]) if len(kept) > 1 else (0, 0.0)
            last = (sizes[kept[-1]] - before[0], values[kept[-1]] - before[1])
            new = (sizes[k] - sizes[kept[-1]], values[k] - values[kept[-1]])
            if new[1] * last[0] <= last[1] * new[0]:
                break
            kept.pop()
        if not kept or (sizes[k] > sizes[kept[-1]] and values[k] > values[kept[-1]]):
            kept.append(k)
    return kept
