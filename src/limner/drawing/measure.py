"""A drawing goes in; what drawing it costs comes out: strokes, points, ink, travel and lifts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from limner import geometry
from limner.types import Drawing, Floats

HOME_MM = (0.0, 0.0)
"""Where the pen is before the first stroke and after the last: the page's origin, lower left."""


@dataclass(frozen=True)
class Measures:
    """What drawing a drawing costs.

    Attributes:
        strokes: lines drawn.
        points: vertices the machine must go to.
        ink_mm: pen-down length.
        travel_mm: pen-up length: from ``HOME_MM`` to the first stroke, between strokes, and back.
        lifts: how often the pen is raised; not between strokes of which one starts where the other ended,
            unless the pen is changed.
    """

    strokes: int
    points: int
    ink_mm: float
    travel_mm: float
    lifts: int


def measure(drawing: Drawing) -> Measures:
    """Count and add up, in the order in which the strokes stand."""
    hops = travel_hops_mm(drawing.lines_mm)
    return Measures(
        strokes=len(drawing.lines_mm),
        points=drawing.points,
        ink_mm=float(geometry.total_length(drawing.lines_mm)),
        travel_mm=float(hops.sum()),
        lifts=int(((hops[1:-1] > 0) | drawing.changes()[1:]).sum()) + bool(drawing.lines_mm),
    )


def travel_hops_mm(lines: Sequence[Floats]) -> Floats:
    """Lengths of the pen-up moves, the first from ``HOME_MM``, the last back to it: (lines + 1,)."""
    home = np.array([HOME_MM])
    ends = np.concatenate([home, *(line[-1:] for line in lines)])
    starts = np.concatenate([*(line[:1] for line in lines), home])
    hops: Floats = np.hypot(*(starts - ends).T)
    return hops
