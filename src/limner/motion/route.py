"""A drawing goes in; the straight moves that draw it come out: travel, and strokes joined where they meet."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from limner.types import Drawing, Floats


@dataclass(frozen=True)
class Route:
    """Moves one after the other.

    Attributes:
        vertices_mm: (m + 1, 2), page frame; move k goes from k to k + 1.
        draws: (m,) whether the pen is down.
        stroke: (m,) index of the stroke, -1 in travel.
    """

    vertices_mm: Floats
    draws: NDArray[np.bool_]
    stroke: NDArray[np.int64]

    @property
    def lowers(self) -> NDArray[np.bool_]:
        """(m,) whether the pen is lowered before the move."""
        before: NDArray[np.bool_] = np.concatenate([[False], self.draws[:-1]])
        return self.draws & ~before

    @property
    def raises(self) -> NDArray[np.bool_]:
        """(m,) whether the pen is raised before the move."""
        before: NDArray[np.bool_] = np.concatenate([[False], self.draws[:-1]])
        return ~self.draws & before


def route(drawing: Drawing, start_mm: Floats, end_mm: Floats | None) -> Route:
    """The moves of a drawing, in its order.

    The pen stays down where a stroke starts at the point at which the one before ended, unless it is another pen's.
    Points that repeat the one before are left out; a dot is a move of no length with the pen down.

    Args:
        drawing: what to draw.
        start_mm: (2,) where the pen is, raised.
        end_mm: (2,) where it goes afterwards; none to raise it where the last stroke ends.
    """
    if not drawing.lines_mm:
        end = start_mm if end_mm is None else end_mm
        return Route(np.stack([start_mm, end]), np.array([False]), np.array([-1]))
    points, stroke = _points(drawing)
    first = np.concatenate([[True], stroke[1:] != stroke[:-1]])
    last = np.concatenate([first[1:], [True]])
    meets = first & np.concatenate([[False], (points[1:] == points[:-1]).all(axis=1)]) & ~drawing.changes()[stroke]
    # A dot needs two vertices, a stroke that goes on from the one before needs its first no more.
    times = np.where(first & last, np.where(meets, 1, 2), np.where(meets, 0, 1))
    copies = np.arange(times.sum()) - np.repeat(np.cumsum(times) - times, times)
    lands = np.repeat(first & ~meets, times) & (copies == 0)
    points, stroke = np.repeat(points, times, axis=0), np.repeat(stroke, times)
    end = points[-1] if end_mm is None else end_mm
    draws = ~np.concatenate([lands, [True]])
    return Route(
        np.concatenate([[start_mm], points, [end]]), draws, np.where(draws, np.concatenate([stroke, [-1]]), -1)
    )


def _points(drawing: Drawing) -> tuple[Floats, NDArray[np.int64]]:
    """All vertices without those that repeat the one before in their stroke, and the stroke of each."""
    points = np.concatenate(drawing.lines_mm)
    stroke = np.repeat(np.arange(len(drawing.lines_mm)), [len(line) for line in drawing.lines_mm])
    repeats = (np.diff(points, axis=0) == 0).all(axis=1) & (stroke[1:] == stroke[:-1])
    keep = np.concatenate([[True], ~repeats])
    return points[keep], stroke[keep]
