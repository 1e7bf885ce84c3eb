"""A drawing and an arm go in; the checked motion that draws it comes out, with where the sheet lies."""

from __future__ import annotations

import dataclasses
import math
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
from limner.motion.arm.paper import Placement, thesis_sheet
from limner.motion.arm.pen_check import Allowed, check_pen, pen_limits
from limner.motion.arm.place import PlaceSettings, ReachMap
from limner.motion.arm.retime import RetimeSettings, joined, move, retime
from limner.motion.arm.robot import SAFE, Robot
from limner.motion.arm.rock import rocked
from limner.settings import SettingsGroup, group
from limner.types import Drawing, Floats, JointTrajectory

_SHARES = (1.0, 0.75, 0.5)
"""Of the sheet that is looked at when a place is sought; a leaning pen may get farther than the map tells."""

_APART_M = 0.1
"""Between places that are compared."""


@dataclass(frozen=True)
class ArmSettings(SettingsGroup):
    """Everything between a drawing and the motion of an arm's joints."""

    place: PlaceSettings = group(PlaceSettings)
    inverse: InverseSettings = group(InverseSettings)
    lift: LiftSettings = group(LiftSettings)
    retime: RetimeSettings = group(RetimeSettings)

    @property
    def allowed(self) -> Allowed:
        """What a motion's pen may do at most."""
        return Allowed(self.retime.pen_speed, self.lift.press_mm)


@dataclass(frozen=True, eq=False)
class ArmPlan:
    """A drawing, ready for an arm.

    Attributes:
        robot: that draws.
        placement: of the sheet.
        path: of the pen over the sheet.
        q: (n, dof) joint positions at its points.
        trajectory: of the joints, checked, from the safe pose and back to it.
        seconds: spent on each step.
    """

    robot: Robot
    placement: Placement
    path: LiftedPath
    q: Floats
    trajectory: JointTrajectory
    seconds: dict[str, float]

    def report(self) -> dict[str, Any]:
        """Numbers for people and programs."""
        motion, step = self.trajectory, np.diff(self.trajectory.t_s, prepend=0.0)
        size = self.robot.margin(motion.q)
        return {
            "robot": self.robot.name,
            "seconds": float(motion.t_s[-1]),
            "ink_s": self._from_first_ink_to_last_s(),
            "draw_s": float(step[motion.down].sum()),
            "travel_s": float(step[~motion.down].sum()),
            "strokes": int(motion.stroke.max(initial=-1) + 1),
            "samples": len(motion.t_s),
            "base_from_paper": self.placement.base_from_paper.tolist(),
            "spin_deg": float(np.degrees(self.placement.spin_rad)),
            "lean_deg": self.placement.lean_deg(self.path.points_mm),
            "margin_deg": float(np.degrees(size[:, ~self.robot.prismatic].min())),
            "velocity_used": float((np.abs(motion.qd) / self.robot.velocity).max()),
            "acceleration_used": float((np.abs(motion.qdd) / self.robot.acceleration).max()),
            "jerk_used": float((_rates(motion.t_s, motion.qdd) / self.robot.jerk).max()),
            "planning_s": self.seconds,
        }

    def _from_first_ink_to_last_s(self) -> float:
        drawn = np.flatnonzero(self.trajectory.down)
        return float(self.trajectory.t_s[drawn[-1]] - self.trajectory.t_s[max(drawn[0] - 1, 0)])


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
    if placement is None and settings.place.at == places.THESIS:
        table_m = settings.place.table_m
        drawing, placement = thesis_sheet(drawing, places.THESIS_TABLE_M if table_m is None else table_m)
    path = lifted_path(drawing, settings.lift)
    search = _Search(robot, arm, path, (drawing.page.width_mm, drawing.page.height_mm), settings.place)
    started = time.perf_counter()
    if placement is None and settings.place.at == places.AUTO:
        reach = places.reach_map(robot, arm, settings.place)
        seconds["place"] = time.perf_counter() - started
        started = time.perf_counter()
        placed, q = search.anywhere(reach)
    else:
        placed, q = search.there(
            placement or places.parse_place(settings.place.at, search.size_mm, settings.place.spin_deg)
        )
    seconds["inverse"] = time.perf_counter() - started
    started = time.perf_counter()
    rocking = rocked(robot, path, q, placed.base_from_paper[:3, 2])
    q = rocking if search.clear(rocking, placed) else q
    drawn = retime(robot, path, q, settings.retime)
    whole = _from_safe_and_back(robot, drawn, settings.retime)
    trajectory = dataclasses.replace(whole, press_mm=settings.lift.press_mm, sheet_m=placed.corners_m(search.size_mm))
    check(trajectory, robot, jerk_limited=settings.retime.jerk_limited)
    check_pen(trajectory, robot, pen_limits(trajectory, robot, settings.allowed))
    seconds["retime"] = time.perf_counter() - started
    return ArmPlan(robot, placed, path, q, trajectory, seconds)


