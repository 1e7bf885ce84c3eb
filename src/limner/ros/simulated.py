"""Goals and time go in; where the joints of a simulated arm are comes out, which refuses goals as a real one does."""

from __future__ import annotations

import numpy as np

from limner.errors import LimnerError
from limner.motion.arm.check import check
from limner.motion.arm.robot import Robot
from limner.types import Floats, JointTrajectory

START_RAD = 0.01
"""A goal may begin this far from where the arm is."""

HALT_S = 0.1
"""How long a cancelled motion takes to come to rest on its way."""


class SimulatedArm:
    """An arm that follows its goals exactly.

    Attributes:
        robot: whose limits hold.
        q: (dof,) where it is.
        qd: (dof,) its velocity.
    """

    def __init__(self, robot: Robot, q: Floats) -> None:
        self.robot, self.q, self.qd = robot, np.array(q, dtype=np.float64), np.zeros(robot.dof)
        self._motion: JointTrajectory | None = None
        self._t, self._rate, self._halting = 0.0, 1.0, False

    @property
    def moving(self) -> bool:
        """Whether a goal is being followed."""
        return self._motion is not None

    @property
    def halting(self) -> bool:
        """Whether it comes to rest because it was told to."""
        return self._halting

    def refuse(self, motion: JointTrajectory) -> str:
        """Why a motion is not followed; empty where it is."""
        try:
            check(motion, self.robot)
        except LimnerError as error:
            return str(error)
        off = np.abs(motion.q[0] - self.q)
        if off.max() > START_RAD:
            joint = int(off.argmax())
            return (
                f"trajectory: begins {off[joint]:.3f} rad from where {self.robot.joints[joint]} is"
                f" ({self.q[joint]:.3f}), more than {START_RAD:g}; plan from where the arm is"
            )
        return ""

    def follow(self, motion: JointTrajectory) -> None:
        """Begin a motion that was not refused, instead of the one before."""
        self._motion, self._t, self._rate, self._halting = motion, 0.0, 1.0, False

    def halt(self) -> None:
        """Slow down along the way, and stay there."""
        self._halting = self.moving

    def step(self, seconds: float) -> bool:
        """Let time pass; True when a motion has come to its end or to rest in this step."""
        if self._motion is None:
            return False
        if self._halting:
            self._rate = max(0.0, self._rate - seconds / HALT_S)
        self._t += self._rate * seconds
        before, self.q = self.q, self._motion.at(self._t)
        self.qd = (self.q - before) / seconds if seconds else np.zeros(self.robot.dof)
        if self._t < self._motion.t_s[-1] and self._rate > 0:
            return False
        self._motion, self._halting, self.qd = None, False, np.zeros(self.robot.dof)
        return True
