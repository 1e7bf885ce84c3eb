"""Positions and velocities at some times go in; what a controller makes of them in between comes out, as cubics."""

from __future__ import annotations

import itertools
from typing import NamedTuple

import numpy as np

from limner.types import Floats, JointTrajectory

_EXTREME = 1e-12


class Moved(NamedTuple):
    """Position, velocity and acceleration (n, dof) at some times."""

    q: Floats
    qd: Floats
    qdd: Floats


def hermite(motion: JointTrajectory, t_s: Floats) -> Moved:
    """Where a motion is at times (n,), by cubics through its positions and velocities; held before and after it."""
    times = np.clip(t_s, motion.t_s[0], motion.t_s[-1])
    i = np.clip(np.searchsorted(motion.t_s, times, side="right") - 1, 0, max(0, len(motion.t_s) - 2))
    j = np.minimum(i + 1, len(motion.t_s) - 1)
    step = np.maximum(motion.t_s[j] - motion.t_s[i], 1e-12)[:, None]
    u = np.clip((times - motion.t_s[i])[:, None] / step, 0, 1)
    start, v0, c2, c3 = _cubics(step, motion.q[i], motion.q[j], motion.qd[i], motion.qd[j])
    return Moved(
        start + u * (v0 + u * (c2 + u * c3)),
        (v0 + u * (2 * c2 + 3 * u * c3)) / step,
        (2 * c2 + 6 * u * c3) / step**2,
    )


def peaks(t_s: Floats, q: Floats, qd: Floats) -> tuple[Floats, Floats]:
    """The largest velocity and acceleration (n - 1, dof) of the cubics between samples.

    Controllers of ROS that are given positions and velocities go along just these (ros_control and ros2_control,
    joint_trajectory_controller). Where values change in no time both are infinite.
    """
    step = np.diff(t_s)[:, None]
    still = (step <= 0) & (q[1:] == q[:-1]) & (qd[1:] == qd[:-1])
    with np.errstate(divide="ignore", invalid="ignore"):
        _, v0, c2, c3 = _cubics(step, q[:-1], q[1:], qd[:-1], qd[1:])
        turn = np.clip(-c2 / np.where(np.abs(c3) < _EXTREME, _EXTREME, 3 * c3), 0, 1)
        rates = [v0, v0 + 2 * c2 + 3 * c3, v0 + turn * (2 * c2 + 3 * turn * c3)]
        velocity = np.max(np.abs(rates), axis=0) / step
        acceleration = np.maximum(np.abs(2 * c2), np.abs(2 * c2 + 6 * c3)) / step**2
    jump = (step <= 0) & ~still
    found = (np.where(still, 0.0, np.where(jump, np.inf, values)) for values in (velocity, acceleration))
    return next(found), next(found)


def accelerations(t_s: Floats, q: Floats, qd: Floats) -> Floats:
    """(n, dof) with which the cubics leave each sample; at the last, with which they come to it."""
    step = np.diff(t_s)[:, None]
    _, _, c2, c3 = _cubics(step, q[:-1], q[1:], qd[:-1], qd[1:])
    ends = np.concatenate([2 * c2, (2 * c2 + 6 * c3)[-1:]])
    return np.asarray(ends / np.concatenate([step, step[-1:]]) ** 2)


def excess(peaks: tuple[Floats, Floats], velocity: Floats, acceleration: Floats) -> Floats:
    """(n - 1,) by how much time must be stretched between samples so that limits (dof,) just hold."""
    stretch: Floats = np.maximum((peaks[0] / velocity).max(1), np.sqrt((peaks[1] / acceleration).max(1)))
    return stretch


def subdivided(times: Floats, longest: float) -> Floats:
    """Times with more between them, evenly, so that none are farther apart."""
    counts = np.maximum(1, np.ceil(np.diff(times) / longest - 1e-9)).astype(int)
    parts = [np.linspace(a, b, n + 1)[:-1] for (a, b), n in zip(itertools.pairwise(times), counts, strict=True)]
    return np.concatenate([*parts, times[-1:]])


def _cubics(step: Floats, q0: Floats, q1: Floats, v0: Floats, v1: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Coefficients of cubics over unit time."""
    way, start, end = q1 - q0, step * v0, step * v1
    return q0, start, 3 * way - 2 * start - end, start + end - 2 * way
