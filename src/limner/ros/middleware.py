"""The one place that imports rospy and messages, when first asked: modules come out, or what to install."""

from __future__ import annotations

import functools
from types import SimpleNamespace
from typing import Any

from limner.errors import BadInput
from limner.ros.action import generated

PACKAGES = (
    "python3-rospy python3-roslaunch rosout python3-actionlib python3-tf2-ros python3-std-srvs python3-geometry-msgs"
    " python3-sensor-msgs python3-nav-msgs python3-visualization-msgs python3-trajectory-msgs"
    " ros-robot-state-publisher rviz"
)


class MissingRos(BadInput):
    """ROS 1 is not there, or this Python does not find it."""

    def __init__(self, missing: str) -> None:
        super().__init__(
            f"limner ros needs ROS 1 ({missing} is missing); on Debian 12:"
            f" apt-get install -y --no-install-recommends {PACKAGES}"
        )
        self.add_note(
            "a virtual environment of Python 3.11 finds it by a line: echo /usr/lib/python3/dist-packages >"
            " $(python -c 'import site; print(site.getsitepackages()[0])')/zz_debian_ros.pth"
        )


@functools.cache
def ros() -> Any:
    """Modules of ROS by short names: ``rospy``, ``actionlib``, messages as ``std``, ``nav``, ..., ``control``.

    Raises:
        MissingRos: one of them cannot be imported.
    """
    try:
        return SimpleNamespace(**_libraries(), **_messages())
    except ImportError as error:
        raise MissingRos(error.name or str(error)) from error


def _libraries() -> dict[str, Any]:
    import actionlib
    import rosgraph
    import rospy
    import tf2_ros

    return {"actionlib": actionlib, "rosgraph": rosgraph, "rospy": rospy, "tf": tf2_ros}


def _messages() -> dict[str, Any]:
    import actionlib_msgs.msg
    import genpy.dynamic
    import geometry_msgs.msg
    import nav_msgs.msg
    import sensor_msgs.msg
    import std_msgs.msg
    import std_srvs.srv
    import trajectory_msgs.msg
    import visualization_msgs.msg

    status, trajectory = actionlib_msgs.msg, trajectory_msgs.msg
    points = (trajectory.JointTrajectory, trajectory.JointTrajectoryPoint)
    others = (std_msgs.msg.Header, *points, status.GoalID, status.GoalStatus)
    return {
        "control": generated(genpy.dynamic, others),
        "geometry": geometry_msgs.msg,
        "nav": nav_msgs.msg,
        "sensor": sensor_msgs.msg,
        "status": status.GoalStatus,
        "std": std_msgs.msg,
        "srvs": std_srvs.srv,
        "trajectory": trajectory,
        "visual": visualization_msgs.msg,
    }
