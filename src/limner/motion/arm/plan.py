"""A drawing and an arm go in; the checked motion that draws it comes out, with where the sheet lies."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import numpy as np

from limner.errors import CannotDraw
from limner.motion.arm import place as places
from limner.motion.arm.check import check
from limner.motion.arm.collide import Collision, deepest
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
    try:
        placed, q = _first_that_works(robot, arm, path, tried, size)
    except CannotDraw as error:
        if len(tried) > 1:
            raise
        raise CannotDraw(f"{error}{_nearest(robot, arm, path, tried[0], size, settings.place)}") from error
    seconds["inverse"] = time.perf_counter() - started
    started = time.perf_counter()
    drawn = retime(robot, path, q, settings.retime)
    trajectory = _from_safe_and_back(robot, drawn, settings.retime)
    check(trajectory, robot)
    seconds["retime"] = time.perf_counter() - started
    return ArmPlan(robot, placed, path, trajectory, seconds)


def _placements(robot: Robot, arm: Inverse, size: tuple[float, float], settings: PlaceSettings) -> list[Placement]:
    if settings.at != places.AUTO:
        return [places.parse_place(settings.at, size, settings.spin_deg)]
    found = places.candidates(size, places.reach_map(robot, arm, settings))
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
        touched: list[Collision] = []

        def clear(q: Floats, placed: Placement = placed, touched: list[Collision] = touched) -> bool:
            some = q[:: max(1, len(q) // 500)]
            # On the way from the safe pose and back nothing may be touched either.
            ways = [_between(robot.pose(SAFE), end) for end in (q[0], q[-1]) if SAFE in robot.poses]
            collision = deepest(robot, np.concatenate([some, *ways]), placed.base_from_paper)
            collision = collision or _pen_in_table(robot, ways, placed)
            touched += [collision] if collision else []
            return collision is None

        q, _ = arm.follow(placed.tips(path.points_mm), clear)
        if q is not None:
            return placed, q
        if touched:
            problem = problem or CannotDraw(f"place: {touched[0].describe(robot)}; try another place, or auto")
        else:
            some = path.points_mm[:: max(1, len(path.points_mm) // 300)]
            problem = problem or places.unreachable(arm, placed, some, size)
    raise problem or CannotDraw("place: nowhere to try")


def _pen_in_table(robot: Robot, ways: list[Floats], placed: Placement) -> Collision | None:
    """Where the pen dips into the table on ways that are not drawing, as an arm that turns its joints evenly does."""
    heights = [placed.points_mm(robot.forward(way)[:, :3, 3])[:, 2].min() for way in ways]
    lowest = min(heights, default=0.0)
    return Collision(0, robot.dof, -1, -lowest / 1000) if lowest < 0 else None


def _nearest(
    robot: Robot, arm: Inverse, path: LiftedPath, asked: Placement, size: tuple[float, float], settings: PlaceSettings
) -> str:
    """In words, the place nearest to the one asked for at which all of the path can be drawn."""
    middle = (size[0] / 2, size[1] / 2)
    free = settings.replace(at=places.AUTO)
    found = places.candidates(size, places.reach_map(robot, arm, free), best=200)
    found.sort(key=lambda placed: float(np.linalg.norm(placed.points_m(middle) - asked.points_m(middle))))
    try:
        placed, _ = _first_that_works(robot, arm, path, found[:12], size)
    except CannotDraw:
        return "; no place was found that can"
    x, y, z = placed.points_m(middle)
    turn = np.degrees(np.arctan2(placed.base_from_paper[1, 0], placed.base_from_paper[0, 0]))
    return f"; the nearest place found that can: {x:.3f},{y:.3f},{z:.3f},{turn:.0f}"


def _from_safe_and_back(robot: Robot, drawn: JointTrajectory, settings: RetimeSettings) -> JointTrajectory:
    """The motion with one from the safe pose before it, and one back to it after."""
    if SAFE not in robot.poses:
        return drawn
    there = move(robot, robot.pose(SAFE), drawn.q[0], settings)
    back = move(robot, drawn.q[-1], robot.pose(SAFE), settings)
    return joined((there, drawn, back))


def _between(start: Floats, end: Floats, step_rad: float = 0.05) -> Floats:
    """Joint positions (n, dof) evenly from one (dof,) to another."""
    count = max(3, int(np.ceil(np.abs(end - start).max() / step_rad)) + 1)
    return np.linspace(start, end, count)
