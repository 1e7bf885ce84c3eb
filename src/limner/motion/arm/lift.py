"""Joint positions of an arm that was stopped anywhere go in; the checked motion that draws its pen back comes out."""

from __future__ import annotations

import itertools

import numpy as np

from limner.errors import CannotDraw
from limner.motion.arm.check import check
from limner.motion.arm.collide import deepest
from limner.motion.arm.retime import RetimeSettings, joined, move
from limner.motion.arm.robot import Robot
from limner.types import Floats, JointTrajectory

HEIGHTS_M = (0.004, 0.012, 0.03, 0.06)
"""Where the pen passes on its way: so near each other that a move straight in joint space is straight for the tip."""

_ASIDE = 0.1
"""How far aside the tip may go, as part of the way."""

_NEAR_M = 1e-4


def lift(robot: Robot, q: Floats, settings: RetimeSettings) -> JointTrajectory:
    """Draw the pen back along its own axis by 60 mm, or as far as the arm reaches.

    Args:
        robot: that was stopped, at rest.
        q: (dof,) where it is.
        settings: of the moves.

    Raises:
        CannotDraw: not even the first millimetres can be reached within the limits, or the arm would touch itself.
    """
    start = robot.forward(q)
    way = [q]
    for height in HEIGHTS_M:
        there = raised(robot, q, height, way[-1])
        if there is None:
            break
        way.append(there)
    if len(way) == 1:
        raise CannotDraw(f"lift: {robot.name} cannot draw its pen back from here; raise it by hand")
    motion = joined([move(robot, a, b, settings) for a, b in itertools.pairwise(way)])
    check(motion, robot)
    if collision := deepest(robot, motion.q[:: max(1, len(motion.q) // 100)]):
        raise CannotDraw(f"lift: {collision.describe(robot)}; raise the pen by hand")
    _check_straight(robot, motion, start)
    return motion


def raised(robot: Robot, q: Floats, height_m: float, near: Floats | None = None) -> Floats | None:
    """Joint positions (dof,) whose tip is drawn back along the pen from q's, near q or others; None out of reach."""
    target = robot.forward(q).copy()
    target[:3, 3] -= height_m * target[:3, 2]
    return _reached(robot, q if near is None else near, target)


def _reached(robot: Robot, q: Floats, target: Floats) -> Floats | None:
    """Joint positions near q whose tip is at the target, by damped least squares; None where there are none."""
    for _ in range(30):
        error = _error(robot.forward(q), target)
        jacobian = robot.jacobian(q)
        step = jacobian.T @ np.linalg.solve(jacobian @ jacobian.T + 1e-6 * np.eye(6), error)
        q = np.clip(q + step, robot.lower, robot.upper)
        if np.abs(_error(robot.forward(q), target)).max() < _NEAR_M:
            return q
    return None


def _error(frame: Floats, target: Floats) -> Floats:
    """Way (3) and turn (3) that are missing from a frame to the target, for small turns."""
    turn = 0.5 * np.cross(frame[:3, :3].T, target[:3, :3].T).sum(0)
    return np.concatenate([target[:3, 3] - frame[:3, 3], turn])


def _check_straight(robot: Robot, motion: JointTrajectory, start: Floats) -> None:
    """The tip must rise all the time and leave no trail beside where it stood."""
    way = robot.forward(motion.q)[:, :3, 3] - start[:3, 3]
    height = -way @ start[:3, 2]
    aside = np.linalg.norm(way + height[:, None] * start[:3, 2], axis=1)
    if (np.diff(height) < -_NEAR_M).any() or (aside > _ASIDE * height + _NEAR_M).any():
        raise CannotDraw(f"lift: {robot.name} cannot draw its pen back straight from here; raise it by hand")
