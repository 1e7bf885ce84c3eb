"""``limner ros controller``: goals of FollowJointTrajectory in; a simulated arm's joints and feedback out."""

from __future__ import annotations

from typing import Any

import numpy as np

from limner.errors import BadInput, LimnerError
from limner.motion.arm.robot import SAFE, Robot
from limner.motion.arm.robots import load_robot
from limner.ros import messages
from limner.ros.begin import begin, end
from limner.ros.links import RATE_HZ
from limner.ros.master import keep_registered
from limner.ros.middleware import ros
from limner.ros.simulated import SimulatedArm
from limner.types import Floats

NAME = "limner_controller"


class Controller:
    """The node: hands goals to a ``SimulatedArm``, and tells where it is.

    Parameters: ``robot``, ``controller`` (its name), ``start`` (a pose by name, or joint positions), ``speed`` (how
    much faster than real the arm's time goes; joints are reported as much more often), ``also`` (joints that are
    reported at rest, such as the slide of a sprung pen).
    """

    def __init__(self) -> None:
        r, get = ros(), ros().rospy.get_param
        self._robot = load_robot(str(get("~robot", "dumbo")))
        self._arm = SimulatedArm(self._robot, _pose(self._robot, get("~start", SAFE)))
        self._speed = float(get("~speed", 1.0))
        self._also = [str(name) for name in get("~also", [])]
        name = str(get("~controller", self._robot.controller or "arm_controller"))
        self._goal: Any = None
        self._states = r.rospy.Publisher("joint_states", r.sensor.JointState, queue_size=4 * RATE_HZ, tcp_nodelay=True)
        self._server = r.actionlib.ActionServer(
            f"{name}/follow_joint_trajectory",
            r.control.FollowJointTrajectoryAction,
            goal_cb=self._on_goal,
            cancel_cb=self._on_cancel,
            auto_start=False,
        )
        # The server holds its lock while it hands over a cancel: a second one, held while it is told something, could
        # be waited for in turn for ever.
        self._lock = self._server.lock
        r.rospy.Subscriber(f"{name}/command", r.trajectory.JointTrajectory, self._on_command)
        self._server.start()

    def run(self) -> None:
        """Until ROS ends."""
        r = ros()
        keep_registered(r.rospy.loginfo)
        rate = r.rospy.Rate(RATE_HZ * self._speed)
        while not r.rospy.is_shutdown():
            with self._lock:
                cancelled = self._arm.halting
                if self._arm.step(1 / RATE_HZ):
                    self._done(cancelled)
            self._report()
            rate.sleep()

    def _on_goal(self, handle: Any) -> None:
        with self._lock:
            try:
                motion = messages.to_motion(handle.get_goal().trajectory, self._robot.joints)
                reason = self._arm.refuse(motion)
            except LimnerError as error:
                motion, reason = None, str(error)
            if reason or motion is None:
                result = ros().control.FollowJointTrajectoryResult(error_code=-1, error_string=reason)
                handle.set_rejected(result, reason)
                return
            self._let_go("another goal has come")
            handle.set_accepted()
            self._goal = handle
            self._arm.follow(motion)

    def _on_cancel(self, handle: Any) -> None:
        with self._lock:
            if self._goal is not None and handle.get_goal_id().id == self._goal.get_goal_id().id:
                self._arm.halt()

    def _on_command(self, message: Any) -> None:
        with self._lock:
            if not message.points:
                self._arm.halt()
                return
            try:
                motion = messages.to_motion(message, self._robot.joints)
                reason = self._arm.refuse(motion)
            except LimnerError as error:
                ros().rospy.logwarn(f"command refused: {error}")
                return
            if reason:
                ros().rospy.logwarn(f"command refused: {reason}")
                return
            self._let_go("a command has come")
            self._arm.follow(motion)

    def _let_go(self, why: str) -> None:
        if self._goal is not None:
            self._goal.set_canceled(ros().control.FollowJointTrajectoryResult(error_string=why), why)
            self._goal = None

    def _done(self, cancelled: bool) -> None:
        if cancelled:
            self._let_go("cancelled")
        elif self._goal is not None:
            self._goal.set_succeeded(ros().control.FollowJointTrajectoryResult())
            self._goal = None

    def _report(self) -> None:
        r = ros()
        now = r.rospy.Time.now()
        q, qd = self._arm.q.tolist(), self._arm.qd.tolist()
        still = [0.0] * len(self._also)
        state = r.sensor.JointState(name=[*self._robot.joints, *self._also], position=q + still, velocity=qd + still)
        state.header.stamp = now
        self._states.publish(state)
        with self._lock:
            if self._goal is not None:
                feedback = r.control.FollowJointTrajectoryFeedback(joint_names=list(self._robot.joints))
                feedback.header.stamp = now
                feedback.actual.positions = feedback.desired.positions = q
                feedback.actual.velocities = feedback.desired.velocities = qd
                feedback.error.positions = [0.0] * self._robot.dof
                self._goal.publish_feedback(feedback)


def _pose(robot: Robot, start: Any) -> Floats:
    if isinstance(start, str):
        return robot.pose(start) if start in robot.poses or start != SAFE else np.zeros(robot.dof)
    q = np.array(start, dtype=np.float64)
    if q.shape != (robot.dof,) or not np.isfinite(q).all():
        raise BadInput(f"parameter ~start = {start!r}; expected the name of a pose or {robot.dof} joint positions")
    return q


def run(arguments: list[str]) -> None:
    """Run the controller until ROS ends; arguments as ROS takes them.

    Raises:
        LimnerError: ROS is not there, or a parameter is wrong.
    """
    begin(NAME, arguments)
    try:
        Controller().run()
    except (KeyboardInterrupt, ros().rospy.ROSInterruptException):
        pass
    finally:
        end()
