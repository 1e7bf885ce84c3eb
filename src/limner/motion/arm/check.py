"""A joint trajectory and a robot go in; an error comes out where any limit is exceeded: nothing moves unchecked."""

from __future__ import annotations

import numpy as np

from limner.errors import CannotDraw
from limner.motion.arm.robot import Robot
from limner.motion.arm.spline import peaks
from limner.types import Floats, JointTrajectory

TOLERANCE = 0.01
"""Part of a limit by which a sample may exceed it."""


def check(
    trajectory: JointTrajectory, robot: Robot, tolerance: float = TOLERANCE, *, jerk_limited: bool = False
) -> None:
    """Refuse a motion that exceeds a limit of position, velocity or acceleration at any sample, or between samples.

    Positions are compared with velocities, and velocities with accelerations, by their differences too, so that a
    file whose positions alone were altered is found. Between samples holds what a controller makes of them: cubics
    through positions and velocities.

    Args:
        trajectory: the motion.
        robot: whose limits hold.
        tolerance: see ``TOLERANCE``.
        jerk_limited: whether accelerations may change no faster than the limits of jerk allow.

    Raises:
        CannotDraw: the joints are others, or a limit is exceeded: which joint, when, by how much.
    """
    if trajectory.names != robot.joints:
        raise CannotDraw(
            f"trajectory: for the joints {', '.join(trajectory.names)};"
            f" robot {robot.name} has {', '.join(robot.joints)}; name the one that it was planned for (--robot)"
        )
    _check_positions(trajectory, robot, tolerance)
    for name, values, limit in (
        ("velocity", trajectory.qd, robot.velocity),
        ("acceleration", trajectory.qdd, robot.acceleration),
        ("velocity", _slopes(trajectory.t_s, trajectory.q), robot.velocity),
    ):
        _check(name, values, limit, trajectory, robot, tolerance)
    _check_jumps(trajectory, robot, tolerance)
    _check_ways(trajectory, robot)
    _check_between(trajectory, robot, tolerance)
    if jerk_limited:
        _check("jerk", _slopes(trajectory.t_s, trajectory.qdd), robot.jerk, trajectory, robot, tolerance)


def _slopes(t_s: Floats, values: Floats) -> Floats:
    """Mean rate of change between samples; infinite where a value changes in no time."""
    step = np.diff(t_s)[:, None]
    change = np.diff(values, axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = np.where(change == 0, 0.0, change / step)
    return np.concatenate([slope, np.zeros((1, values.shape[1]))])


def _check_positions(trajectory: JointTrajectory, robot: Robot, tolerance: float) -> None:
    beyond = -robot.margin(trajectory.q)
    if (beyond > tolerance * (robot.upper - robot.lower)).any():
        sample, joint = np.unravel_index(int(beyond.argmax()), beyond.shape)
        raise CannotDraw(
            f"trajectory: joint {robot.joints[joint]} goes to {trajectory.q[sample, joint]:.3f} at"
            f" {trajectory.t_s[sample]:.2f} s; its limits are {robot.lower[joint]:.3f} to {robot.upper[joint]:.3f}"
        )


def _check(
    name: str, values: Floats, limit: Floats, trajectory: JointTrajectory, robot: Robot, tolerance: float
) -> None:
    ratio = np.abs(values) / limit
    if not (ratio <= 1 + tolerance).all():
        article = "an" if name.startswith("a") else "a"
        sample, joint = np.unravel_index(int(np.nan_to_num(ratio, nan=np.inf).argmax()), ratio.shape)
        raise CannotDraw(
            f"trajectory: joint {robot.joints[joint]} has {article} {name} of {abs(values[sample, joint]):.3g} at"
            f" {trajectory.t_s[sample]:.2f} s, {100 * (ratio[sample, joint] - 1):.0f} % over its limit"
            f" of {limit[joint]:.3g}"
        )


def _check_between(trajectory: JointTrajectory, robot: Robot, tolerance: float) -> None:
    """Cubics between samples must keep to the limits as the samples do."""
    found = peaks(trajectory.t_s, trajectory.q, trajectory.qd)
    for name, values, limit in zip(
        ("velocity", "acceleration"), found, (robot.velocity, robot.acceleration), strict=True
    ):
        _check(f"{name} between samples", values, limit, trajectory, robot, tolerance)


def _check_jumps(trajectory: JointTrajectory, robot: Robot, tolerance: float) -> None:
    """Velocities must follow from accelerations within their limits."""
    step = np.diff(trajectory.t_s)[:, None]
    possible = robot.acceleration * step * (1 + tolerance) + 1e-9
    change = np.abs(np.diff(trajectory.qd, axis=0))
    if (change > possible).any():
        sample, joint = np.unravel_index(int((change - possible).argmax()), change.shape)
        raise CannotDraw(
            f"trajectory: the velocity of joint {robot.joints[joint]} jumps by {change[sample, joint]:.3g} at"
            f" {trajectory.t_s[sample]:.2f} s, faster than its acceleration limit"
            f" of {robot.acceleration[joint]:.3g} allows"
        )


def _check_ways(trajectory: JointTrajectory, robot: Robot) -> None:
    """Positions must follow from velocities.

    Under a limit of acceleration the way between two samples differs from the mean of their velocities, times the time
    between them, by at most a quarter of the acceleration times the square of the time; twice that is let pass.
    """
    step = np.diff(trajectory.t_s)[:, None]
    possible = robot.acceleration * step**2 / 2 + 1e-6
    mean = (trajectory.qd[1:] + trajectory.qd[:-1]) / 2
    off = np.abs(np.diff(trajectory.q, axis=0) - mean * step)
    if (off > possible).any():
        sample, joint = np.unravel_index(int((off - possible).argmax()), off.shape)
        raise CannotDraw(
            f"trajectory: joint {robot.joints[joint]} moves by {off[sample, joint]:.3g} at"
            f" {trajectory.t_s[sample]:.2f} s against its own velocities; the motion was altered"
        )
