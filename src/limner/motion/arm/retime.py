"""A path of joint positions goes in; the fastest motion along it within all limits comes out (TOPP-RA)."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from limner.errors import CannotDraw, MissingExtra
from limner.motion.arm.gentle import Law, gentle
from limner.motion.arm.lifted import LiftedPath
from limner.motion.arm.robot import Robot
from limner.motion.arm.spline import accelerations, excess, peaks, subdivided
from limner.settings import SettingsGroup, setting
from limner.types import Floats, JointTrajectory

_PARTINGS = 12
"""Times that the places where limits are exceeded are parted before the motion is slowed instead."""

_FINER = 4
"""Times as near each other as samples may be brought where limits are exceeded."""


@dataclass(frozen=True)
class RetimeSettings(SettingsGroup):
    """How fast the pen may go."""

    pen_speed: float = setting(100.0, "the pen's speed on the paper", unit="mm/s", low=0.1, high=5000)
    travel_speed: float = setting(250.0, "the pen's speed while lifted", unit="mm/s", low=0.1, high=5000)
    pen_acceleration: float = setting(1500.0, "the pen's acceleration along its path", unit="mm/s^2", low=1, high=1e5)
    margin: float = setting(0.01, "part of every limit that is not used", low=0, high=0.9)
    grid_per_mm: float = setting(5.0, "places per millimetre of path where limits are held", low=0.1, high=100)
    jerk_limited: bool = setting(False, "hold the joints' limits of jerk too: gentler to the arm, and slower")
    sample_s: float = setting(0.02, "time between samples of the result", unit="s", low=0.001, high=1)


def retime(robot: Robot, path: LiftedPath, q: Floats, settings: RetimeSettings) -> JointTrajectory:
    """Time-optimal motion through joint positions, at rest where the path says so.

    Each piece between two stops is a cubic spline over the length of the pen's way, timed by TOPP-RA (Pham & Pham
    2018, doi:10.1109/TRO.2018.2819195) on a fine grid with the interpolation scheme, under the joints' limits of
    velocity and acceleration; the length itself goes along as one more joint, whose limits are the pen's.

    Args:
        robot: whose limits hold.
        path: of the pen, n points.
        q: (n, dof) joint positions at them.
        settings: limits of the pen, margin and sampling.

    Raises:
        CannotDraw: a piece has no motion within the limits.
        MissingExtra: toppra is not installed.
    """
    steps = np.linalg.norm(np.diff(path.points_mm, axis=0), axis=1) / 1000
    length = np.concatenate([[0.0], np.cumsum(steps)])
    timer = _Timer(robot, settings)
    parts: list[tuple[Any, ...]] = []
    start = 0.0
    for a, b in path.pieces():
        drawing = bool(path.down[b])
        samples = timer.samples(length[a : b + 1] - length[a], q[a : b + 1], drawing)
        if samples is None:
            at = ", ".join(f"{value:.1f}" for value in path.points_mm[a])
            raise CannotDraw(
                f"plan: no motion within the limits of {robot.name} from ({at}) mm on the paper; lower the pen's speed"
            )
        t, *moved = samples
        keep = slice(1 if parts else 0, None)
        count = len(t[keep])
        parts.append(
            (start + t[keep], *(m[keep] for m in moved), np.full(count, drawing), np.full(count, path.stroke[b]))
        )
        start += float(t[-1])
    t_s, position, velocity, acceleration, down, stroke = (
        np.concatenate(columns) for columns in zip(*parts, strict=True)
    )
    return JointTrajectory(robot.joints, t_s, position, velocity, acceleration, down, stroke)


def move(robot: Robot, start: Floats, end: Floats, settings: RetimeSettings) -> JointTrajectory:
    """The fastest motion straight in joint space between two joint positions (dof,), all joints together, pen up."""
    way = end - start
    law, turns = _trapezoid(robot, way, settings)
    if settings.jerk_limited:
        share = 1 - settings.margin
        limits = (robot.velocity, robot.acceleration, share * robot.jerk)
        t, moved = gentle(
            law, float(turns[-1]), lambda s, order: (s, np.ones_like(s), np.zeros_like(s))[order][:, None] * way, limits
        )
        t, (part, rate, change) = _sampled(t, moved, settings.sample_s, limits[:2])
    else:
        t = subdivided(turns, settings.sample_s)
        part, rate, change = (values[:, None] * way for values in law(t))
    none = np.zeros(len(t), bool), np.full(len(t), -1)
    return JointTrajectory(robot.joints, t, start + part, rate, change, *none)


def _sampled(t: Floats, moved: Floats, sample_s: float, limits: tuple[Floats, Floats]) -> tuple[Floats, Floats]:
    """Every so many of the finely spaced samples of a motion, its end with them; slowed where cubics need that."""
    stretch, kept = 1.0, np.zeros(0, np.int64)
    # The first pass finds how slow, the second how finely.
    for _ in range(2):
        count = max(3, int(np.ceil(stretch * t[-1] / sample_s)) + 1)
        kept = np.rint(np.linspace(0, len(t) - 1, count)).astype(np.int64)
        stretch = max(stretch, float(excess(peaks(t[kept], *moved[:2, kept]), *limits).max()))
    return stretch * t[kept], moved[:, kept] / stretch ** np.arange(3.0)[:, None, None]


def _trapezoid(robot: Robot, way: Floats, settings: RetimeSettings) -> tuple[Law, Floats]:
    """Part of a straight way, its rate and change over time; the times from 0 to the end where the change jumps."""
    share = 1 - settings.margin
    size = np.maximum(np.abs(way), 1e-9)
    speed, acceleration = (float((share * limit / size).min()) for limit in (robot.velocity, robot.acceleration))
    # A trapezoid of speed over the part of the way, 0 to 1; a triangle where full speed is not reached.
    speed = min(speed, acceleration**0.5)
    ramp = speed / acceleration
    total = ramp + 1 / speed
    level = [ramp, total - ramp] if total - 2 * ramp > 1e-6 else [total / 2]

    def law(t: Floats) -> Floats:
        t = np.clip(t, 0, total)
        rate = np.minimum(speed, acceleration * np.minimum(t, total - t))
        early, late = t < ramp, t > total - ramp
        rest = 1 - acceleration * (total - t) ** 2 / 2
        part = np.where(early, acceleration * t**2 / 2, np.where(late, rest, speed * (t - ramp / 2)))
        change = np.where(early, acceleration, np.where(late, -acceleration, 0.0))
        change[(t <= 0) | (t >= total)] = 0
        return np.stack([part, rate, change])

    return law, np.array([0.0, *level, total])


def joined(parts: Sequence[JointTrajectory]) -> JointTrajectory:
    """One motion after the other; each starts at rest where the one before it came to rest."""
    starts = np.cumsum([0.0, *(part.t_s[-1] for part in parts)])
    t_s = [start + part.t_s for start, part in zip(starts[:-1], parts, strict=True)]
    keep = [slice(1 if i else 0, None) for i in range(len(parts))]
    fields: dict[str, Any] = {
        name: np.concatenate([getattr(part, name)[k] for part, k in zip(parts, keep, strict=True)])
        for name in ("q", "qd", "qdd", "down", "stroke")
    }
    times = np.concatenate([t[k] for t, k in zip(t_s, keep, strict=True)])
    return JointTrajectory(parts[0].names, times, **fields, press_mm=max(part.press_mm for part in parts))


class _Timer:
    """toppra with the limits of one robot and pen."""

    def __init__(self, robot: Robot, settings: RetimeSettings) -> None:
        try:
            import toppra
            import toppra.algorithm
            import toppra.constraint
        except ImportError as error:
            raise MissingExtra(f"timing the motion of {robot.name}", "robot") from error
        logging.getLogger("toppra").setLevel(logging.CRITICAL)
        self.toppra: Any = toppra
        self.settings, self.dof, self.jerk = settings, robot.dof, robot.jerk
        self.limits = {down: self._limits(robot, down) for down in (True, False)}
        self.constraints = {down: self._constraints(*self.limits[down]) for down in (True, False)}

    def _limits(self, robot: Robot, down: bool) -> tuple[Floats, Floats]:
        """Velocities and accelerations of the joints and of the pen along its path."""
        speed = (self.settings.pen_speed if down else self.settings.travel_speed) / 1000
        share = 1 - self.settings.margin
        velocity = share * np.append(robot.velocity, speed)
        return velocity, share * np.append(robot.acceleration, self.settings.pen_acceleration / 1000)

    def _constraints(self, velocity: Floats, acceleration: Floats) -> list[Any]:
        constraint = self.toppra.constraint
        both = np.array([-1.0, 1.0])
        return [
            constraint.JointVelocityConstraint(velocity[:, None] * both),
            constraint.JointAccelerationConstraint(
                acceleration[:, None] * both, discretization_scheme=constraint.DiscretizationType.Interpolation
            ),
        ]

    def samples(self, length_m: Floats, q: Floats, drawing: bool) -> tuple[Floats, ...] | None:
        """Times, positions, velocities and accelerations of one piece; None where there is no motion."""
        toppra, settings = self.toppra, self.settings
        way = toppra.SplineInterpolator(
            length_m, np.column_stack([q, length_m]), "natural" if len(q) > 2 else "not-a-knot"
        )
        count = max(20, int(np.ceil(1000 * length_m[-1] * settings.grid_per_mm)))
        grid = np.linspace(0, length_m[-1], count + 1)
        instance = toppra.algorithm.TOPPRA(
            self.constraints[drawing], way, gridpoints=grid, parametrizer="ParametrizeConstAccel"
        )
        motion = instance.compute_trajectory(0, 0)
        if motion is None:
            return None
        if settings.jerk_limited:
            return self._gentle(motion, way, drawing)
        return self._parted(motion, subdivided(_times(instance.problem_data), settings.sample_s / _FINER), drawing)

    def _parted(self, motion: Any, grid_s: Floats, drawing: bool) -> tuple[Floats, ...]:
        """A motion at some of the times between which its path is gone along evenly, slowed where that is needed.

        A cubic goes wrong where the acceleration jumps within it; so where limits are exceeded it is parted at the
        largest jump there, unless the motion is slowed as much anyway.
        """
        q, qd = (np.asarray(motion(grid_s, order)) for order in (0, 1))
        jumps, kept = _jumps(grid_s, qd[:, -1]), _thinned(grid_s, self.settings.sample_s)

        def used(at: NDArray[np.int64]) -> Floats:
            return excess(peaks(grid_s[at], q[at], qd[at]), *self.limits[drawing])

        least = max(1.0, float(used(np.arange(len(grid_s))).max()))
        for _ in range(_PARTINGS):
            bad = np.flatnonzero((used(kept) > least) & (np.diff(kept) > 1))
            if not len(bad):
                break
            parted = [a + 1 + int(jumps[a + 1 : b].argmax()) for a, b in zip(kept[bad], kept[bad + 1], strict=True)]
            kept = np.sort(np.append(kept, parted))
        stretch = max(1.0, float(used(kept).max()))
        # What is slowed has its samples farther apart; more of them may need to be slower yet.
        while len(
            far := np.flatnonzero((stretch * np.diff(grid_s[kept]) > self.settings.sample_s) & (np.diff(kept) > 1))
        ):
            middle = np.searchsorted(grid_s, (grid_s[kept[far]] + grid_s[kept[far + 1]]) / 2)
            kept = np.unique(np.append(kept, np.clip(middle, kept[far] + 1, kept[far + 1] - 1)))
            stretch = max(stretch, float(used(kept).max()))
        t, q, qd = stretch * grid_s[kept], q[kept, : self.dof], qd[kept, : self.dof] / stretch
        return t, q, qd, accelerations(t, q, qd)

    def _gentle(self, motion: Any, way: Any, drawing: bool) -> tuple[Floats, ...]:
        def law(t: Floats) -> Floats:
            inside = (t > 0) & (t < motion.duration)
            values = [np.asarray(motion(np.clip(t, 0, motion.duration), order))[:, self.dof] for order in range(3)]
            return np.stack([values[0], values[1] * inside, values[2] * inside])

        velocity, acceleration = self.limits[drawing]
        jerk = np.append((1 - self.settings.margin) * self.jerk, np.inf)
        t, moved = gentle(law, float(motion.duration), way, (velocity, acceleration, jerk))
        t, moved = _sampled(t, moved, self.settings.sample_s, (velocity, acceleration))
        return t, *moved[..., : self.dof]


def _times(found: Any) -> Floats:
    """When a motion is at each place of the grid; between two of them it speeds up evenly."""
    speed = found.sd_vec
    times: Floats = np.concatenate([[0.0], np.cumsum(2 * np.diff(found.gridpoints) / (speed[:-1] + speed[1:]))])
    return times


def _jumps(grid_s: Floats, speed: Floats) -> Floats:
    """How much the acceleration along the path jumps at each place of the grid."""
    return np.abs(np.diff(np.diff(speed) / np.diff(grid_s), prepend=0.0, append=0.0))


def _thinned(times: Floats, longest: float) -> NDArray[np.int64]:
    """Indices of as few times as are no farther apart than that, where they can be."""
    kept, last = [0], len(times) - 1
    while kept[-1] < last:
        farthest = int(np.searchsorted(times, times[kept[-1]] + longest, side="right")) - 1
        kept.append(max(farthest, kept[-1] + 1))
    return np.array(kept)
