"""The record of a simulation and its sheet go in; the lines of ink that the pen left come out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from limner.simulation.physics import Record
from limner.simulation.sheet import Sheet
from limner.types import Floats, JointTrajectory, Value

TOUCH_N = 0.02
"""A pen that is pushed by less leaves no ink."""

FULL_N = 1.5
"""The force at which the pen's line is as wide as the pen is said to be (assumed)."""

_THINNEST, _WIDEST = 0.45, 1.6


@dataclass(frozen=True, eq=False)
class Ink(Value):
    """What the pen did over the sheet, record by record.

    Attributes:
        t_s: (n,).
        place_mm: (n, 2) of the tip in the paper frame.
        force_n: (n,).
        touches: (n,) whether it leaves ink.
        down: (n,) whether it was meant to.
        stroke: (n,) index of the planned stroke, -1 in travel.
    """

    t_s: Floats
    place_mm: Floats
    force_n: Floats
    touches: NDArray[np.bool_]
    down: NDArray[np.bool_]
    stroke: NDArray[np.int64]

    def lines(self) -> list[tuple[Floats, Floats]]:
        """Each unbroken line: places (n, 2) [mm] and force (n,) [N]; a touch without movement is a point."""
        edges = np.flatnonzero(np.diff(np.r_[False, self.touches, False].astype(np.int8)))
        return [(self.place_mm[a:b], self.force_n[a:b]) for a, b in edges.reshape(-1, 2)]

    def steps_mm(self) -> Floats:
        """(n,) how far the tip went along the paper since the record before."""
        steps: Floats = np.r_[0.0, np.hypot(*np.diff(self.place_mm, axis=0).T)]
        return steps


def ink(record: Record, trajectory: JointTrajectory, paper: Sheet) -> Ink:
    """What the pen left on a sheet.

    Args:
        record: of the simulation.
        trajectory: that was followed.
        paper: where the sheet really lay.
    """
    sample = np.clip(np.searchsorted(trajectory.t_s, record.t_s), 0, len(trajectory.t_s) - 1)
    return Ink(
        record.t_s,
        paper.points_mm(record.tip_m)[:, :2],
        record.force_n,
        record.force_n > TOUCH_N,
        trajectory.down[sample],
        trajectory.stroke[sample],
    )


def widths(force_n: Floats, pen_mm: float) -> Floats:
    """Width of the line [mm]: it grows with the cube root of the force, as the dent of a ball does (Hertz 1882)."""
    share = np.cbrt(np.maximum(force_n, 0) / FULL_N)
    width: Floats = pen_mm * np.clip(share, _THINNEST, _WIDEST)
    return width
