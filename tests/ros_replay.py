"""Plays a bag on a rosmaster of its own and prints what a subscriber of rospy hears, as one JSON object.

Runs with Debian's Python, where ROS is, in a network of its own: /usr/bin/python3 ros_replay.py BAG RATE COUNTS, the
last a JSON object of how many messages there are of each topic.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from importlib import import_module

bag, rate, counts = sys.argv[1:]
PORT = "11477"
os.environ.update(ROS_MASTER_URI=f"http://127.0.0.1:{PORT}", ROS_IP="127.0.0.1", ROS_HOME=tempfile.mkdtemp())
KINDS = {
    "/tf_static": "tf2_msgs/TFMessage",
    "/path": "nav_msgs/Path",
    "/trajectory": "trajectory_msgs/JointTrajectory",
    "/tf": "tf2_msgs/TFMessage",
    "/joint_states": "sensor_msgs/JointState",
    "/ink": "visualization_msgs/Marker",
}
heard = {topic: [] for topic in KINDS}


def listen():
    import rospy
    import tf2_ros

    rospy.init_node("listener", disable_signals=True)
    buffer = tf2_ros.Buffer(rospy.Duration(100))
    tf2_ros.TransformListener(buffer)
    for topic, kind in KINDS.items():
        package, name = kind.split("/")
        cls = getattr(import_module(f"{package}.msg"), name)
        rospy.Subscriber(topic, cls, lambda m, topic=topic: heard[topic].append((time.monotonic(), m)))
    return rospy, buffer


def wait(found, seconds=120):
    until = time.monotonic() + seconds
    while not found() and time.monotonic() < until:
        time.sleep(0.05)


def master_answers():
    import xmlrpc.client

    try:
        return xmlrpc.client.ServerProxy(os.environ["ROS_MASTER_URI"]).getPid("/test")[0] == 1
    except OSError:
        return False


master = subprocess.Popen(["rosmaster", "--core", "-p", PORT], stdout=sys.stderr)
try:
    wait(master_answers)
    rospy, buffer = listen()
    play = [
        "rosbag",
        "play",
        "--quiet",
        "--wait-for-subscribers",
        "--queue=100000",
        "--topics",
        *KINDS,
        "--rate",
        rate,
        "--bags",
        bag,
    ]
    subprocess.run(play, check=True, timeout=240, stdout=sys.stderr)
    # What was sent last may still be under way; of a topic the end may be lost where the player ends at once.
    wait(lambda: all(len(heard[topic]) >= count for topic, count in json.loads(counts).items()), 15)
    start = heard["/tf"][0][1].transforms[0].header.stamp
    lookup = buffer.lookup_transform("base_link", "pen_tip", start + rospy.Duration(2.0), rospy.Duration(60))
    tip = lookup.transform.translation
    trajectory = heard["/trajectory"][0][1]
    last = {m.id: m for _, m in heard["/ink"]}
    said = {
        "counts": {topic: len(messages) for topic, messages in heard.items()},
        "seconds": heard["/joint_states"][-1][0] - heard["/joint_states"][0][0],
        "tip_at_2s": [tip.x, tip.y, tip.z],
        "joints": trajectory.joint_names,
        "times": [p.time_from_start.to_sec() for p in trajectory.points],
        "positions": [list(p.positions) for p in trajectory.points],
        "path_frame": heard["/path"][0][1].header.frame_id,
        "path": [[p.pose.position.x, p.pose.position.y, p.pose.position.z] for p in heard["/path"][0][1].poses],
        "ink": {i: [m.type, [[p.x, p.y, p.z] for p in m.points]] for i, m in last.items()},
    }
    sys.stdout.write(json.dumps(said))
    rospy.signal_shutdown("done")
finally:
    master.terminate()
    master.wait(60)
