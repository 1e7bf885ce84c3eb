"""A motion and its faults go in; what the servos are told at each step of the simulation comes out."""

from __future__ import annotations

import numpy as np

from limner.motion.arm.robot import Robot
from limner.motion.arm.spline import hermite
from limner.simulation.settings import SimulationSettings
from limner.types import Floats, JointTrajectory

_REST = 1e-4
"""rad/s; slower than this the arm is at rest."""


def commands(
    trajectory: JointTrajectory, robot: Robot, settings: SimulationSettings, t_s: Floats
) -> tuple[Floats, Floats]:
    """Positions and velocities (steps, dof) that the servos are told at times (steps,).

    Commands of position and velocity come at an even rate, or late; until the next one the servo goes on at the
    velocity of the last.
    """
    fault = settings.fault
    sent = np.arange(0.0, trajectory.t_s[-1] + 1 / settings.command_hz, 1 / settings.command_hz)
    q, qd, _ = hermite(trajectory, sent)
    q = q + _misses(trajectory, robot, settings, sent, q)
    late = np.random.default_rng([fault.seed, 1]).uniform(0, fault.jitter_ms / 1000, len(sent))
    late[0] = 0.0
    arrived = np.maximum.accumulate(sent + late)
    last = np.clip(np.searchsorted(arrived, t_s, side="right") - 1, 0, None)
    ahead = np.minimum(t_s - arrived[last], 2 / settings.command_hz)
    told = q[last] + qd[last] * ahead[:, None]
    return told, qd[last] if settings.feed_forward else np.zeros_like(told)


def _misses(trajectory: JointTrajectory, robot: Robot, settings: SimulationSettings, t_s: Floats, q: Floats) -> Floats:
    """Errors of the joints (m, dof) at positions q: the tip misses each rest otherwise, and between them evenly."""
    if not settings.fault.repeat_mm:
        return np.zeros_like(q)
    slow = np.abs(trajectory.qd).max(1) < _REST
    rests = np.flatnonzero(slow & ~np.r_[False, slow[:-1]])
    rng = np.random.default_rng([settings.fault.seed, 2])
    direction = rng.normal(size=(len(rests), 3))
    radius = settings.fault.repeat_mm / 1000 * rng.uniform(size=(len(rests), 1)) ** (1 / 3)
    off = radius * direction / np.linalg.norm(direction, axis=1, keepdims=True)
    move = np.stack([np.interp(t_s, trajectory.t_s[rests], column) for column in off.T], axis=1)
    # Of the place alone: an arm that misses by a millimetre turns its pen by next to nothing.
    jacobian = robot.jacobian(q)[:, :3]
    back = np.swapaxes(jacobian, -1, -2)
    joints: Floats = (back @ np.linalg.solve(jacobian @ back + 1e-6 * np.eye(3), move[..., None]))[..., 0]
    return joints
