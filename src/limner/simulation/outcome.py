"""A checked motion goes in; what becomes of it on a simulated arm comes out, with numbers beside the plan."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from limner import geometry
from limner.motion.arm.pen_check import USUAL, Allowed, check_motion
from limner.motion.arm.robot import Robot
from limner.motion.arm.spline import hermite
from limner.simulation.commands import commands
from limner.simulation.ink import Ink, ink
from limner.simulation.model import to_mjcf
from limner.simulation.physics import Record, Watch, run, step_times
from limner.simulation.settings import SimulationSettings
from limner.simulation.sheet import Sheet, find_sheet, stroke_tips
from limner.types import Drawing, Floats, JointTrajectory

NEAR_MM = 0.5
"""Ink this close to its planned stroke is where it should be."""


@dataclass(frozen=True, eq=False)
class Simulation:
    """A simulated drawing.

    Attributes:
        robot: that drew.
        trajectory: that it was given.
        sheet: where the plan takes the sheet to lie.
        paper: where it really lay.
        record: of arm, pen and force.
        ink: what the pen left.
        plan_mm: the planned strokes (n, 2) by index, in the paper frame.
        settings: in force.
    """

    robot: Robot
    trajectory: JointTrajectory
    sheet: Sheet
    paper: Sheet
    record: Record
    ink: Ink
    plan_mm: dict[int, Floats]
    settings: SimulationSettings

    @property
    def press_mm(self) -> float:
        """How far below the sheet the tip is led."""
        return self.settings.press_for(self.trajectory)

    def report(self) -> dict[str, Any]:
        """Numbers for people and programs."""
        steps, made = self.ink.steps_mm(), self.ink
        drawn = made.touches & made.down
        error = self.errors_mm()
        force = made.force_n[drawn]
        off = self._tip_errors_mm()
        return {
            "robot": self.robot.name,
            "seconds": float(self.trajectory.t_s[-1]),
            "strokes": len(self.plan_mm),
            "plan_ink_mm": geometry.total_length(list(self.plan_mm.values())),
            "ink_mm": float(steps[drawn].sum()),
            "contact_percent": 100 * _share(made.touches[made.down], steps[made.down]),
            "ink_error_mm": _spread(error, steps[drawn], (50, 95, 100)),
            "ink_within_half_mm_percent": 100 * _share(error <= NEAR_MM, steps[drawn]),
            "travel_ink_mm": float(steps[self.trail()].sum()),
            "force_n": _spread(force, np.ones(len(force)), (0, 5, 50, 95, 100)),
            "tracking_mm": {
                "rms": float(np.sqrt((off[made.down] ** 2).mean())),
                "max": float(off[made.down].max()),
            },
            "base_from_paper": self.sheet.base_from_paper.tolist(),
        }

    def errors_mm(self) -> Floats:
        """Distance of the ink of each stroke from where that stroke was planned, record by record."""
        made, errors = self.ink, []
        drawn = made.touches & made.down
        for place, stroke in _runs(made.place_mm[drawn], made.stroke[drawn]):
            errors.append(distance_mm(place, self.plan_mm[stroke]))
        return np.concatenate([np.zeros(0), *errors])

    def trail(self) -> NDArray[np.bool_]:
        """Which records (n,) left ink in travel, away from where the stroke before ended and the next one begins."""
        made = self.ink
        travelled = np.flatnonzero(made.touches & ~made.down)
        ends = np.flatnonzero(made.down)
        away = np.full(len(travelled), np.inf)
        for step, within in ((-1, np.searchsorted(ends, travelled) > 0), (0, travelled < ends.max(initial=-1))):
            end = ends[np.searchsorted(ends, travelled[within]) + step]
            distance = np.hypot(*(made.place_mm[travelled[within]] - made.place_mm[end]).T)
            away[within] = np.minimum(away[within], distance)
        trails = np.zeros(len(made.touches), bool)
        trails[travelled] = away > NEAR_MM
        return trails

    def _tip_errors_mm(self) -> Floats:
        """How far along the sheet the tip was from where it should have been at that time."""
        q = hermite(self.trajectory, self.record.t_s).q
        wanted = self.paper.touched_mm(self.robot.forward(q))
        distance: Floats = np.hypot(*(self.ink.place_mm - wanted).T)
        return distance


def simulate(
    trajectory: JointTrajectory,
    robot: Robot,
    settings: SimulationSettings | None = None,
    drawing: Drawing | None = None,
    watch: Watch | None = None,
    allowed: Allowed = USUAL,
) -> Simulation:
    """Let a simulated arm draw.

    Args:
        trajectory: of the robot's joints.
        robot: that moves.
        settings: servos, pen, paper and faults.
        drawing: what is drawn, for the place and size of the page; see ``find_sheet``.
        watch: told of the progress.
        allowed: what its pen may do at most.

    Raises:
        CannotDraw: the motion is not the robot's or exceeds its limits or the pen's, or the arm became unstable.
        BadInput: the pen is never down, or the drawing is another one.
        MissingExtra: mujoco is not installed.
    """
    settings = settings or SimulationSettings()
    check_motion(trajectory, robot, allowed)
    sheet = find_sheet(trajectory, robot, settings.press_for(trajectory), drawing)
    return follow(trajectory, robot, sheet, settings, watch)


def follow(
    trajectory: JointTrajectory, robot: Robot, sheet: Sheet, settings: SimulationSettings, watch: Watch | None = None
) -> Simulation:
    """Let a simulated arm follow a motion, checked or not, over a sheet that is known; else as ``simulate``."""
    paper = sheet.faulty(settings.fault)
    told = commands(trajectory, robot, settings, step_times(float(trajectory.t_s[-1])))
    record = run(to_mjcf(robot, paper, settings), trajectory.q[0], told, settings, watch)
    plan = {stroke: sheet.touched_mm(tips) for stroke, tips in stroke_tips(trajectory, robot).items()}
    made = ink(record, trajectory, paper)
    return Simulation(robot, trajectory, sheet, paper, record, made, plan, settings)


def distance_mm(places: Floats, line: Floats) -> Floats:
    """Distance of places (n, 2) from a polyline (m, 2)."""
    if len(line) < 2:
        return np.asarray(np.hypot(*(places - line[0]).T))
    nearest = np.full(len(places), np.inf)
    for a, b in itertools.pairwise(line):
        nearest = np.minimum(nearest, geometry.distance_to_segments(places, a, b))
    return nearest


def _runs(places: Floats, strokes: NDArray[np.int64]) -> list[tuple[Floats, int]]:
    """Places (n, 2) of one stroke after the other."""
    bounds = np.r_[0, np.flatnonzero(np.diff(strokes)) + 1, len(strokes)]
    return [(places[a:b], int(strokes[a])) for a, b in itertools.pairwise(bounds) if a < b]


def _share(which: NDArray[np.bool_], weight: Floats) -> float:
    return float(weight[which].sum() / weight.sum()) if weight.sum() > 0 else 0.0


def _spread(values: Floats, weight: Floats, per_cents: tuple[int, ...]) -> dict[str, float | None]:
    """Values below which these shares of the weight lie; None where there are none."""
    names = {0: "min", 50: "median", 100: "max"}
    if not len(values):
        return {names.get(share, f"p{share}"): None for share in per_cents}
    order = np.argsort(values, kind="stable")
    reached = np.cumsum(weight[order])
    at = [min(int(np.searchsorted(reached, share / 100 * reached[-1])), len(values) - 1) for share in per_cents]
    return {names.get(share, f"p{share}"): float(values[order[i]]) for share, i in zip(per_cents, at, strict=True)}
