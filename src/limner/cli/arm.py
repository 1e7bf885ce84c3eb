"""``limner plan --robot``: a drawing and an arm in, the checked motion of its joints out."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import click
import numpy as np

from limner import storage, transforms
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


def plan(
    drawing: str,
    robot: str,
    settings: Settings,
    *,
    out: tuple[str, ...],
    bags: tuple[str, ...],
    calibration: str | None,
    waypoints: str | None,
    reach: str | None,
    as_json: bool,
) -> None:
    """Plan, write what was asked for, and tell.

    Args:
        drawing: file of the drawing.
        robot: name or URDF.
        settings: of the plan and of URScript.
        out: files for the trajectory.
        bags: bags of ROS to write.
        calibration: file of probed points, or None.
        waypoints: file for the poses of the pen, or None.
        reach: file for the map of the reach, or None.
        as_json: print the report as JSON.

    Raises:
        LimnerError: whatever stands in the way.
    """
    for file in out:
        joints.check_format(file, FORMATS)
    for file in bags:
        bag.check(file)
    table = joints.waypoints_format(waypoints) if waypoints else ""
    arm = load_robot(robot)
    found = read_calibration(calibration) if calibration else None
    drawn = read_drawing(drawing)
    planned = plan_arm(drawn, arm, settings.arm, found[0] if found else None)
    report = planned.report() | {"pens": len(np.unique(drawn.layer))} | (found[1] if found else {})
    tips = tip_poses(planned)
    for file in out:
        if Path(file).suffix.lower() == urscript.SUFFIX:
            storage.write_whole(file, urscript.to_urscript(planned.trajectory, tips[:, :3], settings.ur))
        else:
            joints.save(planned.trajectory, file)
    for file in bags:
        bag.save(_recording(planned, drawn), file)
    if waypoints:
        poses = joints.waypoints(planned.trajectory, tips)
        storage.write_whole(waypoints, joints.waypoints_bytes(poses, arm.base, table))
    if reach:
        storage.write_whole(reach, _reach_png(arm, planned, settings.arm))
    report["out"] = [*out, *bags, *filter(None, (waypoints, reach))]
    if as_json:
        click.echo(json.dumps(report))
        return
    for line in _lines(report):
        click.echo(line, err=True)


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
        f"{report['robot']}: {report['seconds']:.0f} s for {report['strokes']} strokes,"
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
