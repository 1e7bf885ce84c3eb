"""A drawing and an arm go in; the checked motion that draws it comes out, with where the sheet lies."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import numpy as np

from limner.errors import CannotDraw
from limner.motion.arm import place as places
from limner.motion.arm.check import check
from limner.motion.arm.collide import deepest
from limner.motion.arm.ik import Inverse, InverseSettings, inverse
from limner.motion.arm.lifted import LiftedPath, LiftSettings, lifted_path
from limner.motion.arm.paper import Placement
from limner.motion.arm.place import PlaceSettings
from limner.motion.arm.retime import RetimeSettings, joined, move, retime
from limner.motion.arm.robot import Robot
from limner.settings import SettingsGroup, group
from limner.types import Drawing, Floats, JointTrajectory

SAFE = "safe"
"""The pose that drawing starts from and returns to, where the robot has one of that name."""


@dataclass(frozen=True)
class ArmSettings(SettingsGroup):
    """Everything between a drawing and the motion of an arm's joints."""

    place: PlaceSettings = group(PlaceSettings)
    inverse: InverseSettings = group(InverseSettings)
    lift: LiftSettings = group(LiftSettings)
    retime: RetimeSettings = group(RetimeSettings)


@dataclass(frozen=True, eq=False)
class ArmPlan:
    """A drawing, ready for an arm.

    Attributes:
        robot: that draws.
        placement: of the sheet.
        path: of the pen over the sheet.
        trajectory: of the joints, checked, from the safe pose and back to it.
        seconds: spent on each step.
    """

    robot: Robot
    placement: Placement
    path: LiftedPath
    trajectory: JointTrajectory
    seconds: dict[str, float]

    def report(self) -> dict[str, Any]:
        """Numbers for people and programs."""
        motion, step = self.trajectory, np.diff(self.trajectory.t_s, prepend=0.0)
        size = self.robot.margin(motion.q)
        return {
            "robot": self.robot.name,
            "seconds": float(motion.t_s[-1]),
            "draw_s": float(step[motion.down].sum()),
            "travel_s": float(step[~motion.down].sum()),
            "strokes": int(motion.stroke.max(initial=-1) + 1),
            "samples": len(motion.t_s),
            "base_from_paper": self.placement.base_from_paper.tolist(),
            "spin_deg": float(np.degrees(self.placement.spin_rad)),
            "lean_deg": float(np.degrees(self.placement.lean_rad)),
            "margin_deg": float(np.degrees(size[:, ~self.robot.prismatic].min())),
            "velocity_used": float((np.abs(motion.qd) / self.robot.velocity).max()),
            "acceleration_used": float((np.abs(motion.qdd) / self.robot.acceleration).max()),
            "planning_s": self.seconds,
        }


def plan_arm(drawing: Drawing, robot: Robot, settings: ArmSettings, placement: Placement | None = None) -> ArmPlan:
    """Plan how an arm draws.

    Args:
        drawing: what to draw.
        robot: that draws it.
        settings: of every step.
        placement: of the sheet, such as from a calibration; None: as ``settings.place`` says.

    Raises:
        NothingToDraw: the drawing has no strokes.
        CannotDraw: the sheet cannot be reached there or anywhere, or a limit would be exceeded.
        MissingExtra: a package of the extra ``robot`` is not installed.
    """
    seconds: dict[str, float] = {}
    arm = inverse(robot, settings.inverse)
    path = lifted_path(drawing, settings.lift)
    started = time.perf_counter()
    size = (drawing.page.width_mm, drawing.page.height_mm)
    tried = [placement] if placement is not None else _placements(robot, arm, size, settings.place)
    seconds["place"] = time.perf_counter() - started
    started = time.perf_counter()
    placed, q = _first_that_works(robot, arm, path, tried, size)
    seconds["inverse"] = time.perf_counter() - started
    started = time.perf_counter()
    drawn = retime(robot, path, q, settings.retime)
    trajectory = _from_safe_and_back(robot, drawn, placed, settings.retime)
    check(trajectory, robot)
    seconds["retime"] = time.perf_counter() - started
    return ArmPlan(robot, placed, path, trajectory, seconds)


def _placements(robot: Robot, arm: Inverse, size: tuple[float, float], settings: PlaceSettings) -> list[Placement]:
    if settings.at != places.AUTO:
        return [places.parse_place(settings.at, size, settings.spin_deg)]
    found = places.candidates(size, places.reach_map(robot, arm, settings), settings)
    if not found:
        raise CannotDraw(
            f"place: a sheet of {size[0]:g} x {size[1]:g} mm fits nowhere within reach of {robot.name};"
            " take a smaller page, let the pen lean (place.lean_deg), or free the table's height"
        )
    return found


def _first_that_works(
    robot: Robot, arm: Inverse, path: LiftedPath, tried: list[Placement], size: tuple[float, float]
) -> tuple[Placement, Floats]:
    problem: CannotDraw | None = None
    for placed in tried:
        q, _ = arm.follow(placed.tips(path.points_mm))
        if q is None:
            problem = problem or places.unreachable(arm, placed, path.points_mm[:: max(1, len(path.points_mm) // 300)], size)
            continue
        collision = deepest(robot, q[:: max(1, len(q) // 500)], placed.base_from_paper)
        if collision is None:
            return placed, q
        problem = problem or CannotDraw(f"place: {collision.describe(robot)}; try another place, or auto")
    assert problem is not None
    raise problem


def _from_safe_and_back(robot: Robot, drawn: JointTrajectory, placed: Placement, settings: RetimeSettings) -> JointTrajectory:
    """The motion with one from the safe pose before it, and one back to it after."""
    if SAFE not in robot.poses:
        return drawn
    there = move(robot, robot.pose(SAFE), drawn.q[0], settings)
    back = move(robot, drawn.q[-1], robot.pose(SAFE), settings)
    for way in (there, back):
        collision = deepest(robot, way.q, placed.base_from_paper)
        if collision is not None:
            raise CannotDraw(
                f"plan: on the way between the pose '{SAFE}' and the sheet {collision.describe(robot)};"
                f" move the sheet, or give {robot.name} another pose '{SAFE}'"
            )
    return joined((there, drawn, back))
