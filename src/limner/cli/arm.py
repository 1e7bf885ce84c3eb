"""``limner plan --robot``: a drawing and an arm in, the checked motion of its joints out."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click
import numpy as np

from limner import storage, transforms
from limner.cli.progress import busy
from limner.cli.words import many
from limner.errors import BadInput
from limner.motion.arm.calibrate import calibrate
from limner.motion.arm.ik import inverse
from limner.motion.arm.paper import Placement
from limner.motion.arm.place import reach_map
from limner.motion.arm.plan import ArmPlan, ArmSettings, plan_arm
from limner.motion.arm.robot import Robot
from limner.motion.arm.robots import load_robot
from limner.pipeline import Settings
from limner.targets import bag, joints, reach_picture, urscript
from limner.targets.files import read_drawing
from limner.targets.recording import Recording
from limner.types import Drawing

FORMATS = (*joints.FORMATS, urscript.SUFFIX)
"""What the motion of an arm can be saved as."""


@dataclass(frozen=True)
class ArmWish:
    """What is planned, and what is written of it.

    Attributes:
        drawing: its file.
        out: files for the trajectory.
        bags: bags of ROS to write.
        calibration: file of probed points, or None.
        waypoints: file for the poses of the pen, or None.
        reach: file for the map of the reach, or None.
        as_json: whether the report is printed as JSON.
    """

    drawing: str
    out: tuple[str, ...]
    bags: tuple[str, ...]
    calibration: str | None
    waypoints: str | None
    reach: str | None
    as_json: bool


def plan(wish: ArmWish, robot: str, settings: Settings) -> None:
    """Plan, write what is wished for, and tell.

    Args:
        wish: the drawing and the files.
        robot: name or URDF.
        settings: of the plan and of URScript.

    Raises:
        LimnerError: whatever stands in the way.
    """
    _check_formats(wish)
    arm = load_robot(robot)
    sheet, probed = read_calibration(wish.calibration) if wish.calibration else (None, {})
    drawing = read_drawing(wish.drawing)
    with busy(f"looking for the place of the sheet and the motion of {arm.name}"):
        planned = plan_arm(drawing, arm, settings.arm, sheet)
    _write(wish, planned, drawing, settings)
    written = [*wish.out, *wish.bags, *filter(None, (wish.waypoints, wish.reach))]
    report = planned.report() | {"pens": len(np.unique(drawing.layer))} | probed | {"out": written}
    if wish.as_json:
        click.echo(json.dumps(report))
        return
    for line in _lines(report):
        click.echo(line, err=True)


def _check_formats(wish: ArmWish) -> None:
    """Before any work."""
    for file in wish.out:
        joints.check_format(file, FORMATS)
    for file in wish.bags:
        bag.check(file)
    if wish.waypoints:
        joints.waypoints_format(wish.waypoints)


def _write(wish: ArmWish, planned: ArmPlan, drawing: Drawing, settings: Settings) -> None:
    tips = tip_poses(planned)
    for file in wish.out:
        if Path(file).suffix.lower() == urscript.SUFFIX:
            storage.write_whole(file, urscript.to_urscript(planned.trajectory, tips[:, :3], settings.ur))
        else:
            joints.save(planned.trajectory, file)
    for file in wish.bags:
        bag.save(_recording(planned, drawing), file)
    if wish.waypoints:
        poses, table = joints.waypoints(planned.trajectory, tips), joints.waypoints_format(wish.waypoints)
        storage.write_whole(wish.waypoints, joints.waypoints_bytes(poses, planned.robot.base, table))
    if wish.reach:
        storage.write_whole(wish.reach, _reach_png(planned.robot, planned, settings.arm))


def read_calibration(path: str) -> tuple[Placement, dict[str, Any]]:
    """The sheet from a file of probed points [m]: a JSON list of [x, y, z], or lines of x,y,z.

    Raises:
        BadInput: unreadable, or no plane.
    """
    data = storage.read_bytes(path)
    try:
        if Path(path).suffix.lower() == ".json":
            points = np.array(json.loads(data), dtype=np.float64)
        else:
            lines = [line for line in data.decode().splitlines() if line.strip()]
            points = np.array([[float(number) for number in line.split(",")] for line in lines])
    except (ValueError, TypeError, OverflowError, RecursionError) as error:
        raise BadInput(f"{path}: expected points as a JSON list of [x, y, z] in metres, or lines of x,y,z") from error
    found = calibrate(points)
    told = {
        "probed": len(found.used),
        "probed_used": int(found.used.sum()),
        "residual_mm": found.rms_mm,
        "tilt_deg": found.tilt_deg,
    }
    return Placement(found.base_from_paper), told


def tip_poses(planned: ArmPlan) -> Any:
    """(n, 7) position [m] and quaternion w, x, y, z of the tip at each sample."""
    frames = planned.robot.forward(planned.trajectory.q)
    return np.concatenate([frames[:, :3, 3], transforms.to_quaternion(frames[:, :3, :3])], axis=1)


def _recording(planned: ArmPlan, drawing: Drawing) -> Recording:
    robot = planned.robot
    return Recording(
        motion=planned.trajectory,
        tips=robot.forward(planned.trajectory.q),
        base_from_paper=planned.placement.base_from_paper,
        root_from_base=robot.root_from_base,
        root=robot.root,
        base=robot.base,
        pen_mm=drawing.pen.width_mm,
    )


def _reach_png(robot: Robot, planned: ArmPlan, settings: ArmSettings) -> bytes:
    height = float(planned.placement.base_from_paper[2, 3])
    at_height = settings.place.replace(table_m=height, step_m=min(0.02, settings.place.step_m))
    reach = reach_map(robot, inverse(robot, settings.inverse), at_height)
    points = planned.path.points_mm
    low, high = points[:, :2].min(0), points[:, :2].max(0)
    corners = np.array([low, (high[0], low[1]), high, (low[0], high[1])])
    title = f"{robot.name}: reach of the pen at z = {height:.2f} m; box: the drawing; cross: the base"
    return reach_picture.to_png(
        reach.margin.max((0, 1))[0], reach.x_m, reach.y_m, planned.placement.points_m(corners)[:, :2], title
    )


def _lines(report: dict[str, Any]) -> list[str]:
    x, y, z = (row[3] for row in report["base_from_paper"][:3])
    lines = [
        f"{report['robot']}: {report['seconds']:.0f} s for {many(report['strokes'], 'stroke')},"
        f" {report['ink_s']:.0f} s of them from the first ink to the last",
        f"sheet: lower left corner at ({x:.3f}, {y:.3f}, {z:.3f}) m; joints stay {report['margin_deg']:.0f} deg from"
        f" their limits, use {100 * report['velocity_used']:.0f} % of their speed and"
        f" {100 * report['acceleration_used']:.0f} % of their acceleration",
    ]
    if report["pens"] > 1:
        lines.append(
            f"the drawing has {report['pens']} pens and the arm holds one: everything is drawn with it;"
            " for colours plan a drawing of each pen by itself"
        )
    if "tilt_deg" in report:
        lines.append(
            f"probed: {report['probed_used']} of {report['probed']} points fit a plane to"
            f" {report['residual_mm']:.2f} mm, tilted by {report['tilt_deg']:.2f} deg"
        )
    return [*lines, *report["out"]]
