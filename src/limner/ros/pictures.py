"""Drawings, plans and ink go in; what rviz shows of them comes out: markers and paths in the frame of the sheet."""

from __future__ import annotations

from typing import Any

from limner.ros.middleware import ros
from limner.targets.recording import PAPER
from limner.types import Drawing, Floats

_LINE_M = 0.0009
_ABOVE_M = 0.0003
_PLANNED = (0.55, 0.65, 0.85, 0.55)
_INK = (0.05, 0.05, 0.12, 1.0)
_WHITE = (0.98, 0.98, 0.96, 1.0)


def marker(namespace: str, kind: str, number: int = 0) -> Any:
    """An empty marker on the sheet."""
    found = ros().visual.Marker(ns=namespace, id=number, type=getattr(ros().visual.Marker, kind))
    found.header.frame_id = PAPER
    found.pose.orientation.w = 1.0
    return found


def strokes(drawing: Drawing) -> Any:
    """The sheet, and a line for each stroke."""
    lines = [_stroke(number, line, drawing) for number, line in enumerate(drawing.lines_mm)]
    return ros().visual.MarkerArray(markers=[_sheet(drawing), *lines])


def nothing() -> Any:
    """Markers of an earlier drawing go."""
    return ros().visual.MarkerArray(markers=[ros().visual.Marker(action=ros().visual.Marker.DELETEALL)])


def _sheet(drawing: Drawing) -> Any:
    found = marker("sheet", "TRIANGLE_LIST")
    found.scale.x = found.scale.y = found.scale.z = 1.0
    found.color = _colour(_WHITE)
    right, top = drawing.page.width_mm / 1000, drawing.page.height_mm / 1000
    corners = [(0, 0, 0), (right, 0, 0), (right, top, 0), (0, top, 0)]
    found.points = [point(corners[k]) for k in (0, 1, 2, 0, 2, 3)]
    # Corners with colours of their own are not shaded: paper stays white.
    found.colors = [found.color] * 6
    return found


def _stroke(number: int, line_mm: Floats, drawing: Drawing) -> Any:
    found = marker(f"stroke/{drawing.region[number]}", "LINE_STRIP", number)
    found.scale.x = max(_LINE_M, drawing.pens[drawing.layer[number]].width_mm / 1000)
    found.color = _colour(_PLANNED)
    # A strip of one point is refused by rviz: a dot is there and back.
    found.points = [
        point((x / 1000, y / 1000, _ABOVE_M))
        for x, y in [*line_mm.tolist(), *line_mm[:1].tolist() * (len(line_mm) == 1)]
    ]
    return found


def ink(width_mm: float) -> Any:
    """Ink that is to grow by ``segments``."""
    found = marker("ink", "LINE_LIST")
    found.scale.x = max(_LINE_M, width_mm / 1000)
    found.color = _colour(_INK)
    return found


def segments(new_mm: Floats) -> list[Any]:
    """Both ends of each of (n, 2, 2) segments [mm], a little above the sheet."""
    return [point((x / 1000, y / 1000, 2 * _ABOVE_M)) for x, y in new_mm.reshape(-1, 2).tolist()]


def path(points_mm: Floats) -> Any:
    """A nav_msgs/Path of the pen's tip: (n, 3) [mm], paper frame."""
    found = ros().nav.Path()
    found.header.frame_id = PAPER
    found.header.stamp = ros().rospy.Time.now()
    for place in (points_mm / 1000).tolist():
        pose = ros().geometry.PoseStamped(header=found.header)
        pose.pose.position, pose.pose.orientation.w = point(place), 1.0
        found.poses.append(pose)
    return found


def frame(parent: str, child: str, matrix: Floats, quaternion_wxyz: Floats) -> Any:
    """A geometry_msgs/TransformStamped of a (4, 4) transform and its rotation as a quaternion."""
    found = ros().geometry.TransformStamped(child_frame_id=child)
    found.header.frame_id, found.header.stamp = parent, ros().rospy.Time.now()
    move, turn = found.transform.translation, found.transform.rotation
    move.x, move.y, move.z = matrix[:3, 3].tolist()
    turn.w, turn.x, turn.y, turn.z = quaternion_wxyz.tolist()
    return found


def point(place_m: Any) -> Any:
    """A geometry_msgs/Point."""
    x, y, z = place_m
    return ros().geometry.Point(x, y, z)


def _colour(rgba: tuple[float, float, float, float]) -> Any:
    return ros().std.ColorRGBA(*rgba)
