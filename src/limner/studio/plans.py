"""A drawing and what is to draw it go in; the plan as the page plays it comes out: numbers and a frame."""

from __future__ import annotations

import dataclasses
from importlib import resources
from typing import Any

import numpy as np

from limner import transforms
from limner.errors import BadInput, CannotDraw
from limner.motion.area import check_area
from limner.motion.arm.ik import inverse
from limner.motion.arm.paper import Placement
from limner.motion.arm.place import AUTO, THESIS, parse_place
from limner.motion.arm.plan import plan_arm
from limner.motion.arm.robot import Robot
from limner.motion.arm.robots import ROBOTS, load_robot
from limner.motion.machine import MACHINES, Machine, load_machine
from limner.motion.pen import plan
from limner.pipeline import Settings
from limner.studio.frames import plan_frame
from limner.types import Drawing, JointTrajectory

CLEAR_MM = 15.0
"""How high over the sheet an arm leads its pen around a drawing."""

_LOOKED_AT = 600  # points, for what of a sheet cannot be reached


def planned(drawing: Drawing, by: dict[str, Any], settings: Settings, rev: int) -> dict[str, Any]:
    """How a machine or a robot draws.

    Args:
        drawing: what to draw.
        by: ``{"machine": name}`` or ``{"robot": name}``.
        settings: of the plan.
        rev: of the request.

    Returns:
        ``plan``, and ``frame`` or ``error``.
    """
    if by.get("robot") is not None:
        return _by_robot(drawing, known(by["robot"], ROBOTS, "robot"), settings, rev)
    return _by_machine(drawing, known(by.get("machine") or settings.machine, MACHINES, "machine"), rev)


def known(name: Any, names: tuple[str, ...], what: str) -> str:
    """A name that is one of these; files of this computer are no choice of the page's.

    Raises:
        BadInput: it is none.
    """
    if name not in names:
        raise BadInput(f"{what}: '{str(name)[:80]}' is not known; choose {', '.join(names)}")
    return str(name)


def _by_machine(drawing: Drawing, name: str, rev: int) -> dict[str, Any]:
    machine = load_machine(name)
    told: dict[str, Any] = {"by": "machine", "name": name, "lines": len(drawing.lines_mm), "unreachable": []}
    path = plan(drawing, machine)
    told["seconds"] = float(path.t_s[-1])
    try:
        check_area(drawing, machine)
    except CannotDraw as error:
        return {"plan": told | {"unreachable": _outside(drawing, machine)}, "error": str(error)}
    frame = plan_frame(rev, drawing.page.height_mm, path.t_s, path.position_mm[:, :2], path.stroke, path.down)
    return {"plan": told, "frame": frame}


def _outside(drawing: Drawing, machine: Machine) -> list[int]:
    """Indices of the lines that leave the work area."""
    high, area = drawing.page.height_mm, [machine.width_mm, machine.height_mm]
    turned = machine.home == "upper-left"
    places = [[0, high] + line * [1, -1] if turned else line for line in drawing.lines_mm]
    return [i for i, line in enumerate(places) if (line < 0).any() or (line > area).any()]


def _by_robot(drawing: Drawing, name: str, settings: Settings, rev: int) -> dict[str, Any]:
    robot = load_robot(name)
    told: dict[str, Any] = {"by": "robot", "name": name, "lines": len(drawing.lines_mm), "joints": list(robot.joints)}
    try:
        made = plan_arm(drawing, robot, settings.arm)
    except CannotDraw as error:
        placed = _given_place(drawing, settings)
        where = {"base_from_paper": placed.base_from_paper.tolist()} if placed else {}
        return {
            "plan": told | where | {"unreachable": unreachable(drawing, robot, settings, placed)},
            "error": str(error),
        }
    told |= {key: value for key, value in made.report().items() if key not in ("robot", "planning_s")}
    motion = made.trajectory
    places = made.placement.points_mm(robot.forward(motion.q)[:, :3, 3])[:, :2]
    frame = plan_frame(rev, drawing.page.height_mm, motion.t_s, places, motion.stroke, motion.down, motion.q)
    return {"plan": told | {"unreachable": []}, "frame": frame}


def _given_place(drawing: Drawing, settings: Settings) -> Placement | None:
    """Where the sheet was to lie; None where it was limner's to find."""
    place, page = settings.arm.place, drawing.page
    if place.at in (AUTO, THESIS):
        return None
    return parse_place(place.at, (page.width_mm, page.height_mm), place.spin_deg)


