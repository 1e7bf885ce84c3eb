"""The motion of an arm goes in; checked motions come out, one a stroke, each from rest in the air to rest there."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from limner.errors import CannotDraw, NothingToDraw
from limner.motion.arm.check import check
from limner.motion.arm.collide import deepest
from limner.motion.arm.lift import lift, raised
from limner.motion.arm.paper import plane_of
from limner.motion.arm.pen_check import Allowed, PenLimits, check_motion, check_pen
from limner.motion.arm.retime import RetimeSettings, joined, move
from limner.motion.arm.robot import Robot
from limner.motion.arm.spline import Moved, excess, hermite, peaks, subdivided
from limner.types import Floats, JointTrajectory

_REST = 1e-6
_CLEAR_M = 1e-3
_SHARE = 0.99
_OVER_M = 0.015
_HIGHER_M = (0.0, 0.06, 0.12, 0.18)


@dataclass(frozen=True, eq=False)
class Legs:
    """A motion that can be begun, stopped and gone on with at every stroke. Dots go along with the stroke after them.

    Attributes:
        robot: that draws.
        motion: all of it, checked.
        cuts: (strokes + 1,) samples at which the pen is up: before each stroke, and after the last.
        ends: (strokes, 2) samples at which the pen meets the paper and leaves it.
        up: (3,) normal of the sheet, in the base frame.
        settings: of the moves to strokes and back.
        limits: of the pen.
    """

    robot: Robot
    motion: JointTrajectory
    cuts: tuple[int, ...]
    ends: tuple[tuple[int, int], ...]
    up: Floats
    settings: RetimeSettings
    limits: PenLimits

    def stroke(self, index: int) -> JointTrajectory:
        """Down, along a stroke, and up: from rest at one cut to rest at the next.

        Raises:
            CannotDraw: a limit is exceeded.
        """
        touch, leave = self.ends[index]
        down = self._halted(self.cuts[index], touch, starting=True)
        up = self._halted(leave, self.cuts[index + 1], starting=False)
        part = self._checked(joined((down, _part(self.motion, touch, leave), up)))
        check_pen(part, self.robot, self.limits)
        return part

    def to_stroke(self, q: Floats, index: int) -> JointTrajectory:
        """From joint positions (dof,) to the pose that the motion begins with, high over its first stroke, to a stroke.

        Raises:
            CannotDraw: the arm would touch itself, or the pen come down on the way.
        """
        way = self.motion.q[[0, self.cuts[0], self.cuts[index]]]
        return self._led([q, *way], self.ends[index][0])

    def home(self, index: int) -> JointTrajectory:
        """From where a stroke begins (after the last: where it has ended), high over the last, to the motion's end.

        Raises:
            CannotDraw: the arm would touch itself, or the pen come down on the way.
        """
        way = self.motion.q[[self.cuts[index], self.cuts[-1], -1]]
        return self._led(list(way), self.ends[min(index, len(self.ends) - 1)][0])

    def lift(self, q: Floats) -> JointTrajectory:
        """From joint positions (dof,) at rest, straight up along the pen.

        Raises:
            CannotDraw: the arm cannot draw its pen back from there.
        """
        return lift(self.robot, q, self.settings)

    def tips(self, q: Floats) -> Floats:
        """(n, 3) where the pen's tip is [m], base frame."""
        return self.robot.forward(q)[:, :3, 3]

    def height(self, q: Floats) -> float:
        """How far [m] the tip at joint positions (dof,) is above where the pen is led on the paper."""
        return float(_heights(self.robot, q[None], self.motion.q[self.ends[0][0]], self.up)[0])

    def lines_mm(self) -> tuple[Floats, ...]:
        """What each stroke draws, seen along the z axis of the arm's base."""
        return tuple(1000 * self.tips(self.motion.q[a : b + 1])[:, :2] for a, b in self.ends)

    def seconds(self) -> Floats:
        """(strokes,) how long each takes."""
        return np.array([self.stroke(index).t_s[-1] for index in range(len(self.ends))])

    def _checked(self, part: JointTrajectory) -> JointTrajectory:
        check(part, self.robot)
        if collision := deepest(self.robot, part.q[:: max(1, len(part.q) // 200)]):
            raise CannotDraw(f"trajectory: {collision.describe(self.robot)}; bring the arm to another pose first")
        return part

    def _led(self, way: list[Floats], touch: int) -> JointTrajectory:
        """From one pose to the next, straight in joint space or by way of a place higher up.

        Everywhere at least half as high over the sheet as the ends, or as ``_OVER_M``.
        """
        ways = [self._way(a, b, touch) for a, b in itertools.pairwise(way) if (a != b).any()]
        return self._checked(joined([part for parts in ways for part in parts] or [_part(self.motion, 0, 0)]))

    def _way(self, a: Floats, b: Floats, touch: int) -> list[JointTrajectory]:
        ends = _heights(self.robot, np.array([a, b]), self.motion.q[touch], self.up)
        floor = min(_OVER_M, 0.5 * float(ends.min()))
        low = np.inf
        for higher in _HIGHER_M:
            via = raised(self.robot, (a, b)[int(ends.argmin())], higher) if higher else None
            if higher and via is None:
                continue
            stops = [a, b] if via is None else [a, via, b]
            parts = [move(self.robot, start, end, self.settings) for start, end in itertools.pairwise(stops)]
            low = min(_heights(self.robot, part.q, self.motion.q[touch], self.up).min() for part in parts)
            # An arm that waits below the sheet knows its way around it no better than we do.
            if floor <= 0 or low >= floor:
                return parts
        raise CannotDraw(
            f"trajectory: on its way to a stroke the pen would come down to {1000 * low:.0f} mm over the sheet;"
            " bring the arm to the pose that the motion begins with"
        )

    def _halted(self, a: int, b: int, *, starting: bool) -> JointTrajectory:
        """The way between two samples, at rest at both: the arm starts evenly from a cut, or slows down evenly to it.

        The way's own time s runs as ``S tau^2``, or backwards, over tau from 0 to 1, so slowly that limits are kept.
        """
        part = _part(self.motion, a, b)
        if a == b:
            return part
        seconds, tau = 2 * float(part.t_s[-1]), np.zeros(0)
        # What bends the way at a sample bends it there too; the first pass finds how slow, the second how finely.
        bends = np.unique(_share_of_time(part.t_s / part.t_s[-1], starting))
        for _ in range(2):
            tau = subdivided(bends, self.settings.sample_s / seconds)
            q, qd, qdd = _slowing(part, tau, starting)
            used = excess(peaks(tau, q, qd), _SHARE * self.robot.velocity, _SHARE * self.robot.acceleration)
            seconds = max(seconds, float(used.max()))
        none = np.zeros(len(tau), bool), np.full(len(tau), -1)
        return JointTrajectory(part.names, seconds * tau, q, qd / seconds, qdd / seconds**2, *none)


def legs(motion: JointTrajectory, robot: Robot, settings: RetimeSettings, allowed: Allowed | None = None) -> Legs:
    """Cut a motion where the pen is up between strokes.

    Args:
        motion: from any source.
        robot: that shall follow it.
        settings: of the moves to strokes and back.
        allowed: what its pen may do at most; None: as fast as the settings say, and pressed as usual.

    Raises:
        CannotDraw: the motion is not for this robot, or exceeds its limits.
        NothingToDraw: it has no strokes.
    """
    limits = check_motion(motion, robot, allowed or Allowed(settings.pen_speed))
    ends = _stroke_ends(motion)
    if not ends:
        raise NothingToDraw("trajectory: it draws no strokes")
    rests = np.abs(motion.qd).max(1) < _REST
    up = plane_of(robot.forward(motion.q[motion.down]))[0][:, 2]
    touch = ends[0][0]
    before = (_heights(robot, motion.q[:touch], motion.q[touch], up) > _CLEAR_M) & rests[:touch]
    cuts = [int(np.flatnonzero(before)[-1]) if before.any() else 0]
    for (_, leave), (touch, _) in itertools.pairwise(ends):
        heights = _heights(robot, motion.q[leave : touch + 1], motion.q[leave], up)
        cuts.append(leave + int(np.flatnonzero(heights >= 0.9 * heights.max())[0]))
    leave = ends[-1][1]
    after = (_heights(robot, motion.q[leave:], motion.q[leave], up) > _CLEAR_M) & rests[leave:]
    cuts.append(leave + int(np.flatnonzero(after)[0]) if after.any() else len(motion.t_s) - 1)
    return Legs(robot, motion, tuple(cuts), ends, up, settings, limits)


def _stroke_ends(motion: JointTrajectory) -> tuple[tuple[int, int], ...]:
    drawn = np.flatnonzero(motion.stroke >= 0)
    runs = np.split(drawn, np.flatnonzero(np.diff(motion.stroke[drawn]) != 0) + 1) if len(drawn) else []
    return tuple((max(int(run[0]) - 1, 0), int(run[-1])) for run in runs)


def _heights(robot: Robot, q: Floats, paper_q: Floats, up: Floats) -> Floats:
    """How far (n,) tips are above one on the paper."""
    heights: Floats = (robot.forward(q)[:, :3, 3] - robot.forward(paper_q)[:3, 3]) @ up
    return heights


def _part(motion: JointTrajectory, a: int, b: int) -> JointTrajectory:
    cut = slice(a, b + 1)
    return JointTrajectory(
        motion.names,
        motion.t_s[cut] - motion.t_s[a],
        motion.q[cut],
        motion.qd[cut],
        motion.qdd[cut],
        motion.down[cut],
        motion.stroke[cut],
        motion.press_mm,
    )


def _share_of_time(way: Floats, starting: bool) -> Floats:
    """When, from 0 to 1, an arm that starts or slows down evenly has done parts (n,) of its way."""
    return np.sqrt(way) if starting else 1 - np.sqrt(1 - way)


def _slowing(part: JointTrajectory, tau: Floats, starting: bool) -> Moved:
    """Positions, velocities and accelerations (n, dof) of a way at unit times (n,), with rest at a cut."""
    whole = float(part.t_s[-1])
    s, rate, bend = (tau**2, 2 * tau, 2.0) if starting else (2 * tau - tau**2, 2 - 2 * tau, -2.0)
    q, slope, curve = hermite(part, whole * s)
    return Moved(q, slope * (whole * rate)[:, None], curve * ((whole * rate) ** 2)[:, None] + slope * (whole * bend))
