"""Motions of an arm go in, stroke by stroke; its controller gets each over rosbridge, and its joints tell the end."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from limner.errors import BadInput, DeviceFailed, LimnerError
from limner.settings import SettingsGroup, setting
from limner.targets.bridge import BACKOFF_S, Bridge, BridgeAddress, Lost, check_name, number
from limner.targets.ros_points import Points, controller_points, nothing, trajectory_message
from limner.targets.target import Route
from limner.types import Floats, JointTrajectory

SLACK = 1.5
"""An arm may take so many times what was planned."""

SILENCE_S = 5.0
"""An arm whose joints say nothing for so long is not heard from again."""

CLOCKS = {"1": ("secs", "nsecs"), "2": ("sec", "nanosec")}
"""What the parts of a time are called in each ROS."""

_STEADY_S = 0.1
_REST_S, _REST_RAD = 0.3, 1e-3  # at rest is what moves no farther for so long
_MEET_S = 1.0  # a controller hears of a new publisher only after a while


@dataclass(frozen=True)
class RosbridgeSettings(SettingsGroup):
    """How an arm is spoken to over rosbridge."""

    ros: str = setting("1", "the ROS behind rosbridge", choices=("1", "2"))
    states: str = setting("/joint_states", "topic on which the arm tells its joint positions")
    before: str = setting("", "service that is called before the arm moves, such as one that frees its brakes")
    stop: str = setting("", "service that is called when the arm is stopped at once, whose pen is not drawn back then")
    near_deg: float = setting(1.0, "the arm has arrived when its joints are as near", unit="deg", low=0.01, high=10)


class Rosbridge:
    """An arm behind rosbridge.

    Each motion is one ``trajectory_msgs/JointTrajectory`` that begins where the arm is, at rest, and ends at rest with
    the pen up. Only when the joints say that they are there does the next one go out.
    """

    def __init__(
        self,
        address: BridgeAddress,
        route: Route,
        settings: RosbridgeSettings,
        names: tuple[str, ...],
        frame: str,
        silence_s: float = SILENCE_S,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Prepare; nothing is connected yet.

        Args:
            address: of rosbridge, and of the controller.
            route: checked motions.
            settings: names of topics and services.
            names: of the joints.
            frame: name of the arm's base.
            silence_s: how long it may say nothing.
            clock: seconds, as they pass for the arm.

        Raises:
            BadInput: a name is none of ROS.
            MissingExtra: websockets is not installed.
        """
        for part in ("states", "before", "stop"):
            if value := getattr(settings, part):
                check_name(value, f"rosbridge.{part}")
        if not settings.states:
            raise BadInput("rosbridge.states: without a topic of joint states nobody knows where the arm is")
        self.name = f"{address.url}{address.topic}"
        self._topic, self._route, self._settings, self._frame = address.topic, route, settings, frame
        self._names, self._silence_s, self._clock = names, silence_s, clock
        self._bridge = Bridge(address.url, silence_s)
        self._q: Floats | None = None
        self._at = -1  # before which stroke the arm waits, -1: elsewhere
        self._up, self._busy = False, False
        self._known_at = 0.0  # when the controller knows of us

    def open(self) -> None:
        """Connect, and ask where the arm is; nothing moves.

        Raises:
            DeviceFailed: nobody answers, or does not say where the arm is.
        """
        self._bridge.connect()
        self._greet()
        if self._settings.before:
            self._bridge.call(self._settings.before, self._until(self._silence_s))
        self._q = self._heard()
        self._rest()

    def draw(self, index: int, stopping: Callable[[], bool]) -> bool:
        """Go to a stroke if the arm is not there, and draw it.

        A controller takes a motion whole: asked to stop, the arm does so in the air, at the end of what it is doing.

        Args:
            index: of the stroke.
            stopping: asked between motions.

        Returns:
            Whether the stroke is drawn; else the arm waits before it, the pen up.

        Raises:
            DeviceFailed: it did not do as told, or the connection is gone.
        """
        assert self._q is not None
        if self._at != index:
            self._at = -1
            self._follow(self._route.to_stroke(self._q, index))
            self._at, self._up = index, True
        if stopping():
            return False
        self._up, self._at = False, -1
        self._follow(self._route.stroke(index))
        self._up, self._at = True, index + 1
        return True

    def home(self) -> None:
        """Go back to where the motion ends."""
        if self._at >= 0:
            self._follow(self._route.home(self._at))

    def abort(self) -> bool:
        """Stop the arm where it is, by a motion without points, and draw its pen back; never raises.

        An arm that a service was told to stop is told nothing more: it may have no power, and move once it has.
        """
        if self._busy:
            with contextlib.suppress(LimnerError):
                self._say(self._message(nothing(self._names)))
                if self._settings.stop:
                    self._bridge.call(self._settings.stop, self._until(self._silence_s))
                elif not self._up:
                    self._follow(self._route.lift(self._settled()))
                    self._up = True
        return self._up

    def close(self) -> None:
        """Let go of the connection."""
        self._bridge.close()

    def _greet(self) -> None:
        """Say which topic we write to, on a new connection."""
        self._bridge.send("advertise", topic=self._topic, type=self._type("trajectory_msgs", "JointTrajectory"))
        self._known_at = self._clock() + _MEET_S

    def _listen(self) -> None:
        kind = self._type("sensor_msgs", "JointState")
        self._bridge.send("subscribe", topic=self._settings.states, type=kind, throttle_rate=20, queue_length=1)

    def _heard(self) -> Floats:
        """Where the arm is now; its states go on coming."""
        self._listen()
        going = self._until(self._silence_s)
        while going():
            if (q := self._state()) is not None:
                return q
        raise DeviceFailed(
            f"{self.name}: {self._settings.states} does not tell where {', '.join(self._names)} are; is the arm on?"
        )

    def _settled(self) -> Floats:
        """Where the arm has come to rest.

        Raises:
            DeviceFailed: it still moves, or does not say where it is.
        """
        rest, since = self._heard(), self._clock()
        going = self._until(self._silence_s)
        while going():
            q = self._state()
            if q is not None and np.abs(q - rest).max() > _REST_RAD:
                rest, since = q, self._clock()
            elif q is not None and self._clock() - since >= _REST_S:
                return q
        raise DeviceFailed(f"{self.name}: the arm was told to stop and still moves")

    def _state(self) -> Floats | None:
        """The joint positions that come next, if any come now."""
        message = self._bridge.receive()
        if message is None or message["op"] != "publish" or message.get("topic") != self._settings.states:
            return None
        try:
            said = message["msg"]
            at = dict(zip(said["name"], said["position"], strict=True))
            # Other parts of a robot may tell theirs on the same topic.
            return np.array([number(at[name]) for name in self._names]) if set(self._names) <= set(at) else None
        except (KeyError, TypeError, ValueError) as error:
            raise DeviceFailed(f"{self.name}: {self._settings.states} tells no joint positions ({error})") from error

    def _follow(self, motion: JointTrajectory) -> None:
        points = controller_points(motion)
        if len(points.time_ns) > 1:
            self._begin(motion)
            self._busy = True
            try:
                self._say(self._message(points))
            except Lost:
                # Whether it has gone out the arm itself will show.
                self._again()
            self._arrive(motion)
            self._busy = False
            self._rest()
        # What its joints tell is rounded; the next motion begins exactly where this one led.
        self._q = motion.q[-1]

    def _begin(self, motion: JointTrajectory) -> None:
        """Make sure that the arm is where a motion begins; what is lost in the meantime is had anew."""
        try:
            q = self._heard()
        except Lost:
            self._again()
            q = self._heard()
        if (off := _off_deg(q, motion.q[0])) > self._settings.near_deg:
            raise DeviceFailed(f"{self.name}: the arm was moved, it is {off:.1f} degrees from where its motion begins")
        while self._clock() < self._known_at:
            self._bridge.receive()

    def _arrive(self, motion: JointTrajectory) -> None:
        """Wait until the joints are where a motion leads, and stay.

        Raises:
            DeviceFailed: they do not come there, or nothing is heard of them.
        """
        seconds = float(motion.t_s[-1] - motion.t_s[0])
        began = heard = self._clock()
        near: float | None = None
        q = motion.q[0]
        while True:
            try:
                state = self._state()
            except Lost:
                self._again()
                self._listen()
                heard, state = self._clock(), None
            now = self._clock()
            if state is not None:
                q, heard = state, now
                there = now - began >= seconds and _off_deg(q, motion.q[-1]) <= self._settings.near_deg
                near = (now if near is None else near) if there else None
                if near is not None and now - near >= _STEADY_S:
                    return
            if now - heard > self._silence_s:
                raise DeviceFailed(f"{self.name}: {self._settings.states} is silent since {now - heard:.0f} s")
            if now - began > SLACK * seconds + self._silence_s:
                raise DeviceFailed(f"{self.name}: {self._missed(q, motion)}")

    def _missed(self, q: Floats, motion: JointTrajectory) -> str:
        if _off_deg(q, motion.q[0]) <= self._settings.near_deg:
            return "the arm has not moved; does its controller listen there, and does it take the motion?"
        return f"the arm ended {_off_deg(q, motion.q[-1]):.1f} degrees from where its motion leads"

    def _rest(self) -> None:
        """Hear no more states: nobody reads them while a drawing is paused."""
        with contextlib.suppress(Lost):
            self._bridge.send("unsubscribe", topic=self._settings.states)
            going = self._until(1.0)
            while going() and self._bridge.receive() is not None:
                pass

    def _again(self) -> None:
        """Connect again.

        Raises:
            DeviceFailed: that is not possible.
        """
        try:
            self._bridge.connect(BACKOFF_S)
            self._greet()
        except DeviceFailed as error:
            self._up = False
            raise DeviceFailed(f"the connection ended, the arm may go on; {error}") from error

    def _say(self, message: dict[str, Any]) -> None:
        self._bridge.send("publish", topic=self._topic, msg=message)

    def _message(self, points: Points) -> dict[str, Any]:
        return trajectory_message(points, self._frame, CLOCKS[self._settings.ros])

    def _type(self, package: str, name: str) -> str:
        return f"{package}/{name}" if self._settings.ros == "1" else f"{package}/msg/{name}"

    def _until(self, seconds: float) -> Callable[[], bool]:
        """Whether so long has not passed yet."""
        end = self._clock() + seconds
        return lambda: self._clock() < end


def _off_deg(q: Floats, where: Floats) -> float:
    return float(np.degrees(np.abs(q - where).max()))
