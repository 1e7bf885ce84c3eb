"""Checked motions go to an arm's controller, one a stroke; what became of each comes out, the pen up after a stop."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable
from typing import Protocol

import numpy as np

from limner.errors import DeviceFailed, LimnerError
from limner.motion.arm.legs import Legs
from limner.ros.feed import JointFeed
from limner.types import Floats, JointTrajectory

LOOK_S = 0.02
HEAR_S = 3.0
"""How long joints are waited for before anything moves."""

STUCK_S = 5.0
"""An arm that was given a motion and does not move for so long is stuck."""

LOW_M = 0.03
"""A pen that is less high over the place it draws at is drawn back before the arm is led anywhere."""

_REST_S = 0.2
_REST_REPORTS = 5
_REST_RAD = 1e-4
_OFF_RAD = 0.02
_THERE_S = 1.0


class Link(Protocol):
    """The way to a controller that follows trajectories."""

    name: str

    def open(self) -> None:
        """Make sure that a controller is there.

        Raises:
            DeviceFailed: there is none.
        """

    def send(self, motion: JointTrajectory) -> None:
        """Have it follow a motion from where it is."""

    def ended(self) -> str | None:
        """None while it is under way, an empty text when it has come to its end, else what went wrong."""

    def cancel(self) -> None:
        """Have it stop where it is."""


class RosArm:
    """An arm behind a controller, as a ``Device`` that draws by stroke."""

    def __init__(self, link: Link, feed: JointFeed, route: Legs) -> None:
        self.name = link.name
        self._link, self._feed, self._route = link, feed, route
        self._at = -1  # before which stroke the arm waits, -1: elsewhere
        self._up = False

    def open(self) -> None:
        """See that controller and joints are there; nothing moves.

        Raises:
            DeviceFailed: they are not.
        """
        self._link.open()
        deadline = time.monotonic() + HEAR_S
        while True:
            try:
                self._q()
                return
            except DeviceFailed:
                if time.monotonic() > deadline:
                    raise
            time.sleep(LOOK_S)

    def draw(self, index: int, stopping: Callable[[], bool]) -> bool:
        """Go to a stroke if the arm is not there, and draw it.

        Args:
            index: of the stroke.
            stopping: asked all the time; when true, the arm stops where it is and draws its pen back.

        Returns:
            Whether the stroke is drawn; else the arm was stopped, the pen up.

        Raises:
            DeviceFailed: it did not do as told.
            CannotDraw: there is no checked way to the stroke from where the arm is.
        """
        if self._at != index:
            # An arm that was left on the paper is raised before it is led anywhere.
            if self._route.height(self._q()) < LOW_M:
                self._raise()
            self._up = True
            if not self._follow(self._route.to_stroke(self._q(), index), stopping):
                return False
        self._up, self._at = False, -1
        if not self._follow(self._route.stroke(index), stopping):
            return False
        self._up, self._at = True, index + 1
        return True

    def home(self) -> None:
        """Go back to where the motion ends; an arm that was stopped within a stroke stays where it is."""
        if self._at >= 0:
            self._follow(self._route.home(self._at), lambda: False)

    def abort(self) -> bool:
        """Cancel, and draw the pen back if the joints can be seen; an arm out of sight is told nothing but to stop."""
        self._link.cancel()
        if not self._up:
            with contextlib.suppress(LimnerError):
                self._raise()
        return self._up

    def close(self) -> None:
        """Nothing has to be let go of."""

    def _q(self) -> Floats:
        try:
            return self._feed.q()
        except DeviceFailed as error:
            raise DeviceFailed(f"{self.name}: {error}") from error

    def _follow(self, motion: JointTrajectory, stopping: Callable[[], bool]) -> bool:
        """Have a motion followed; False if it was stopped, the pen up.

        Raises:
            DeviceFailed: it was refused or broken off, or the arm is stuck, out of sight or elsewhere in the end.
        """
        self._link.send(motion)
        watch = _Still(self._feed, STUCK_S)
        while (reason := self._link.ended()) is None:
            time.sleep(LOOK_S)
            still = watch.still(self._q())
            if stopping():
                self._link.cancel()
                self._settle()
                if not self._up:
                    self._raise()
                return False
            if still:
                raise DeviceFailed(f"{self.name}: the arm has not moved for {STUCK_S:.0f} s")
        if reason:
            raise DeviceFailed(f"{self.name}: {reason}")
        self._check_there(motion.q[-1])
        return True

    def _check_there(self, q: Floats) -> None:
        # Its last reports may come after the word that it is there.
        watch, deadline = _Still(self._feed, _THERE_S), time.monotonic() + STUCK_S
        while (off := float(np.abs(self._q() - q).max())) > _OFF_RAD:
            if watch.still(self._q()) or time.monotonic() > deadline:
                raise DeviceFailed(
                    f"{self.name}: the arm ended {np.degrees(off):.1f} degrees from where its motion leads"
                )
            time.sleep(LOOK_S)

    def _raise(self) -> None:
        """Draw the pen of an arm at rest back by a checked motion.

        Raises:
            LimnerError: it is not seen at rest, there is no such motion, or it was not followed.
        """
        self._settle()
        self._follow(self._route.lift(self._q()), lambda: False)
        self._up = True

    def _settle(self) -> None:
        """Wait until the arm is at rest.

        Raises:
            DeviceFailed: it still moves, or is out of sight.
        """
        watch, deadline = _Still(self._feed, _REST_S), time.monotonic() + STUCK_S
        while not watch.still(self._q()):
            if time.monotonic() > deadline:
                raise DeviceFailed(f"{self.name}: the arm was told to stop and still moves")
            time.sleep(LOOK_S)


class _Still:
    """Tells whether positions have stayed the same for some time and some reports: silence is no rest."""

    def __init__(self, feed: JointFeed, seconds: float) -> None:
        self._feed, self._seconds = feed, seconds
        self._q: Floats | None = None
        self._since, self._after = time.monotonic(), 0

    def still(self, q: Floats) -> bool:
        now, reports = time.monotonic(), self._feed.reports
        if self._q is None or np.abs(q - self._q).max() > _REST_RAD:
            self._q, self._since, self._after = q, now, reports
        # Up to the last report, not up to now.
        return self._feed.heard - self._since > self._seconds and reports - self._after >= _REST_REPORTS
