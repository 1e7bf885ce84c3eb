"""The checked motions of an arm go in, stroke by stroke; MuJoCo's arm follows them, at the pace of a real one."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from limner.errors import DeviceFailed
from limner.motion.arm.legs import Legs
from limner.simulation.commands import commands
from limner.simulation.model import to_mjcf
from limner.simulation.physics import run, step_times
from limner.simulation.settings import SimulationSettings
from limner.simulation.sheet import find_sheet
from limner.targets.simulated import Clock
from limner.types import Floats, JointTrajectory

OFF_RAD = 0.05
"""An arm this far from where it was led has failed."""


class SimulatedArm:
    """An arm that is not there: servos, gravity, a sprung pen and its paper.

    Attributes:
        name: that says what it is.
        force_n: greatest force of the pen on the paper in each stroke that was drawn.
    """

    def __init__(self, route: Legs, settings: SimulationSettings, pace: float = 1.0) -> None:
        """An arm at the pose that the motion begins with.

        Args:
            route: the motion, cut at its lifts.
            settings: servos, pen, paper and faults.
            pace: seconds of the arm in a second, if computing keeps up.
        """
        self.name = f"a simulated {route.robot.name}"
        self.force_n: dict[int, float] = {}
        self._route, self._settings, self._clock = route, settings, Clock(pace)
        self._q: Floats = route.motion.q[0]
        self._at, self._model, self._up = -1, "", True

    def open(self) -> None:
        """Make the world: the sheet lies where the motion touches it."""
        motion = self._route.motion
        sheet = find_sheet(motion, self._route.robot, self._settings.press_for(motion))
        self._model = to_mjcf(self._route.robot, sheet.faulty(self._settings.fault), self._settings)

    def draw(self, index: int, stopping: Callable[[], bool]) -> bool:
        """Go to a stroke if the arm is not there, and draw it.

        Args:
            index: of the stroke.
            stopping: asked all the time; when true, the arm stops.

        Returns:
            Whether the stroke is drawn.

        Raises:
            DeviceFailed: the arm did not get to where it was led.
        """
        if self._at != index and not self._follow(self._route.to_stroke(self._q, index), stopping):
            return False
        self._up, self._at = False, -1
        drawn = self._follow(self._route.stroke(index), stopping, index)
        self._up = True
        if drawn:
            self._at = index + 1
        return drawn

    def home(self) -> None:
        """Go to where the motion ends."""
        if self._at >= 0:
            self._follow(self._route.home(self._at), lambda: False)

    def abort(self) -> bool:
        """It stops where it is, the pen drawn back."""
        return True

    def close(self) -> None:
        """There is nothing to let go of."""

    def _follow(self, motion: JointTrajectory, stopping: Callable[[], bool], stroke: int = -1) -> bool:
        seconds = float(motion.t_s[-1])
        if stopping():
            return False
        if seconds > 0:
            told = commands(motion, self._route.robot, self._settings, step_times(seconds))
            record = run(self._model, motion.q[0], told, self._settings)
            off = float(np.abs(record.q[-1] - motion.q[-1]).max())
            if off > OFF_RAD:
                raise DeviceFailed(
                    f"{self.name} ended {off:.2f} rad from where it was led; lower its speed (arm.retime)"
                )
            if stroke >= 0:
                self.force_n[stroke] = float(record.force_n.max())
        if self._clock.wait(seconds, lambda: not stopping()) < seconds:
            return False
        self._q = motion.q[-1]
        return True
