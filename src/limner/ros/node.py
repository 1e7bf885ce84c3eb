"""``limner ros node``: images, strokes and service calls in; portraits, motions, a drawing arm out. No logic here."""

from __future__ import annotations

import itertools
import threading
from collections.abc import Callable
from typing import Any

import numpy as np

from limner.errors import BadInput, LimnerError
from limner.motion.arm.legs import Legs
from limner.motion.arm.robot import SAFE
from limner.ros import messages, parameters
from limner.ros.arm import Link, RosArm
from limner.ros.begin import begin, end
from limner.ros.desk import Desk
from limner.ros.feed import JointFeed
from limner.ros.links import RATE_HZ, ActionLink, PreviewLink, TopicLink
from limner.ros.master import keep_registered
from limner.ros.middleware import ros
from limner.ros.simulated import SimulatedArm
from limner.ros.teller import Teller, stamped
from limner.targets import files
from limner.types import Floats
from limner.vision.photo import load_photo

NAME = "limner"
TICK_HZ = 10
AGAIN_S = 2
"""How often strokes are told again: rviz drops markers that come before the frame of their sheet."""

_BUFFER = 2**26


class Node:
    """The node: hands messages to its ``Desk``, whose ``Teller`` publishes what happens."""

    def __init__(self) -> None:
        self._given = self._parameters()
        self._fixed, self._robot = parameters.fixed(self._given)
        self._feed = JointFeed(self._robot.joints, self._fixed.silence_s)
        self._link = self._linked()
        self._teller = Teller(self._robot, self._feed, self._fixed, self._pen_mm)
        self._desk = Desk(self._arm, self._fixed.journal, self._teller)
        self._subscribe()
        self._serve()

    def run(self) -> None:
        """Until ROS ends; then the arm is stopped, its pen raised."""
        r = ros()
        keep_registered(self._teller.status)
        self._first()
        rate = r.rospy.Rate(TICK_HZ)
        try:
            for turn in itertools.count():
                if r.rospy.is_shutdown():
                    break
                self._teller.tick(lambda: self._desk.busy)
                if turn % (TICK_HZ * AGAIN_S) == 0:
                    self._teller.strokes_again()
                rate.sleep()
        except (KeyboardInterrupt, r.rospy.ROSInterruptException):
            pass
        finally:
            if self._desk.busy:
                self._try(self._desk.stop)

    # What comes from outside.

    def _on_image(self, message: Any) -> None:
        def take() -> str:
            self._desk.see(messages.to_photo(message))
            return self._sketch_and_plan() if self._given.get("auto", True) else "image: taken; ~sketch draws it"

        self._try(take)

    def _on_stroke(self, message: Any) -> None:
        def take() -> str:
            page, pen = self._settings().page.page(), self._settings().page.pen()
            line = messages.to_stroke(message, page) if message.poses else np.zeros((0, 2))
            self._desk.add_stroke(line, page, pen)
            return ""

        self._try(take)

    def _on_joints(self, message: Any) -> None:
        # Other arms, and grippers, report on the same topic.
        if set(self._robot.joints) & set(message.name):
            self._try(lambda: self._feed.take(message.name, message.position))

    def _on_point(self, message: Any) -> None:
        def take() -> str:
            messages.check_frame("probed_point", message.header.frame_id, self._robot.base)
            return self._desk.probe(np.array([message.point.x, message.point.y, message.point.z]))

        self._try(take, self._teller.status)

    def _sketch(self) -> str:
        return self._desk.sketch(self._settings())

    def _make_plan(self) -> str:
        return self._desk.plan(self._settings(), self._robot)

    def _sketch_and_plan(self) -> str:
        self._sketch()
        return self._make_plan()

    def _probe_here(self) -> str:
        return self._desk.probe(self._robot.forward(self._feed.q())[:3, 3])

    def _first(self) -> None:
        """Draw the photo or plan the drawing that a parameter names; else load what the first photo will need."""
        photo, drawing = self._given.get("photo"), self._given.get("drawing")

        def take() -> str:
            if photo:
                self._desk.see(load_photo(str(photo)))
                return self._sketch_and_plan()
            self._desk.take(files.read_drawing(str(drawing)))
            return self._make_plan()

        self._teller.frames(None)
        if photo or drawing:
            self._try(take)
        else:
            self._try(lambda: self._desk.warm(self._settings(), self._robot))

    # ROS.

    def _subscribe(self) -> None:
        r, subscribe = ros(), ros().rospy.Subscriber
        subscribe("image", r.sensor.Image, self._on_image, queue_size=1, buff_size=_BUFFER)
        subscribe("drawing", r.nav.Path, self._on_stroke)
        subscribe("probed_point", r.geometry.PointStamped, self._on_point)
        if self._fixed.target != "none":
            subscribe("joint_states", r.sensor.JointState, self._on_joints, tcp_nodelay=True)

    def _serve(self) -> None:
        desk = self._desk
        for name, wish in (
            ("sketch", self._sketch),
            ("plan", self._make_plan),
            ("start", desk.start),
            ("pause", desk.pause),
            ("resume", desk.resume),
            ("stop", desk.stop),
            ("calibrate_point", self._probe_here),
            ("calibrate_clear", desk.forget_points),
        ):
            ros().rospy.Service(f"~{name}", ros().srvs.Trigger, self._handler(wish))

    def _handler(self, wish: Callable[[], str]) -> Callable[[Any], Any]:
        def handle(_: Any) -> Any:
            try:
                return ros().srvs.TriggerResponse(True, wish())
            except LimnerError as error:
                ros().rospy.logwarn(str(error))
                return ros().srvs.TriggerResponse(False, str(error))

        return handle

    def _try(self, wish: Callable[[], str | None], told: Callable[[str], None] = lambda text: None) -> None:
        """What a message asks for; a refusal is told as status."""
        try:
            told(wish() or "")
        except LimnerError as error:
            self._teller.status(f"refused: {error}")

    def _parameters(self) -> dict[str, Any]:
        found = ros().rospy.get_param("~", {})
        if not isinstance(found, dict):
            raise BadInput(f"parameters of the node are {found!r}, expected a tree of names")
        return found

    def _settings(self) -> Any:
        """Parameters as they are now; as they were last where the master is away."""
        try:
            self._given = self._parameters()
        except OSError:
            ros().rospy.logwarn("the ROS master is gone; parameters as they were")
        return parameters.settings(self._given)

    def _pen_mm(self) -> float:
        return float(parameters.settings(self._given).page.pen_mm)

    def _arm(self, route: Legs) -> RosArm:
        return RosArm(self._link, self._feed, route)

    def _linked(self) -> Link:
        if self._fixed.target == "action":
            return ActionLink(self._fixed.controller)
        if self._fixed.target == "command":
            return TopicLink(self._fixed.controller, self._feed)
        start = self._robot.poses.get(SAFE, np.zeros(self._robot.dof))
        publisher = ros().rospy.Publisher("joint_states", ros().sensor.JointState, queue_size=RATE_HZ)

        def report(q: Floats) -> None:
            self._feed.take(self._robot.joints, q.tolist())
            message = ros().sensor.JointState(name=list(self._robot.joints), position=q.tolist())
            publisher.publish(stamped(message))

        preview = PreviewLink(SimulatedArm(self._robot, start), report)
        threading.Thread(target=preview.run, daemon=True).start()
        return preview


def run(arguments: list[str]) -> None:
    """Run the node until ROS ends.

    Args:
        arguments: names and parameters as ROS takes them: ``image:=/camera/image``, ``_style:=gabor``.

    Raises:
        LimnerError: ROS is not there, or a parameter is wrong.
    """
    begin(NAME, arguments)
    try:
        Node().run()
    finally:
        end()
