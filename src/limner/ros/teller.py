"""Drawings, plans, motion and words go in; what all of ROS may know of them is published."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

import numpy as np

from limner import transforms
from limner.errors import BadInput
from limner.motion.arm.plan import ArmPlan
from limner.motion.arm.robot import Robot
from limner.motion.arm.robots import load_robot
from limner.pipeline import Portrait
from limner.ros import messages, pictures
from limner.ros.feed import JointFeed
from limner.ros.ink import InkTrail
from limner.ros.links import motion_message
from limner.ros.middleware import ros
from limner.ros.parameters import Fixed
from limner.targets import image
from limner.targets.recording import PAPER
from limner.types import Drawing, Floats, Pen, Photo

PORTRAIT_PX_MM = 4.0
"""Resolution of the picture on the topic portrait."""

_BASE = "base_link"


class Teller:
    """Publishes what happens on a ``Desk``, and where the arm and its ink are."""

    def __init__(self, robot: Robot, feed: JointFeed, fixed: Fixed, pen_mm: Callable[[], float]) -> None:
        """Nothing is told yet.

        Args:
            robot: the arm.
            feed: of its joints.
            fixed: the parameters that stay: of them the name of the robot, and which frames are told.
            pen_mm: width of the pen now.
        """
        r = ros()
        self._robot, self._feed, self._fixed, self._pen_mm = robot, feed, fixed, pen_mm
        self._trail: InkTrail | None = None
        self._plan: ArmPlan | None = None
        self._strokes: Any = None
        self._ink, self._said, self._share = pictures.ink(Pen().width_mm), "", -1.0
        self._inking = False
        self._lock = threading.Lock()
        self._publish = {
            "portrait": _topic("portrait", r.sensor.Image),
            "strokes": _topic("strokes", r.visual.MarkerArray),
            "path": _topic("path", r.nav.Path),
            "trajectory": _topic("trajectory", r.trajectory.JointTrajectory),
            "ink": _topic("ink", r.visual.Marker),
            "progress": _topic("progress", r.std.Float32),
            "status": _topic("status", r.std.String),
        }
        self._static, self._moving = r.tf.StaticTransformBroadcaster(), r.tf.TransformBroadcaster()

    def drawn(self, drawing: Drawing, portrait: Portrait | None) -> None:
        """There is a new drawing: its picture and its strokes."""
        picture = Photo(image.to_rgb(drawing, PORTRAIT_PX_MM))
        self._publish["portrait"].publish(messages.fill_image(stamped(ros().sensor.Image()), picture))
        self._strokes = pictures.strokes(drawing)
        self._publish["strokes"].publish(pictures.nothing())
        self._publish["strokes"].publish(self._strokes)

    def planned(self, plan: ArmPlan) -> None:
        """There is a new plan: the sheet's frame, the pen's path, the joints' motion."""
        with self._lock:
            self._plan = plan
            self._trail = InkTrail(self._robot, plan.placement)
            self._ink = pictures.ink(self._pen_mm())
        self.frames(plan)
        self._publish["ink"].publish(self._ink)
        self._publish["path"].publish(pictures.path(plan.path.points_mm))
        self._publish["trajectory"].publish(stamped(motion_message(plan.trajectory)))

    def begun(self) -> None:
        """A sheet is begun: no ink yet."""
        with self._lock:
            assert self._plan is not None
            self._feed.drain()
            self._trail = InkTrail(self._robot, self._plan.placement)
            self._ink, self._inking = pictures.ink(self._pen_mm()), True
            self._publish["ink"].publish(self._ink)

    def progress(self, share: float) -> None:
        """So much is done."""
        if share != self._share:
            self._share = share
            self._publish["progress"].publish(share)

    def status(self, text: str) -> None:
        """What goes on, said once."""
        if text != self._said:
            self._said = text
            ros().rospy.loginfo(text)
            self._publish["status"].publish(text)

    def strokes_again(self) -> None:
        """The strokes once more, if there are any."""
        if self._strokes:
            self._publish["strokes"].publish(self._strokes)

    def tick(self, busy: Callable[[], bool]) -> None:
        """The ink that has come, and where the pen is.

        Args:
            busy: whether the arm draws.
        """
        with self._lock:
            # What has come since the last tick is ink too where the drawing has ended meanwhile.
            inking, self._inking = self._inking or busy(), busy()
            positions = self._feed.drain()
            new = self._trail.take(positions) if self._trail and inking else np.zeros((0, 2, 2))
            if len(new):
                self._ink.points += pictures.segments(new)
                self._ink.header.stamp = ros().rospy.Time.now()
                self._publish["ink"].publish(self._ink)
            if positions and self._plan and self._fixed.tf == "chain":
                self._send_tip(self._plan, positions[-1])

    def frames(self, plan: ArmPlan | None) -> None:
        """The fixed frames that the node answers for; without a plan those above the sheet."""
        fixed = _above(self._fixed.robot, self._robot) if self._fixed.tf == "chain" else []
        if plan is not None:
            fixed.append(_frame(self._robot.base, PAPER, plan.placement.base_from_paper))
        if fixed:
            self._static.sendTransform(fixed)

    def _send_tip(self, plan: ArmPlan, q: Floats) -> None:
        paper_from_tip = transforms.inverse(plan.placement.base_from_paper) @ self._robot.forward(q)
        self._moving.sendTransform(_frame(PAPER, self._robot.tip, paper_from_tip))


def stamped(message: Any) -> Any:
    """The message with the time of now."""
    message.header.stamp = ros().rospy.Time.now()
    return message


def _topic(name: str, kind: Any) -> Any:
    return ros().rospy.Publisher(name, kind, queue_size=10, latch=True)


def _above(name: str, robot: Robot) -> list[Any]:
    """The arm's base in the robot's, where the robot has one."""
    if robot.base == _BASE:
        return []
    try:
        whole = load_robot(name, base=_BASE)
    except BadInput:
        return []
    return [_frame(_BASE, robot.base, whole.before[0] @ transforms.inverse(robot.before[0]))]


def _frame(parent: str, child: str, matrix: Floats) -> Any:
    return pictures.frame(parent, child, matrix, transforms.to_quaternion(matrix[:3, :3]))
