"""Messages of ROS go in, or limner's types; the others come out, or a reason why a message is refused."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from limner.errors import BadInput
from limner.targets.recording import PAPER
from limner.targets.ros_points import controller_points
from limner.types import Floats, JointTrajectory, Page, Photo

ENCODINGS = ("rgb8", "bgr8", "mono8")
"""Of images that are read."""

_MAX_PIXELS = 40_000_000
_FLAT_M = 1e-3


def to_photo(image: Any) -> Photo:
    """The picture in a sensor_msgs/Image.

    Raises:
        BadInput: another encoding, no pixels, too many, or data that do not fit the size.
    """
    if image.encoding not in ENCODINGS:
        raise BadInput(f"image: encoding '{image.encoding}' is not read; choose {', '.join(ENCODINGS)}")
    width, height, channels = int(image.width), int(image.height), 1 if image.encoding == "mono8" else 3
    if not 0 < width * height <= _MAX_PIXELS:
        raise BadInput(f"image: {width} x {height} pixels, expected 1 to {_MAX_PIXELS // 10**6} million")
    data = np.frombuffer(image.data, np.uint8)
    if image.step < width * channels or len(data) != image.step * height:
        raise BadInput(
            f"image: {len(data)} bytes with rows of {image.step} for {width} x {height} {image.encoding};"
            f" expected rows of {width * channels} or more, {height} of them"
        )
    pixels = data.reshape(height, image.step)[:, : width * channels].reshape(height, width, channels)
    return Photo(
        np.repeat(pixels, 3, axis=2) if channels == 1 else pixels[..., :: -1 if image.encoding == "bgr8" else 1]
    )


def fill_image(image: Any, photo: Photo) -> Any:
    """A sensor_msgs/Image of a picture, rgb8."""
    image.width, image.height = photo.size_px
    image.encoding, image.step, image.data = "rgb8", 3 * image.width, photo.rgb.tobytes()
    return image


def to_stroke(path: Any, page: Page) -> Floats:
    """The stroke (n, 2) [mm] in a nav_msgs/Path.

    Raises:
        BadInput: another frame, no place, one that is not finite, off the page or above it.
    """
    check_frame("drawing", path.header.frame_id)
    if not path.poses:
        raise BadInput("drawing: a path without a place; expected one or more")
    places = np.array([[p.pose.position.x, p.pose.position.y, p.pose.position.z] for p in path.poses])
    if not np.isfinite(places).all():
        raise BadInput("drawing: a place is NaN or infinite; expected metres on the sheet")
    if np.abs(places[:, 2]).max() > _FLAT_M:
        raise BadInput(f"drawing: a place is {places[np.abs(places[:, 2]).argmax(), 2]:g} m off the sheet, expected 0")
    low_m, high_m = places[:, :2].min(0), places[:, :2].max(0)
    # Compared in metres: the millimetres of what is far off may be more than a number holds.
    if low_m.min() < 0 or (high_m > np.array([page.width_mm, page.height_mm]) / 1000).any():
        raise BadInput(
            f"drawing: a stroke from ({low_m[0]:.4g}, {low_m[1]:.4g}) to ({high_m[0]:.4g}, {high_m[1]:.4g}) m leaves"
            f" the page of {page.width_mm / 1000:g} x {page.height_mm / 1000:g} m; places are in metres"
        )
    stroke: Floats = 1000 * places[:, :2]
    return stroke


def check_frame(topic: str, frame: str, expected: str = PAPER) -> None:
    """Refuse a message in another frame.

    Raises:
        BadInput: it is.
    """
    if frame.lstrip("/") != expected:
        raise BadInput(f"{topic}: in frame '{frame}', expected '{expected}'")


def fill_motion(message: Any, motion: JointTrajectory, point: Any, duration: Any) -> Any:
    """A trajectory_msgs/JointTrajectory of a motion.

    Args:
        message: to fill.
        motion: to send.
        point: class of a point.
        duration: makes a duration of seconds and nanoseconds.

    Raises:
        BadInput: no controller would take it.
    """
    points = controller_points(motion)
    rows = zip(points.time_ns.tolist(), points.q.tolist(), points.qd.tolist(), strict=True)
    message.joint_names = list(points.names)
    message.points = [
        point(positions=q, velocities=qd, accelerations=[], effort=[], time_from_start=duration(0, time_ns))
        for time_ns, q, qd in rows
    ]
    return message


def to_motion(message: Any, joints: Sequence[str]) -> JointTrajectory:
    """The motion in a trajectory_msgs/JointTrajectory, its joints in the order of the robot's.

    Raises:
        BadInput: other joints, no points, points of the wrong size or without velocities, NaN, times that go back.
    """
    names = list(message.joint_names)
    if sorted(names) != sorted(joints):
        raise BadInput(f"trajectory: for the joints {', '.join(names) or 'none'}; expected {', '.join(joints)}")
    if not message.points:
        raise BadInput("trajectory: has no points")
    order = [names.index(name) for name in joints]
    q = _rows("positions", message.points, order)
    qd = _rows("velocities", message.points, order)
    has_forces = any(len(point.accelerations) for point in message.points)
    qdd = _rows("accelerations", message.points, order) if has_forces else np.zeros_like(q)
    t_s = np.array([point.time_from_start.to_sec() for point in message.points])
    if t_s[0] < 0 or (np.diff(t_s) <= 0).any():
        raise BadInput("trajectory: times from the start must grow from point to point")
    none = np.zeros(len(t_s), bool), np.full(len(t_s), -1)
    return JointTrajectory(tuple(joints), t_s, q, qd, qdd, *none)


def _rows(name: str, points: Sequence[Any], order: list[int]) -> Floats:
    for index, point in enumerate(points):
        if len(getattr(point, name)) != len(order):
            raise BadInput(
                f"trajectory: point {index + 1} has {len(getattr(point, name))} {name}, expected {len(order)}"
            )
    rows = np.array([getattr(point, name) for point in points], dtype=np.float64)[:, order]
    if not np.isfinite(rows).all():
        raise BadInput(
            f"trajectory: {name} are NaN or infinite at point {int(np.argwhere(~np.isfinite(rows))[0, 0]) + 1}"
        )
    return rows
