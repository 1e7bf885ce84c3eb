"""A ROS node for tests, in a process of its own: requests as lines of JSON in, answers as lines of JSON out.

rospy keeps threads, sockets and loggers for good, which a process that runs other tests had better not have.
"""

from __future__ import annotations

import json
import sys
import threading

import actionlib
import numpy as np
import rospy
import tf2_ros
from geometry_msgs.msg import Point, PointStamped, PoseStamped
from nav_msgs.msg import Path
from sensor_msgs.msg import Image, JointState
from std_msgs.msg import Float32, String
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint
from visualization_msgs.msg import Marker, MarkerArray

from limner.ros.master import keep_registered
from limner.ros.middleware import ros
from limner.vision.photo import load_photo
from processes import PATIENCE_S, until

TOPICS = {
    "portrait": Image,
    "strokes": MarkerArray,
    "path": Path,
    "trajectory": JointTrajectory,
    "ink": Marker,
    "progress": Float32,
    "status": String,
    "joint_states": JointState,
}


def motion(message):
    return {
        "names": message.joint_names,
        "t": [p.time_from_start.to_sec() for p in message.points],
        "q": [p.positions for p in message.points],
    }


def strokes(message):
    lines = [m for m in message.markers if m.ns.startswith("stroke/")]
    return {"frames": [m.header.frame_id for m in lines], "lines": [[(p.x, p.y, p.z) for p in m.points] for m in lines]}


READ = {
    "portrait": lambda m: {
        "size": [m.width, m.height],
        "encoding": m.encoding,
        "mean": float(np.frombuffer(m.data, np.uint8).mean()),
    },
    "strokes": strokes,
    "path": lambda m: {
        "frame": m.header.frame_id,
        "points": [(p.pose.position.x, p.pose.position.y, p.pose.position.z) for p in m.poses],
    },
    "trajectory": motion,
    "ink": lambda m: {"frame": m.header.frame_id, "points": [(p.x, p.y, p.z) for p in m.points]},
    "progress": lambda m: m.data,
    "status": lambda m: m.data,
    "joint_states": lambda m: {"stamp": m.header.stamp.to_sec(), "names": m.name, "q": m.position},
}


