"""The planned motion of an arm goes in; what ROS would have heard while it drew comes out, message by message."""

from __future__ import annotations

import heapq
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from limner import transforms
from limner.targets.ros_points import controller_points, split_time, trajectory_message
from limner.types import Floats, JointTrajectory, Value, frozen_array

START_NS = 1_000_000_000
"""When a recording begins: the same for all, so that the same plan gives the same bytes; ROS takes 0 for no time."""

PAPER, TIP = "paper", "pen_tip"

TOPICS = {
    "/tf_static": "tf2_msgs/msg/TFMessage",
    "/path": "nav_msgs/msg/Path",
    "/trajectory": "trajectory_msgs/msg/JointTrajectory",
    "/tf": "tf2_msgs/msg/TFMessage",
    "/joint_states": "sensor_msgs/msg/JointState",
    "/ink": "visualization_msgs/msg/Marker",
}
"""Every topic, and the type of its messages."""

LATCHED = ("/tf_static", "/path", "/trajectory")
"""Topics said once, which who comes later hears too."""

_GROW_NS = 100_000_000
_GROW_TIMES = 50  # a long stroke grows in fewer, larger steps: each says all of it again
_TOUCH_M = 5e-5
_DOT_M = 1e-4
_LINE_STRIP, _SPHERE_LIST = 4, 7


class Message(NamedTuple):
    """What is said at a time: the fields of a message, those left out being zero."""

    time_ns: int
    topic: str
    fields: dict[str, Any]


@dataclass(frozen=True, eq=False)
class Recording(Value):
    """A planned drawing, as a bag tells it.

    Attributes:
        motion: of the joints.
        tips: (n, 4, 4) the pen's tip at each sample, base frame [m].
        base_from_paper: (4, 4) where the sheet lies [m].
        root_from_base: (4, 4) where the arm's base is on the robot [m].
        root, base: names of these frames; no root where they are the same.
        pen_mm: width of the ink.
    """

    motion: JointTrajectory
    tips: Floats
    base_from_paper: Floats
    root_from_base: Floats
    root: str
    base: str
    pen_mm: float

    def __post_init__(self) -> None:
        self._freeze("tips", frozen_array(self.tips, np.float64, (len(self.motion.t_s), 4, 4), "Recording.tips"))
        for name in ("base_from_paper", "root_from_base"):
            self._freeze(name, frozen_array(getattr(self, name), np.float64, (4, 4), f"Recording.{name}"))


def messages(recording: Recording) -> Iterator[Message]:
    """All messages in the order of their times.

    Raises:
        BadInput: the motion is none that a controller takes.
    """
    motion = recording.motion
    times = START_NS + np.rint((motion.t_s - motion.t_s[0]) * 1e9).astype(np.int64)
    poses = transforms.inverse(recording.base_from_paper) @ recording.tips
    trajectory = trajectory_message(controller_points(motion), recording.base)
    first = [
        Message(START_NS, "/tf_static", _static(recording)),
        Message(START_NS, "/path", _path(times, poses)),
        Message(START_NS, "/trajectory", trajectory),
    ]
    moving = (_tips(times, poses), _joints(times, motion), _ink(times, poses, motion, recording.pen_mm))
    return heapq.merge(first, *moving, key=lambda message: message.time_ns)


def _static(recording: Recording) -> dict[str, Any]:
    steps = [(recording.base, PAPER, recording.base_from_paper)]
    if recording.root and recording.root != recording.base:
        steps.insert(0, (recording.root, recording.base, recording.root_from_base))
    return {"transforms": [_transform(START_NS, *step) for step in steps]}


def _path(times: Any, poses: Floats) -> dict[str, Any]:
    """Where the tip goes, in metres on the paper."""
    stamped = [
        {
            "header": _header(time_ns, PAPER),
            "pose": {"position": _xyz(pose[:3, 3]), "orientation": _quaternion(pose)},
        }
        for time_ns, pose in zip(times.tolist(), poses, strict=True)
    ]
    return {"header": _header(START_NS, PAPER), "poses": stamped}


def _tips(times: Any, poses: Floats) -> Iterator[Message]:
    for time_ns, pose in zip(times.tolist(), poses, strict=True):
        yield Message(time_ns, "/tf", {"transforms": [_transform(time_ns, PAPER, TIP, pose)]})


def _joints(times: Any, motion: JointTrajectory) -> Iterator[Message]:
    for time_ns, q, qd in zip(times.tolist(), motion.q.tolist(), motion.qd.tolist(), strict=True):
        fields = {"header": _header(time_ns, ""), "name": list(motion.names), "position": q, "velocity": qd}
        yield Message(time_ns, "/joint_states", fields)


def _ink(times: Any, poses: Floats, motion: JointTrajectory, pen_mm: float) -> Iterator[Message]:
    """What is on the paper, one marker each time that the pen has touched it, growing while it draws."""
    points = poses[:, :3, 3]
    touching = np.flatnonzero(motion.down | (points[:, 2] <= _TOUCH_M))
    runs = np.split(touching, np.flatnonzero(np.diff(touching) > 1) + 1) if len(touching) else []
    for index, run in enumerate(runs):
        every = max(_GROW_NS, int(times[run[-1]] - times[run[0]]) // _GROW_TIMES)
        said = times[run[0]]
        for count, sample in enumerate(run.tolist(), start=1):
            if times[sample] - said >= every or sample == run[-1]:
                said = times[sample]
                yield Message(int(said), "/ink", _marker(int(said), index, points[run[:count], :2], pen_mm / 1000))


def _marker(time_ns: int, index: int, points: Floats, pen_m: float) -> dict[str, Any]:
    dot = bool(np.ptp(points, axis=0).max() < _DOT_M)
    return {
        "header": _header(time_ns, PAPER),
        "ns": "ink",
        "id": index,
        "type": _SPHERE_LIST if dot else _LINE_STRIP,
        "pose": {"orientation": {"w": 1.0}},
        "scale": {"x": pen_m, "y": pen_m, "z": pen_m},
        "color": {"r": 0.05, "g": 0.05, "b": 0.2, "a": 1.0},
        "points": [{"x": x, "y": y} for x, y in (points[-1:] if dot else points).tolist()],
    }


def _transform(time_ns: int, frame: str, child: str, pose: Floats) -> dict[str, Any]:
    return {
        "header": _header(time_ns, frame),
        "child_frame_id": child,
        "transform": {"translation": _xyz(pose[:3, 3]), "rotation": _quaternion(pose)},
    }


def _header(time_ns: int, frame: str) -> dict[str, Any]:
    return {"stamp": split_time(time_ns), "frame_id": frame}


def _xyz(point: Floats) -> dict[str, float]:
    return dict(zip("xyz", point.tolist(), strict=True))


def _quaternion(pose: Floats) -> dict[str, float]:
    return dict(zip("wxyz", transforms.to_quaternion(pose[:3, :3]).tolist(), strict=True))
