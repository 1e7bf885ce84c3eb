"""Bytes of a robot's description go in, to be read as an arm."""

from __future__ import annotations

import numpy as np

from fuzz.contract import file_of
from limner.motion.arm.robots import load_robot


def urdf(data: bytes) -> None:
    """A URDF; where its tip is in the middle of its limits is somewhere."""
    with file_of(data, "robot.urdf") as path:
        robot = load_robot(path)
    assert np.isfinite(robot.forward((robot.lower + robot.upper) / 2)).all()


def robot_toml(data: bytes) -> None:
    """What stands beside a URDF."""
    with file_of(ARM, "robot.urdf") as path:
        path.with_suffix(".toml").write_bytes(data)
        load_robot(path)


ARM = b"""<robot name="a"><link name="base"/><link name="tip"/><link name="end"/>
<joint name="j" type="revolute"><parent link="base"/><child link="tip"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
<joint name="k" type="prismatic"><parent link="tip"/><child link="end"/><axis xyz="0 0 1"/>
<limit lower="0" upper="1" velocity="1" effort="1"/></joint></robot>"""

HARNESSES = {"urdf": urdf, "robot-toml": robot_toml}