class Probe:
    def __init__(self):
        self.heard = {name: [] for name in TOPICS}
        self.counts = dict.fromkeys(TOPICS, 0)
        self.lock = threading.Lock()
        for name, kind in TOPICS.items():
            rospy.Subscriber(name, kind, self.hear, name, tcp_nodelay=True)
        self.image = rospy.Publisher("image", Image, queue_size=1)
        self.drawing = rospy.Publisher("drawing", Path, queue_size=50)
        self.point = rospy.Publisher("probed_point", PointStamped, queue_size=50)
        self.joints = rospy.Publisher("joint_states", JointState, queue_size=50)
        self.tf = tf2_ros.Buffer()
        self.listener = tf2_ros.TransformListener(self.tf)
        self.client = None

    def hear(self, message, name):
        with self.lock:
            keep = self.heard[name] if name in ("status", "progress", "joint_states") else []
            if name != "strokes" or len(message.markers) > 1:
                self.heard[name] = [*keep, message][-20_000:]
            self.counts[name] += 1

    def do_connected(self):
        """How many other nodes listen to each of what is published here."""
        counts = [topic.get_num_connections() for topic in (self.image, self.drawing, self.point, self.joints)]
        return [*counts[:-1], counts[-1] - 1]  # joints are heard here too

    def do_all(self, topic):
        with self.lock:
            return [READ[topic](m) for m in self.heard[topic]]

    def do_count(self, topic):
        return self.counts[topic]

    def do_last(self, topic):
        with self.lock:
            return READ[topic](self.heard[topic][-1]) if self.heard[topic] else None

    def do_call(self, service, patience_s=1):
        try:
            rospy.wait_for_service(service, timeout=patience_s)
            answer = rospy.ServiceProxy(service, Trigger)()
        except (rospy.ServiceException, rospy.ROSException) as error:
            return [None, str(error)]
        return [answer.success, answer.message]

    def do_race(self, service):
        """Two calls at once."""
        answers = []
        callers = [threading.Thread(target=lambda: answers.append(self.do_call(service, PATIENCE_S))) for _ in range(2)]
        for caller in callers:
            caller.start()
        for caller in callers:
            caller.join()
        return answers

    def do_photo(self, file, encoding="rgb8", size=None):
        rgb = load_photo(file).rgb
        pixels = {"bgr8": rgb[..., ::-1], "mono8": rgb.mean(-1).astype(np.uint8)}.get(encoding, rgb)
        height, width = size or rgb.shape[:2]
        step = pixels.strides[0] if encoding == "mono8" else 3 * rgb.shape[1]
        self.image.publish(Image(width=width, height=height, encoding=encoding, step=step, data=pixels.tobytes()))

    def do_stroke(self, points, frame="paper"):
        path = Path()
        path.header.frame_id = frame
        for x, y, z in points:
            pose = PoseStamped()
            pose.pose.position = Point(x, y, z)
            path.poses.append(pose)
        self.drawing.publish(path)

    def do_point(self, place, frame):
        message = PointStamped(point=Point(*place))
        message.header.frame_id = frame
        self.point.publish(message)

    def do_joints(self, names, q):
        self.joints.publish(JointState(name=names, position=q))

    def do_goal(self, controller, names, q, t, velocities=True):
        handle = self.sent(controller, names, q, t, velocities)
        until(lambda: handle.get_comm_state() == actionlib.CommState.DONE)
        return [handle.get_goal_status(), handle.get_goal_status_text()]

    def do_cancels(self, controller, names, q, t, times):
        """How the goals ended that were cancelled one after the other, as soon as each had begun."""
        ended = []
        for _ in range(times):
            handle = self.sent(controller, names, q, t)
            until(lambda handle=handle: handle.get_comm_state() == actionlib.CommState.ACTIVE, look_s=0.001)
            handle.cancel()
            until(lambda handle=handle: handle.get_comm_state() == actionlib.CommState.DONE, patience_s=60)
            ended.append(handle.get_goal_status())
        return ended

    def sent(self, controller, names, q, t, velocities=True):
        """A goal, and what tells how it goes."""
        r = ros()
        if self.client is None:
            name = f"{controller}/follow_joint_trajectory"
            self.client = actionlib.ActionClient(name, r.control.FollowJointTrajectoryAction)
            assert self.client.wait_for_server(rospy.Duration(PATIENCE_S))
        zeros = [0.0] * len(names) if velocities else []
        points = [
            JointTrajectoryPoint(positions=row, velocities=zeros, time_from_start=rospy.Duration(s))
            for row, s in zip(q, t, strict=True)
        ]
        goal = r.control.FollowJointTrajectoryGoal(trajectory=JointTrajectory(joint_names=names, points=points))
        return self.client.send_goal(goal)

    def do_frame(self, target, source):
        try:
            found = self.tf.lookup_transform(target, source, rospy.Time(0), rospy.Duration(PATIENCE_S)).transform
        except tf2_ros.TransformException as error:
            return str(error)
        at, turn = found.translation, found.rotation
        return [at.x, at.y, at.z, turn.w, turn.x, turn.y, turn.z]

    def do_param(self, name, value):
        rospy.set_param(name, value)


def main():
    rospy.init_node("probe", argv=["probe"], disable_signals=True)
    keep_registered(lambda text: None)
    out, sys.stdout = sys.stdout, sys.stderr
    probe = Probe()
    for line in sys.stdin:
        request = json.loads(line)
        try:
            answer = {"answer": getattr(probe, "do_" + request.pop("do"))(**request)}
        except AssertionError as error:
            answer = {"failed": str(error)}
        out.write(json.dumps(answer) + "\n")
        out.flush()
    rospy.signal_shutdown("done")


main()
