"""Poses of the pen go in; whether and how an arm reaches them comes out, in closed form where there is one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from limner.motion.arm import elbow, numeric_ik
from limner.motion.arm.elbow import ElbowSettings
from limner.motion.arm.numeric_ik import NumericSettings, PinocchioArm
from limner.motion.arm.robot import Robot
from limner.motion.arm.srs import SphericalArm
from limner.settings import SettingsGroup, group
from limner.types import Floats

_MAP_ANGLES = np.linspace(-np.pi, np.pi, 16, endpoint=False)


@dataclass(frozen=True)
class InverseSettings(SettingsGroup):
    """How joint positions are found."""

    elbow: ElbowSettings = group(ElbowSettings)
    numeric: NumericSettings = group(NumericSettings)


Clear = Callable[[Floats], bool]
"""Whether joint positions (n, dof) may be taken, such as for touching nothing."""


def anywhere(q: Floats) -> bool:
    """Every joint position may be taken."""
    return True


class Inverse(Protocol):
    """Inverse kinematics of one arm. Poses are (n, 4, 4) of the tip in the base frame."""

    @property
    def quick(self) -> bool:
        """Whether thousands of poses cost no more than seconds."""

    def margins(self, tips: Floats) -> Floats:
        """(n,) how far the best solution stays from the limits [rad or m]; negative: how far beyond; -inf: no reach."""

    def follow(self, tips: Floats, clear: Clear = anywhere) -> tuple[Floats | None, NDArray[np.bool_]]:
        """Joint positions (n, dof) along a path that are clear, or None, and which poses can be reached (n,)."""

    def why(self, tip: Floats) -> str:
        """Why a pose (4, 4) cannot be reached: a distance or the joint whose limit is in the way; empty if it can."""


def inverse(robot: Robot, settings: InverseSettings | None = None) -> Inverse:
    """The inverse kinematics that suits a robot.

    Raises:
        MissingExtra: it has no closed form, and pinocchio is not installed.
    """
    settings = settings or InverseSettings()
    arm = SphericalArm.of(robot)
    if arm is not None:
        return _ClosedForm(robot, arm, settings.elbow)
    return _Numeric(robot, PinocchioArm(robot, settings.numeric), settings.numeric)


def _limit_in_the_way(robot: Robot, q: Floats) -> str:
    """Which joint of positions (dof,) is farthest beyond its limit."""
    joint = int(robot.margin(q).argmin())
    if robot.margin(q)[joint] >= 0:
        return ""
    scale, unit = (1000, "mm") if robot.prismatic[joint] else (np.degrees(1), "deg")
    low, high, value = (scale * v[joint] for v in (robot.lower, robot.upper, q))
    return f"joint {robot.joints[joint]} would have to go to {value:.0f} {unit}, its limits are {low:.0f} to {high:.0f}"


@dataclass(frozen=True, eq=False)
class _ClosedForm:
    robot: Robot
    arm: SphericalArm
    settings: ElbowSettings
    quick = True

    def margins(self, tips: Floats) -> Floats:
        margins = np.full(len(tips), -np.inf)
        near = self.arm.within_reach(tips)
        q, _ = self.arm.solve(tips[near, None], _MAP_ANGLES)
        margins[near] = self.robot.margin(q).min(-1).max((1, 2))
        return margins

    def follow(self, tips: Floats, clear: Clear = anywhere) -> tuple[Floats | None, NDArray[np.bool_]]:
        return elbow.follow(self.robot, self.arm, tips, self.settings, clear)

    def why(self, tip: Floats) -> str:
        q, _ = self.arm.solve(tip[None], _MAP_ANGLES)
        if not self.arm.within_reach(tip):
            distance = float(self.arm.wrist_distance(tip))
            nearest, farthest = abs(self.arm.upper_m - self.arm.fore_m), self.arm.upper_m + self.arm.fore_m
            return (
                f"the wrist would be {1000 * distance:.0f} mm from the shoulder,"
                f" the arm reaches from {1000 * nearest:.0f} to {1000 * farthest:.0f}"
            )
        flat = q.reshape(-1, self.robot.dof)
        return _limit_in_the_way(self.robot, flat[self.robot.margin(flat).min(-1).argmax()])


@dataclass(frozen=True, eq=False)
class _Numeric:
    robot: Robot
    arm: PinocchioArm
    settings: NumericSettings
    quick = False

    def margins(self, tips: Floats) -> Floats:
        margins = np.full(len(tips), -np.inf)
        nearby = list(self.robot.poses.values()) or [(self.robot.lower + self.robot.upper) / 2]
        last = nearby[0]
        for i, tip in enumerate(tips):
            for start in (last, *nearby):
                q, reached = self.arm.solve(tip, start)
                if reached:
                    margins[i], last = float(self.robot.margin(q).min()), q
                    break
        return margins

    def follow(self, tips: Floats, clear: Clear = anywhere) -> tuple[Floats | None, NDArray[np.bool_]]:
        return numeric_ik.follow(self.robot, tips, self.settings, clear)

    def why(self, tip: Floats) -> str:
        if self.arm.starts(tip):
            return ""
        reach = max(float(np.linalg.norm(self.robot.forward(q)[:3, 3])) for q in self._sampled())
        distance = float(np.linalg.norm(tip[:3, 3]))
        return (
            f"{1000 * distance:.0f} mm from the base (it reaches {1000 * reach:.0f} mm stretched), pen held like this"
        )

    def _sampled(self) -> Floats:
        rng = np.random.default_rng(self.settings.seed)
        low, high = np.maximum(self.robot.lower, -np.pi), np.minimum(self.robot.upper, np.pi)
        samples: Floats = rng.uniform(low, high, (500, self.robot.dof))
        return samples
