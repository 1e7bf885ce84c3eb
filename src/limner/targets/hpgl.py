"""A drawing goes in; HP-GL, which pen plotters have understood since 1976, comes out."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from limner.errors import BadInput
from limner.types import Drawing, Floats

UNITS_PER_MM = 40
"""A plotter unit is 0.025 mm."""

POINTS_PER_WORD = 40
"""Old plotters have small buffers: a longer line is said in several words."""

_FARTHEST = 2**23 - 1  # the largest number of HP-GL/2


def to_hpgl(drawing: Drawing) -> bytes:
    """The drawing as HP-GL: IN, SP, PU and PD with absolute coordinates in plotter units, y up, lower left = (0, 0).

    SP n takes the n-th of the pens that draw something: which is where in the plotter's carousel, or put in by hand
    where it waits. The pen is raised after every stroke, so that each can be told from the next; a dot is the pen
    lowered and raised.

    Raises:
        BadInput: a point is farther off than HP-GL can say.
    """
    words = ["IN;SP1;PA;"]
    pens = np.unique(drawing.layer, return_inverse=True)[1] + 1
    for line, pen, changed in zip(drawing.lines_mm, pens.tolist(), drawing.changes().tolist(), strict=True):
        words += [f"PU;SP{pen};"] if changed else []
        points = to_units(line)
        words.append(f"PU{_pairs(points[:1])};")
        rest = points[1:]
        words.append("PD;" if not len(rest) else "")
        words += [f"PD{_pairs(rest[k : k + POINTS_PER_WORD])};" for k in range(0, len(rest), POINTS_PER_WORD)]
    words.append("PU0,0;SP0;")
    return ("\n".join(word for word in words if word) + "\n").encode()


def to_units(line: Floats) -> NDArray[np.int64]:
    """A line [mm] in whole plotter units, without repeats.

    Raises:
        BadInput: a point is farther off than HP-GL can say.
    """
    if np.abs(line).max() * UNITS_PER_MM > _FARTHEST:
        raise BadInput(
            f"hpgl: a point is more than {_FARTHEST // UNITS_PER_MM // 1000} m off; place the drawing on its page"
        )
    units: NDArray[np.int64] = np.rint(line * UNITS_PER_MM).astype(np.int64)
    new: NDArray[np.bool_] = np.concatenate([[True], (np.diff(units, axis=0) != 0).any(axis=1)])
    return units[new]


def _pairs(points: NDArray[np.int64]) -> str:
    return ",".join(f"{x},{y}" for x, y in points.tolist())
