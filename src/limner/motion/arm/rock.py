"""Joint positions along a pen's way go in; the same with a hand that rocks as the pen rises, thus faster, come out.

A lifted pen may lean a little: then all joints share in lifting it, where otherwise one does most of it.
"""

from __future__ import annotations

import numpy as np

from limner.motion.arm.lifted import LiftedPath
from limner.motion.arm.robot import Robot
from limner.types import Floats

_FULL_MM = 20.0
"""The hand rocks evenly with a height well below this, and hardly more above it."""

_ROUNDS = 60
_LEAST_WEIGHT = 1e-6


def rocked(robot: Robot, path: LiftedPath, q: Floats, up: Floats) -> Floats:
    """Turn the joints besides, in proportion to the pen's height over its way on the paper; its tip goes where it went.

    Args:
        robot: that moves.
        path: of the pen, n points.
        q: (n, dof) joint positions at them.
        up: (3,) out of the sheet, base frame.

    Returns:
        (n, dof) joint positions; those given where others would leave the joints' limits.
    """
    height = path.points_mm[:, 2] - path.points_mm[:, 2].min()
    share = _FULL_MM * np.tanh(height / _FULL_MM) / 1000
    tips = robot.forward(q)[:, :3, 3]
    moved = q + share[:, None] * _besides(robot, path, q, up)
    for _ in range(3):
        moved = _led(robot, moved, tips)
    return moved if (robot.margin(moved) >= 0).all() else q


def _besides(robot: Robot, path: LiftedPath, q: Floats, up: Floats) -> Floats:
    """(dof,) what the joints turn besides for each metre, so that a pen amid the drawing rises fastest."""
    ends = np.flatnonzero(path.down[:-1] & ~path.down[1:])
    away = np.linalg.norm(path.points_mm[ends] - path.points_mm[ends].mean(0), axis=1)
    middle = ends[int(away.argmin())]
    rise = (path.points_mm[middle + 1, 2] - path.points_mm[middle, 2]) / 1000
    limits = robot.acceleration
    fastest = limits * _evenest(robot.jacobian(q[middle])[:3] * limits, up)
    besides: Floats = fastest - (q[middle + 1] - q[middle]) / rise
    return besides


def _evenest(matrix: Floats, goal: Floats) -> Floats:
    """(k,) the x with matrix @ x = goal whose largest number is about the least possible (Lawson 1961, reweighting)."""
    weight = np.ones(matrix.shape[1])
    best = _least(matrix, goal, weight)
    for _ in range(_ROUNDS):
        found = _least(matrix, goal, weight)
        best = min(best, found, key=lambda x: float(np.abs(x).max()))
        weight = np.maximum(weight * np.abs(found) / np.abs(found).max(), _LEAST_WEIGHT)
    return best


def _least(matrix: Floats, goal: Floats, weight: Floats) -> Floats:
    """The x with matrix @ x = goal and the least weighted sum of squares."""
    spread = matrix / weight
    x: Floats = spread.T @ np.linalg.solve(spread @ matrix.T, goal)
    return x


def _led(robot: Robot, q: Floats, tips: Floats) -> Floats:
    """Joint positions nearest to some (n, dof) whose tips are at (n, 3), to first order."""
    jacobian = robot.jacobian(q)[:, :3]
    back = np.swapaxes(jacobian, -1, -2)
    off = tips - robot.forward(q)[:, :3, 3]
    return np.asarray(q + (back @ np.linalg.solve(jacobian @ back, off[..., None]))[..., 0])