@dataclass(frozen=True, eq=False)
class _Search:
    """Looks for a place of the sheet at which all of a path can be drawn."""

    robot: Robot
    arm: Inverse
    path: LiftedPath
    size_mm: tuple[float, float]
    settings: PlaceSettings

    def anywhere(self, reach: ReachMap) -> tuple[Placement, Floats]:
        """The place with the widest margins, and joint positions there.

        Raises:
            CannotDraw: there is none.
        """
        problem: CannotDraw | None = None
        for share in _SHARES:
            try:
                return self._fastest(places.candidates(self.size_mm, reach, share=share, apart_m=_APART_M))
            except CannotDraw as error:
                problem = problem or error
        width, height = self.size_mm
        raise CannotDraw(
            f"place: a sheet of {width:g} x {height:g} mm fits nowhere within reach of {self.robot.name};"
            " take a smaller page, let the pen lean more (place.swing_deg, place.lean_deg), or free the table's height"
        ) from problem

    def there(self, placed: Placement) -> tuple[Placement, Floats]:
        """A place that was asked for, and joint positions.

        Raises:
            CannotDraw: it cannot be drawn at: which part, why, and the nearest place that can.
        """
        try:
            return self._first([placed])
        except CannotDraw as error:
            raise CannotDraw(f"{error}{self._nearest(placed)}") from error

    def _fastest(self, tried: list[Placement]) -> tuple[Placement, Floats]:
        found: list[tuple[float, Placement, Floats]] = []
        # Arms without a closed form take too long to look around.
        wanted = self.settings.tries if self.arm.quick else 1
        problem: CannotDraw | None = None
        for placed in tried:
            if len(found) == wanted:
                break
            try:
                there, q = self._first([placed])
            except CannotDraw as error:
                problem = problem or error
                continue
            found.append((self._seconds(q), there, q))
        if not found:
            raise problem or CannotDraw("place: nowhere to try")
        _, there, q = min(found, key=lambda one: one[0])
        return there, q

    def clear(self, q: Floats, placed: Placement) -> bool:
        """Whether joint positions (n, dof) along the path, and the ways to and from the safe pose, touch nothing."""
        return self._collision(q, placed) is None

    def _seconds(self, q: Floats) -> float:
        """About how long it takes: each piece as if it asked as much of the joints everywhere as on average."""
        asked = (np.abs(np.diff(q, axis=0)) / self.robot.acceleration).max(1)
        drawing = sum(2 * np.sqrt(asked[a:b].sum()) for a, b in self.path.pieces())
        safe = self.robot.poses.get(SAFE)
        ways = 0.0 if safe is None else sum((np.abs(end - safe) / self.robot.velocity).max() for end in (q[0], q[-1]))
        return float(drawing + ways)

    def _first(self, tried: list[Placement]) -> tuple[Placement, Floats]:
        problem = CannotDraw("place: nowhere to try")
        for number, still in enumerate(tried):
            placed = still.swung(math.radians(self.settings.swing_deg), self.path.points_mm)
            touched: list[Collision] = []

            def clear(q: Floats, placed: Placement = placed, touched: list[Collision] = touched) -> bool:
                collision = self._collision(q, placed)
                touched += [collision] if collision else []
                return collision is None

            q, _ = self.arm.follow(placed.tips(self.path.points_mm), clear)
            if q is not None:
                return placed, q
            if number == 0:
                problem = self._problem(placed, touched)
        raise problem

    def _collision(self, q: Floats, placed: Placement) -> Collision | None:
        some = q[:: max(1, len(q) // 500)]
        # On the way from the safe pose and back nothing may be touched either.
        ways = [_between(self.robot.pose(SAFE), end) for end in (q[0], q[-1]) if SAFE in self.robot.poses]
        found = deepest(self.robot, np.concatenate([some, *ways]), placed.base_from_paper)
        return found or _pen_in_table(self.robot, ways, placed)

    def _problem(self, placed: Placement, touched: list[Collision]) -> CannotDraw:
        if touched:
            return CannotDraw(f"place: {touched[0].describe(self.robot)}; try another place, or auto")
        some = self.path.points_mm[:: max(1, len(self.path.points_mm) // 300)]
        return places.unreachable(self.arm, placed, some, self.size_mm)

    def _nearest(self, asked: Placement) -> str:
        """In words, the place nearest to the one asked for at which all of the path can be drawn."""
        middle = (self.size_mm[0] / 2, self.size_mm[1] / 2)
        reach = places.reach_map(self.robot, self.arm, self.settings.replace(at=places.AUTO))
        found = places.candidates(self.size_mm, reach, best=200)
        found.sort(key=lambda placed: float(np.linalg.norm(placed.points_m(middle) - asked.points_m(middle))))
        try:
            placed, _ = self._first(found[:12])
        except CannotDraw:
            return "; no place was found that can"
        x, y, z = placed.points_m(middle)
        turn = np.degrees(np.arctan2(placed.base_from_paper[1, 0], placed.base_from_paper[0, 0]))
        return f"; the nearest place found that can: {x:.3f},{y:.3f},{z:.3f},{turn:.0f}"


def _rates(t_s: Floats, values: Floats) -> Floats:
    """How fast (n - 1, dof) values change between samples."""
    rates: Floats = np.abs(np.diff(values, axis=0)) / np.diff(t_s)[:, None]
    return rates


def _pen_in_table(robot: Robot, ways: list[Floats], placed: Placement) -> Collision | None:
    """Where the pen dips into the table on ways that are not drawing, as an arm that turns its joints evenly does."""
    heights = [placed.points_mm(robot.forward(way)[:, :3, 3])[:, 2].min() for way in ways]
    lowest = min(heights, default=0.0)
    return Collision(0, robot.dof, -1, -lowest / 1000) if lowest < 0 else None


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
