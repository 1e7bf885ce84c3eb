"""A joint trajectory goes in; the points that a trajectory controller of ROS takes come out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from limner.errors import BadInput
from limner.types import Floats, JointTrajectory

LONGEST_STEP_S = 0.05
"""Controllers join points by splines: at 0.05 s the pen stays within 0.03 mm of its path, at 0.1 s within 0.13 mm."""

_REST = 1e-6


@dataclass(frozen=True, eq=False)
class Points:
    """A motion from rest to rest, the first point being where the arm is.

    Without accelerations: a controller then goes along the cubics that the motion was checked by, whose acceleration
    may jump at a point. With them it would go along quintics, which swing far over the limits at each such jump.

    Attributes:
        names: of the joints (dof).
        time_ns: (n,) from the start, 0 at first, strictly increasing.
        q, qd: (n, dof) position and velocity [rad or m, per s].
    """

    names: tuple[str, ...]
    time_ns: NDArray[np.int64]
    q: Floats
    qd: Floats


def controller_points(motion: JointTrajectory) -> Points:
    """The points of a ``trajectory_msgs/JointTrajectory``, times counted from the first.

    Raises:
        BadInput: it does not begin and end at rest, or its samples are too far apart for a controller.
    """
    time_ns = np.rint((motion.t_s - motion.t_s[0]) * 1e9).astype(np.int64)
    # Two samples at one time are one place: `check` refuses jumps.
    kept = np.diff(time_ns, prepend=-1) > 0
    if np.abs(motion.qd[[0, -1]]).max() > _REST:
        raise BadInput("trajectory: moves in its first or last sample; a controller takes motions from rest to rest")
    if (longest := float(np.diff(time_ns[kept], prepend=0).max()) / 1e9) > LONGEST_STEP_S + 1e-6:
        raise BadInput(
            f"trajectory: samples {1000 * longest:.0f} ms apart, controllers need {1000 * LONGEST_STEP_S:.0f} ms or"
            " less; plan it with --set arm.retime.sample_s=0.02"
        )
    return Points(motion.names, time_ns[kept], motion.q[kept], motion.qd[kept])


def nothing(names: tuple[str, ...]) -> Points:
    """No points at all: a controller that gets these stops, and holds the arm where it is."""
    none = np.zeros((0, len(names)))
    return Points(names, np.zeros(0, np.int64), none, none)


def trajectory_message(points: Points, frame: str, clock: tuple[str, str] = ("sec", "nanosec")) -> dict[str, Any]:
    """The fields of a ``trajectory_msgs/JointTrajectory``.

    Its stamp is zero, which tells a controller to begin when the message arrives.

    Args:
        points: of the motion.
        frame: name of the base.
        clock: what the two parts of a time are called: ``secs`` and ``nsecs`` in the JSON of ROS 1.
    """
    return {
        "header": {"stamp": split_time(0, clock), "frame_id": frame},
        "joint_names": list(points.names),
        "points": [
            {
                "positions": q,
                "velocities": qd,
                "accelerations": [],
                "effort": [],
                "time_from_start": split_time(time_ns, clock),
            }
            for time_ns, q, qd in zip(points.time_ns.tolist(), points.q.tolist(), points.qd.tolist(), strict=True)
        ],
    }


def split_time(time_ns: int, clock: tuple[str, str] = ("sec", "nanosec")) -> dict[str, int]:
    """Whole seconds and the nanoseconds that are left."""
    return dict(zip(clock, divmod(time_ns, 1_000_000_000), strict=True))