def unreachable(drawing: Drawing, robot: Robot, settings: Settings, placed: Placement | None) -> list[int]:
    """Indices of the lines that the pen does not reach, where the sheet was given a place; else all of them."""
    lines = drawing.lines_mm
    if placed is None:
        return list(range(len(lines)))
    step = max(1, drawing.points // _LOOKED_AT)
    some = [np.concatenate([line[::step], line[-1:]]) for line in lines]
    points = np.concatenate(some)
    margins = inverse(robot, settings.arm.inverse).margins(placed.tips(points))
    of_line = np.repeat(np.arange(len(lines)), [len(line) for line in some])
    return sorted(set(of_line[margins < 0].tolist()))


def robot_fields(name: str) -> dict[str, Any]:
    """A robot as the page shows it: the chain of its joints and the shapes of its links [m, rad]."""
    robot = load_robot(known(name, ROBOTS, "robot"))
    links = [robot.base, *(f"link{i + 1}" for i in range(robot.dof)), robot.tip]
    joints = [_joint(robot, i, links) for i in range(robot.dof)]
    end = {"name": "pen", "type": "fixed", "parent": links[-2], "child": links[-1], "axis": [0.0, 0.0, 1.0]}
    shapes: dict[str, list[Any]] = {link: [] for link in links}
    for capsule in robot.capsules:
        ends = {"start": capsule.start_m.tolist(), "end": capsule.end_m.tolist(), "radius": capsule.radius_m}
        shapes[links[capsule.link]].append({"type": "capsule", **ends})
    return {
        "name": name,
        "base": robot.base,
        "tip": robot.tip,
        "joints": [*joints, end | _origin(robot.before[-1])],
        "links": [{"name": link, "shapes": shapes[link]} for link in links],
        "poses": {pose: q.tolist() for pose, q in robot.poses.items()},
    }


def _joint(robot: Robot, i: int, links: list[str]) -> dict[str, Any]:
    """A joint that moves, between two of the links."""
    return {
        "name": robot.joints[i],
        "type": "prismatic" if robot.prismatic[i] else "revolute",
        "parent": links[i],
        "child": links[i + 1],
        **_origin(robot.before[i]),
        "axis": robot.axes[i].tolist(),
        "lower": float(robot.lower[i]),
        "upper": float(robot.upper[i]),
        "velocity": float(robot.velocity[i]),
    }


def _origin(frame: Any) -> dict[str, list[float]]:
    """A fixed transform as URDF has it: rpy about fixed axes."""
    turn = frame[:3, :3]
    pitch = np.arctan2(-turn[2, 0], np.hypot(turn[0, 0], turn[1, 0]))
    if np.hypot(turn[0, 0], turn[1, 0]) > 1e-9:
        roll, yaw = np.arctan2(turn[2, 1], turn[2, 2]), np.arctan2(turn[1, 0], turn[0, 0])
    else:
        roll, yaw = np.arctan2(-turn[1, 2], turn[1, 1]), 0.0
    return {"xyz": frame[:3, 3].tolist(), "rpy": [float(roll), float(pitch), float(yaw)]}


def trajectory(drawing: Drawing, name: str, settings: Settings, *, frame_only: bool = False) -> JointTrajectory:
    """The checked motion of a robot's joints.

    Args:
        drawing: what to draw.
        name: of the robot.
        settings: of the plan.
        frame_only: lead the pen around the drawing instead, ``CLEAR_MM`` above the sheet.

    Raises:
        CannotDraw: it cannot be reached, or a limit would be exceeded.
    """
    robot = load_robot(known(name, ROBOTS, "robot"))
    made = plan_arm(drawing, robot, settings.arm)
    if not frame_only:
        return made.trajectory
    above = made.placement.base_from_paper @ transforms.transform(translation=(0, 0, CLEAR_MM / 1000))
    placed = dataclasses.replace(made.placement, base_from_paper=above)
    return plan_arm(frame_of(drawing), robot, settings.arm, placed).trajectory


def frame_of(drawing: Drawing) -> Drawing:
    """The rectangle around a drawing, as its only line."""
    points = np.concatenate(drawing.lines_mm)
    (x0, y0), (x1, y1) = points.min(0), points.max(0)
    line = np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0)])
    return Drawing((line,), ("background",), np.ones(1), drawing.page, drawing.pens[:1])


def urdf(name: str) -> bytes:
    """The description of a robot that comes with limner."""
    return (resources.files("limner.motion.arm.robots") / f"{known(name, ROBOTS, 'robot')}.urdf").read_bytes()
