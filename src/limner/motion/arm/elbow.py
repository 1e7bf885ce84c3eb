"""A path of pen poses goes in; one smooth motion of a seven-joint arm along it comes out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from limner.motion.arm.robot import SAFE, Robot
from limner.motion.arm.srs import BRANCHES, SphericalArm
from limner.settings import SettingsGroup, setting
from limner.types import Floats


@dataclass(frozen=True)
class ElbowSettings(SettingsGroup):
    """How the free turn of the elbow is chosen along a path."""

    angles: int = setting(72, "elbow angles that are tried at each pose", low=8, high=720)
    knot_mm: float = setting(
        15.0, "distance along the path between poses where it is chosen", unit="mm", low=1, high=200
    )
    margin_deg: float = setting(
        5.0, "joints keep this far from their limits where they can", unit="deg", low=0, high=60
    )
    margin_weight: float = setting(4.0, "price of being nearer to a limit than that, against moving", low=0, high=1000)
    slow_weight: float = setting(
        3.0, "price of a pose in which the pen gathers speed slowly, against moving", low=0, high=1000
    )
    way_weight: float = setting(
        5.0, "price of a second on the way from the safe pose, or back to it, against moving", low=0, high=1000
    )
    singular_weight: float = setting(0.3, "price of a straight elbow or wrist, against moving", low=0, high=1000)


def follow(
    robot: Robot, arm: SphericalArm, tips: Floats, settings: ElbowSettings, clear: Callable[[Floats], bool]
) -> tuple[Floats | None, NDArray[np.bool_]]:
    """Joint positions along a path, on one branch, with the elbow turned to where limits and singularities are far.

    A dynamic programme over elbow angle and branch at knots of the path finds the least motion (each joint's in units
    of its speed) plus the price of limits and singularities; between the knots the angle is interpolated smoothly and
    every pose is solved exactly.

    Args:
        robot: whose limits hold.
        arm: the same, in closed form.
        tips: (n, 4, 4) poses of the tip in the base frame.
        settings: see there.
        clear: whether joint positions (n, 7) may be taken, such as for touching nothing.

    Returns:
        (n, 7) joint positions, or None where no motion stays within the limits and is clear;
        (n,) whether each pose by itself can be reached within them.
    """
    angles = np.linspace(-np.pi, np.pi, settings.angles, endpoint=False)
    knots = _knots(tips, settings.knot_mm / 1000)
    q, reached = arm.solve(tips[knots, None], angles)
    slow = _slowness(robot, arm, tips, knots, angles, q)
    allowed = reached[..., None] & (robot.margin(q) >= 0).all(-1)
    reachable = np.interp(np.arange(len(tips)), knots, allowed.any((1, 2)).astype(float)) > 0.999
    price = np.where(allowed, _price(robot, q, settings) + settings.slow_weight * slow, np.inf)
    for end in (0, -1):
        price[end] += settings.way_weight * _from_safe_s(robot, q[end])
    for _ in BRANCHES:
        path = _cheapest(q, price, robot.velocity)
        if path is None:
            break
        chosen, branch = path
        smooth = np.unwrap(angles[chosen])
        for turn in (_smoothed(smooth), smooth):
            joints = _solved(robot, arm, tips, np.interp(np.arange(len(tips)), knots, turn), branch)
            if joints is not None and clear(joints):
                return joints, reachable
        price[..., branch] = np.inf
    return None, reachable


def _knots(tips: Floats, spacing_m: float) -> NDArray[np.int64]:
    steps = np.linalg.norm(np.diff(tips[:, :3, 3], axis=0), axis=1)
    along = np.concatenate([[0.0], np.cumsum(steps)])
    wanted = np.linspace(0, along[-1], int(np.ceil(along[-1] / spacing_m)) + 2)
    return np.unique(np.concatenate([[0, len(tips) - 1], np.searchsorted(along, wanted).clip(0, len(tips) - 1)]))


def _price(robot: Robot, q: Floats, settings: ElbowSettings) -> Floats:
    wanted = np.radians(settings.margin_deg)
    short = np.clip(1 - robot.margin(q) / max(wanted, 1e-9), 0, None) if wanted else np.zeros_like(q)
    bends = np.sin(q[..., [1, 3, 5]])
    singular = (0.05 / np.maximum(np.abs(bends), 0.01)) ** 2
    price: Floats = settings.margin_weight * (short**2).sum(-1) + settings.singular_weight * singular.sum(-1)
    return price


def _from_safe_s(robot: Robot, q: Floats) -> Floats | float:
    """Seconds (...) from the pose where drawing starts and ends to positions (..., dof), at full speed."""
    if SAFE not in robot.poses:
        return 0.0
    seconds: Floats = (np.abs(q - robot.pose(SAFE)) / robot.velocity).max(-1)
    return seconds


def _slowness(
    robot: Robot, arm: SphericalArm, tips: Floats, knots: NDArray[np.int64], angles: Floats, q: Floats
) -> Floats:
    """Time (knots, angles, branches) that a metre of the path takes from there, against one at 1 m/s^2.

    The path is bound by the joint that it asks the most of: a piece is as long as the root of that.
    """
    after = np.minimum(knots + 1, len(tips) - 1)
    step = np.maximum(np.linalg.norm(tips[after, :3, 3] - tips[knots, :3, 3], axis=-1), 1e-6)
    moved = np.abs(arm.solve(tips[after, None], angles)[0] - q)
    moved = np.minimum(moved, np.abs(2 * np.pi - moved))
    slow: Floats = np.sqrt((moved / robot.acceleration).max(-1) / step[:, None, None])
    return slow


def _cheapest(q: Floats, price: Floats, velocity: Floats) -> tuple[NDArray[np.int64], int] | None:
    """Elbow indices (n,) of the cheapest way through (n, angles, branches), and its branch; None where there is none.

    From knot to knot the elbow turns by at most one step either way.
    """
    n, angles, _ = price.shape
    unit = q / velocity
    total = price[0]
    came = np.zeros((n, *total.shape), np.int8)
    for i in range(1, n):
        options = []
        for step in (-1, 0, 1):
            moved = ((unit[i] - np.roll(unit[i - 1], step, axis=0)) ** 2).sum(-1)
            # A joint that jumps has gone round its limit: not the same motion.
            moved[np.abs(q[i] - np.roll(q[i - 1], step, axis=0)).max(-1) > 1.5] = np.inf
            options.append(np.roll(total, step, axis=0) + 20 * moved)
        stacked = np.stack(options)
        best = stacked.argmin(0)
        came[i] = best - 1
        total = np.take_along_axis(stacked, best[None], 0)[0] + price[i]
    if not np.isfinite(total).any():
        return None
    end, branch = np.unravel_index(int(total.argmin()), total.shape)
    chosen = np.empty(n, np.int64)
    chosen[-1] = end
    for i in range(n - 1, 0, -1):
        chosen[i - 1] = (chosen[i] - came[i, chosen[i], branch]) % angles
    return chosen, int(branch)


def _smoothed(turn: Floats, width: int = 9) -> Floats:
    """The elbow's angle without the steps of its grid, its ends where they were or nearly."""
    if len(turn) < 2:
        return turn
    window = np.hanning(width + 2)[1:-1]
    padded = np.pad(turn, width // 2, mode="edge")
    return np.convolve(padded, window / window.sum(), mode="valid")


def _solved(robot: Robot, arm: SphericalArm, tips: Floats, turn: Floats, branch: int) -> Floats | None:
    q, reached = arm.solve(tips, turn)
    joints = q[:, branch]
    if not reached.all() or (robot.margin(joints) < 0).any() or np.abs(np.diff(joints, axis=0)).max(initial=0) > 1.5:
        return None
    return joints
