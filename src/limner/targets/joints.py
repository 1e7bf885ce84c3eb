"""A joint trajectory goes in; a table of it for other programs comes out as CSV, and is read back."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from limner import storage
from limner.errors import BadInput
from limner.types import Floats, JointTrajectory

FORMATS = (".json", ".npz", ".csv")
"""What a joint trajectory can be saved as and read from."""

_KINDS = ("q", "qd", "qdd")
_SHEET = "# sheet_m"


def to_csv(trajectory: JointTrajectory) -> bytes:
    """One row a sample: time, then position, velocity and acceleration of each joint, then pen, stroke and press.

    A line before them has the corners of the sheet, where they are known: nobody can tell the page without them.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    if len(trajectory.sheet_m):
        writer.writerow([_SHEET, *map(repr, trajectory.sheet_m.ravel().tolist())])
    writer.writerow(
        ["t_s", *(f"{kind}:{name}" for kind in _KINDS for name in trajectory.names), "down", "stroke", "press_mm"]
    )
    columns = np.column_stack([trajectory.t_s, trajectory.q, trajectory.qd, trajectory.qdd])
    for numbers, down, stroke in zip(columns.tolist(), trajectory.down, trajectory.stroke, strict=True):
        writer.writerow([*map(repr, numbers), int(down), int(stroke), repr(trajectory.press_mm)])
    return text.getvalue().encode()


def from_csv(data: bytes, name: str) -> JointTrajectory:
    """Read what ``to_csv`` wrote.

    Raises:
        BadInput: no such table.
    """
    try:
        rows = list(csv.reader(io.StringIO(data.decode())))
        sheet = rows.pop(0)[1:] if rows[:1] and rows[0][:1] == [_SHEET] else []
        corners = np.array(sheet, dtype=np.float64).reshape(-1, 3)
        header, *values = rows
        table: Floats = np.array(values, dtype=np.float64)
    except (ValueError, UnicodeDecodeError, csv.Error) as error:
        raise BadInput(f"{name}: is no table of a joint trajectory ({error})") from error
    names = tuple(column.partition(":")[2] for column in header if column.startswith("q:"))
    expected = ["t_s", *(f"{kind}:{joint}" for kind in _KINDS for joint in names), "down", "stroke", "press_mm"]
    if header not in (expected, expected[:-1]) or table.ndim != 2 or table.shape[1] != len(header) or not names:
        raise BadInput(
            f"{name}: is no table of a joint trajectory; expected the columns t_s, q:, qd:, qdd:, down, stroke,"
            " and press_mm if it is known"
        )
    dof, rest = len(names), 1 + 3 * len(names)
    press_mm = float(table[0, rest + 2]) if len(header) > rest + 2 and len(table) else 0.0
    q, qd, qdd = (table[:, 1 + k * dof : 1 + (k + 1) * dof] for k in range(3))
    drawn, strokes = table[:, rest] != 0, _whole(table[:, rest + 1], name)
    return JointTrajectory(names, table[:, 0], q, qd, qdd, drawn, strokes, press_mm, corners)


def _whole(column: Floats, name: str) -> NDArray[np.int64]:
    if not (np.abs(column) < 2**31).all():
        raise BadInput(f"{name}: expected strokes from -1 up to {2**31}")
    return column.astype(np.int64)


def waypoints(trajectory: JointTrajectory, tips: Floats) -> list[dict[str, Any]]:
    """Poses of the pen's tip for planners that take no joints, such as MoveIt.

    Args:
        trajectory: the motion.
        tips: (n, 7) position [m] and quaternion w, x, y, z of the tip at each sample, in the robot's base frame.
    """
    return [
        {"t_s": t, "position_m": tip[:3], "orientation_wxyz": tip[3:], "down": bool(down), "stroke": int(stroke)}
        for t, tip, down, stroke in zip(
            trajectory.t_s.tolist(), tips.tolist(), trajectory.down, trajectory.stroke, strict=True
        )
    ]


def waypoints_format(path: str | Path) -> str:
    """The path's suffix, if waypoints can be saved as that: ``.json`` or ``.csv``.

    Raises:
        BadInput: they cannot.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in (".json", ".csv"):
        raise BadInput(f"{path}: waypoints cannot be '{suffix}'; choose .json, .csv")
    return suffix


def waypoints_bytes(poses: Sequence[dict[str, Any]], frame: str, suffix: str) -> bytes:
    """Waypoints as a file: JSON with the name of their frame, or a table of a row each."""
    if suffix == ".json":
        return (json.dumps({"frame": frame, "waypoints": poses}) + "\n").encode()
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["t_s", "x_m", "y_m", "z_m", "qw", "qx", "qy", "qz", "down", "stroke"])
    for pose in poses:
        numbers = (pose["t_s"], *pose["position_m"], *pose["orientation_wxyz"])
        writer.writerow([*map(repr, numbers), int(pose["down"]), pose["stroke"]])
    return text.getvalue().encode()


def save(trajectory: JointTrajectory, path: str | Path) -> None:
    """Write a trajectory as one of ``FORMATS``.

    Raises:
        BadInput: another suffix, or the file cannot be written.
    """
    if check_format(path) == ".csv":
        storage.write_whole(path, to_csv(trajectory))
    else:
        storage.save(trajectory, path)


def load(path: str | Path) -> JointTrajectory:
    """Read a trajectory from one of ``FORMATS``.

    Raises:
        BadInput: another suffix, unreadable, or no trajectory.
    """
    if check_format(path) == ".csv":
        return from_csv(storage.read_bytes(path), str(path))
    return storage.load(JointTrajectory, path)


def check_format(path: str | Path, formats: tuple[str, ...] = FORMATS) -> str:
    """The path's suffix, if it is one of a few that a joint trajectory can be.

    Raises:
        BadInput: it is not.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in formats:
        raise BadInput(f"{path}: a robot's motion cannot be '{suffix}'; choose {', '.join(formats)}")
    return suffix
