"""A node's name and arguments go in; this process is that node, or it is said that no master answers."""

from __future__ import annotations

import signal
from typing import Any

from limner.errors import DeviceFailed
from limner.ros.middleware import ros


def begin(name: str, arguments: list[str]) -> None:
    """Register this process with the master.

    Args:
        name: of the node.
        arguments: as ROS takes them, ``from:=to`` and ``_parameter:=value``.

    Raises:
        DeviceFailed: no master answers.
        MissingRos: ROS is not there.
    """
    r = ros()
    if not r.rosgraph.is_master_online():
        raise DeviceFailed(f"no ROS master at {r.rosgraph.get_master_uri()}; start one: rosmaster --core, or roscore")
    # Our own end comes first: the arm is stopped while its topics still work.
    r.rospy.init_node(name, argv=["limner", *arguments], disable_signals=True)
    end_on_sigterm()


def end_on_sigterm() -> None:
    """Have this process end when it is told to as it does by Ctrl-C."""
    signal.signal(signal.SIGTERM, _interrupt)


def end() -> None:
    """Leave the master."""
    ros().rospy.signal_shutdown("done")


def _interrupt(number: int, frame: Any) -> None:
    raise KeyboardInterrupt
