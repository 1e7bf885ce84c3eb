"""A path of pen poses goes in; joint positions of any arm along it come out, by damped least squares (pinocchio)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from limner.errors import MissingExtra
from limner.motion.arm.robot import Robot
from limner.settings import SettingsGroup, setting
from limner.types import Floats

COARSE = 8
"""Of so many poses one is used to compare where a path may start."""


@dataclass(frozen=True)
class NumericSettings(SettingsGroup):
    """The iteration for arms without a closed form."""

    tolerance_m: float = setting(1e-7, "pose error at which it stops", unit="m and rad", low=1e-12, high=1e-3)
    iterations: int = setting(60, "steps at most at each pose", low=1, high=10_000)
    starts: int = setting(24, "joint positions tried at the first pose", low=1, high=1000)
    seed: int = setting(0, "of the positions tried first", low=0)


def follow(
    robot: Robot, tips: Floats, settings: NumericSettings, clear: Callable[[Floats], bool]
) -> tuple[Floats | None, NDArray[np.bool_]]:
    """Joint positions along a path, each pose started from the one before, so that no joint jumps.

    Several solutions of the first pose are followed in turn; of those that reach every pose, the one that stays
    farthest from limits and singularities is taken.

    Args:
        robot: whose limits hold.
        tips: (n, 4, 4) poses of the tip in the base frame.
        settings: see there.
        clear: whether joint positions (n, dof) may be taken, such as for touching nothing.

    Returns:
        (n, dof) joint positions, or None where no motion stays within the limits and is clear;
        (n,) whether each pose was reached in the best attempt.

    Raises:
        MissingExtra: pinocchio is not installed.
    """
    solver = PinocchioArm(robot, settings)
    # Every few poses tell which start goes best, at a fraction of the price.
    coarse = np.unique(np.append(np.arange(0, len(tips), COARSE), len(tips) - 1))
    ways = [solver.track(tips[coarse], start) for start in solver.starts(tips[0])]
    ways.sort(key=lambda way: -quality(robot, way[0]) if way[1].all() else np.inf)
    reached = np.zeros(len(tips), bool)
    for way, ok in ways:
        fully = ok.all()
        path, ok = solver.track(tips, way[0]) if fully else (way, np.interp(np.arange(len(tips)), coarse, ok) > 0.999)
        if fully and ok.all() and clear(path):
            return path, ok
        reached = max(reached, ok, key=lambda seen: seen.sum())
    return None, reached


def quality(robot: Robot, q: Floats) -> float:
    """How far joint positions (n, dof) stay from limits [rad] and singularities, at their worst."""
    nearest = robot.margin(q).min()
    sampled = robot.jacobian(q[:: max(1, len(q) // 50)])
    smallest = np.linalg.svd(sampled, compute_uv=False)[..., -1].min()
    return float(min(nearest, 5 * smallest) - 0.02 * np.abs(np.diff(q, axis=0)).sum(0).max(initial=0))


class PinocchioArm:
    """A chain as pinocchio's model."""

    def __init__(self, robot: Robot, settings: NumericSettings) -> None:
        try:
            import pinocchio
        except ImportError as error:
            raise MissingExtra(f"inverse kinematics of {robot.name}", "robot") from error
        self.pin: Any = pinocchio
        self.robot, self.settings = robot, settings
        self.model = pinocchio.Model()
        parent = 0
        for i, name in enumerate(robot.joints):
            kinds = (pinocchio.JointModelRevoluteUnaligned, pinocchio.JointModelPrismaticUnaligned)
            joint = kinds[int(robot.prismatic[i])](robot.axes[i].copy())
            parent = self.model.addJoint(parent, joint, pinocchio.SE3(robot.before[i].copy()), name)
        self.data = self.model.createData()
        self.last = parent
        self.tip = pinocchio.SE3(robot.before[-1].copy())

    def forward(self, q: Floats) -> Floats:
        """The tip's pose (4, 4) in the base frame at joint positions (dof,)."""
        self.pin.forwardKinematics(self.model, self.data, q)
        pose: Floats = (self.data.oMi[self.last] * self.tip).homogeneous
        return pose

    def solve(self, tip: Floats, start: Floats) -> tuple[Floats, bool]:
        """Joint positions (dof,) within the limits that bring the tip to a pose (4, 4), from a start nearby.

        Levenberg-Marquardt on the error in the Lie algebra, its damping in step with the error (Sugihara 2011,
        doi:10.1109/TRO.2011.2148230).

        Returns:
            The positions, and whether they reach the pose to the tolerance.
        """
        pin, robot = self.pin, self.robot
        target = pin.SE3(np.array(tip))
        q = start.copy()
        for _ in range(self.settings.iterations):
            pin.forwardKinematics(self.model, self.data, q)
            at = self.data.oMi[self.last] * self.tip
            error = pin.log6(at.actInv(target)).vector
            if np.abs(error).max() < self.settings.tolerance_m:
                return q, True
            jacobian = self.tip.actionInverse @ pin.computeJointJacobian(self.model, self.data, q, self.last)
            damping = 0.5 * float(error @ error) + 1e-10
            normal = jacobian.T @ jacobian + damping * np.eye(robot.dof)
            step = np.linalg.solve(normal, jacobian.T @ error)
            q = np.clip(q + step * min(1.0, 0.5 / max(np.abs(step).max(), 1e-12)), robot.lower, robot.upper)
        return q, False

    def starts(self, tip: Floats) -> list[Floats]:
        """Different joint positions that reach a pose, from the named poses and seeded random ones."""
        robot, rng = self.robot, np.random.default_rng(self.settings.seed)
        low, high = np.maximum(robot.lower, -np.pi), np.minimum(robot.upper, np.pi)
        tried = [*robot.poses.values(), *rng.uniform(low, high, (self.settings.starts, robot.dof))]
        found: list[Floats] = []
        for start in tried:
            q, ok = self.solve(tip, np.clip(start, robot.lower, robot.upper))
            q = self._unwound(q)
            if ok and all(np.abs(q - other).max() > 0.05 for other in found):
                found.append(q)
        return found

    def _unwound(self, q: Floats) -> Floats:
        """The same pose with each joint less than half a turn from the first named pose, where limits allow."""
        near = next(iter(self.robot.poses.values()), np.zeros(self.robot.dof))
        turned = q - 2 * np.pi * np.round((q - near) / (2 * np.pi))
        allowed = ~self.robot.prismatic & (turned >= self.robot.lower) & (turned <= self.robot.upper)
        return np.where(allowed, turned, q)

    def track(self, tips: Floats, start: Floats) -> tuple[Floats, NDArray[np.bool_]]:
        """Joint positions (n, dof) along poses (n, 4, 4), and where (n,) they reach them; stops at the first miss."""
        path = np.repeat(start[None], len(tips), axis=0)
        ok = np.zeros(len(tips), bool)
        q = start
        for i, tip in enumerate(tips):
            moved, reached = self.solve(tip, q)
            if not reached or np.abs(moved - q).max() > 0.6:
                break
            path[i], ok[i], q = moved, True, moved
        return path, ok
