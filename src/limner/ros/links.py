"""Motions go in; an action server, a command topic or a preview in this process follows them."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any

from limner.errors import DeviceFailed
from limner.ros import messages
from limner.ros.feed import JointFeed
from limner.ros.middleware import ros
from limner.ros.simulated import SimulatedArm
from limner.types import Floats, JointTrajectory

FIND_S = 10.0
"""How long a controller is looked for."""

RATE_HZ = 50
"""How often joints are reported."""

_ARRIVED_RAD = 1e-3
_SETTLE_S = 0.1


def motion_message(motion: JointTrajectory) -> Any:
    """A motion as trajectory_msgs/JointTrajectory, to begin when it arrives."""
    r = ros()
    empty = r.trajectory.JointTrajectory()
    return messages.fill_motion(empty, motion, r.trajectory.JointTrajectoryPoint, r.rospy.Duration)


class ActionLink:
    """A FollowJointTrajectory action server."""

    def __init__(self, controller: str) -> None:
        self.name = f"{controller}/follow_joint_trajectory"
        # The simple client forgets answers that come before it has taken down its own goal.
        self._client = ros().actionlib.ActionClient(self.name, ros().control.FollowJointTrajectoryAction)
        self._goal: Any = None

    def open(self) -> None:
        """See that the server is there.

        Raises:
            DeviceFailed: it is not.
        """
        if not self._client.wait_for_server(ros().rospy.Duration(FIND_S)):
            raise DeviceFailed(f"{self.name}: no action server of this name; is the controller running?")

    def send(self, motion: JointTrajectory) -> None:
        """Send a goal."""
        goal = ros().control.FollowJointTrajectoryGoal(trajectory=motion_message(motion))
        self._goal = self._client.send_goal(goal)

    def ended(self) -> str | None:
        """None while it is under way, an empty text when it has come to its end, else what went wrong."""
        if self._goal.get_comm_state() != ros().actionlib.CommState.DONE:
            return None
        state, status = self._goal.get_goal_status(), ros().status
        if state == status.SUCCEEDED:
            return ""
        names = {status.REJECTED: "refused", status.ABORTED: "aborted", status.PREEMPTED: "cancelled"}
        why = self._goal.get_goal_status_text()
        return f"the controller has {names.get(state, 'lost')} the motion{': ' if why else ''}{why}"

    def cancel(self) -> None:
        """Cancel the goal, if there is one."""
        self._client.cancel_all_goals()


class TopicLink:
    """The command topic of a controller, which says nothing back: only its joints tell."""

    def __init__(self, controller: str, feed: JointFeed) -> None:
        self.name = f"{controller}/command"
        self._feed = feed
        self._publisher = ros().rospy.Publisher(self.name, ros().trajectory.JointTrajectory, queue_size=1)
        self._end: Floats | None = None
        self._due_s = 0.0

    def open(self) -> None:
        """See that somebody listens.

        Raises:
            DeviceFailed: nobody does.
        """
        for _ in range(int(FIND_S / 0.05)):
            if self._publisher.get_num_connections():
                return
            ros().rospy.rostime.wallsleep(0.05)
        raise DeviceFailed(f"{self.name}: nobody listens on this topic; is the controller running?")

    def send(self, motion: JointTrajectory) -> None:
        """Publish a motion."""
        self._end, self._due_s = motion.q[-1], time.monotonic() + float(motion.t_s[-1]) + _SETTLE_S
        self._publisher.publish(motion_message(motion))

    def ended(self) -> str | None:
        """None until its time is over and the joints are where it ends: a closed stroke is there from the first."""
        if self._end is None or time.monotonic() < self._due_s:
            return None
        return "" if abs(self._feed.q() - self._end).max() < _ARRIVED_RAD else None

    def cancel(self) -> None:
        """An empty trajectory has a controller hold where it is."""
        self._publisher.publish(ros().trajectory.JointTrajectory())


class PreviewLink:
    """An arm without hardware in this process: it follows at once, its joints are reported as those of a real one."""

    def __init__(self, arm: SimulatedArm, report: Callable[[Floats], None]) -> None:
        self.name = "preview"
        self._arm, self._report = arm, report
        self._lock = threading.Lock()
        self._refused = ""

    def open(self) -> None:
        """It is always there."""

    def run(self) -> None:
        """Report joints until ROS ends."""
        rate = ros().rospy.Rate(RATE_HZ)
        while not ros().rospy.is_shutdown():
            with self._lock:
                self._arm.step(1 / RATE_HZ)
                q = self._arm.q
            self._report(q)
            _sleep(rate)

    def send(self, motion: JointTrajectory) -> None:
        """Follow a motion."""
        with self._lock:
            self._refused = self._arm.refuse(motion)
            if not self._refused:
                self._arm.follow(motion)

    def ended(self) -> str | None:
        """None while it is under way, an empty text when it has come to its end, else what went wrong."""
        with self._lock:
            return self._refused or (None if self._arm.moving else "")

    def cancel(self) -> None:
        """Come to rest."""
        with self._lock:
            self._arm.halt()


def _sleep(rate: Any) -> None:
    """Until the next turn, or the end of ROS."""
    try:
        rate.sleep()
    except ros().rospy.ROSInterruptException:
        return
