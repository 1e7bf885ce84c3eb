"""The strokes of a plan go in; the motion comes out with which the thesis's arm drew them, trails and gaps and all."""

from __future__ import annotations

import numpy as np

from limner import geometry, transforms
from limner.errors import CannotDraw
from limner.motion.arm.ik import inverse
from limner.motion.arm.retime import RetimeSettings, joined, move
from limner.motion.arm.robot import Robot
from limner.simulation.outcome import Simulation, follow
from limner.simulation.pictures import Picture, overlay_picture
from limner.simulation.settings import FaultSettings
from limner.simulation.sheet import Sheet
from limner.targets.sheet import Tile, to_sheet
from limner.types import Floats, JointTrajectory, Pen

LIFT_MM = 10.0
STIFF_PRESS_MM = 0.3
"""So that a stiff pen writes at all; the thesis gives neither."""

MISS_MM = 1.0
"""The arm misses by up to this (section 4.4)."""

_BEND_MM = 0.2
"""Points are where a stroke bends by this."""


def beside_the_thesis(made: Simulation, pen: Pen) -> Picture:
    """A sheet (H, W, 3) of the thesis's way, with a stiff and with a sprung pen, and ours, of an arm that misses.

    Args:
        made: ours, as it was simulated; its faults but the misses are left out.
        pen: whose ink is shown.

    Raises:
        CannotDraw: as ``thesis_motion``.
    """
    settings = made.settings.replace(fault=FaultSettings(repeat_mm=MISS_MM, seed=made.settings.fault.seed))
    down = made.trajectory.q[made.trajectory.down][0]
    orientation = made.robot.forward(down)[:3, :3]

    def theirs(stiff: bool, press_mm: float) -> Simulation:
        motion = thesis_motion(made.plan_mm, made.sheet, orientation, made.robot, press_mm)
        return follow(motion, made.robot, made.sheet, settings.replace(stiff=stiff))

    tiles = [
        ("the thesis's way, a stiff pen", theirs(True, STIFF_PRESS_MM)),
        ("the thesis's way, a sprung pen", theirs(False, made.press_mm)),
        ("limner, a sprung pen", follow(made.trajectory, made.robot, made.sheet, settings.replace(stiff=False))),
    ]
    return to_sheet([Tile(overlay_picture(one, pen), title, _told(one)) for title, one in tiles], 3, 540)


def _upright(orientation: Floats, sheet: Sheet) -> Floats:
    """The orientation (3, 3) nearest to one, of a pen that stands upright on a sheet."""
    pen, down = orientation[:, 2], -sheet.base_from_paper[:3, 2]
    about = np.cross(pen, down)
    sine = float(np.linalg.norm(about))
    turned: Floats = transforms.rotation(about / max(sine, 1e-12), np.arctan2(sine, pen @ down)) @ orientation
    return turned


def _told(made: Simulation) -> str:
    report = made.report()
    return f"touches for {report['contact_percent']:.0f} %, {report['travel_ink_mm']:.0f} mm of ink in travel"


def thesis_motion(
    plan_mm: dict[int, Floats], sheet: Sheet, orientation: Floats, robot: Robot, press_mm: float
) -> JointTrajectory:
    """Point after point, at rest at each, the joints moved evenly from one to the next (section 4.4).

    After a stroke the arm goes at once, on a slant, to above the next one: "it moves both on the vertical and
    horizontal planes simultaneously".

    Args:
        plan_mm: strokes (n, 2) in the paper frame, by index.
        sheet: where it is taken to lie.
        orientation: (3, 3) of the pen in the base frame; it is held upright otherwise like this.
        robot: that moves.
        press_mm: how far below the sheet the tip is led.

    Raises:
        CannotDraw: a point cannot be reached.
        MissingExtra: a package of the extra ``robot`` is not installed.
    """
    places, stroke = [], []
    for index, line in plan_mm.items():
        points = geometry.simplify(line, _BEND_MM)
        heights = np.r_[LIFT_MM, np.full(len(points), -press_mm)]
        places.append(np.column_stack([points[[0, *range(len(points))]], heights]))
        stroke += [-1, -1, *[index] * (len(points) - 1)]
    places.append(places[-1][-1:] + np.array([0, 0, LIFT_MM]))
    stroke.append(-1)
    tips = transforms.transform(_upright(orientation, sheet), sheet.points_m(np.concatenate(places)))
    q, _ = inverse(robot).follow(tips)
    if q is None:
        raise CannotDraw("simulate: the thesis's way to these points cannot be reached")
    parts = []
    for a, b, index in zip(q[:-1], q[1:], stroke[1:], strict=True):
        if np.abs(b - a).max() > 1e-9:
            way = move(robot, a, b, RetimeSettings())
            count = len(way.t_s)
            parts.append(
                JointTrajectory(
                    way.names, way.t_s, way.q, way.qd, way.qdd, np.full(count, index >= 0), np.full(count, index)
                )
            )
    return joined(parts)
