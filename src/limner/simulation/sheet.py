"""The motion of an arm goes in; where it takes its paper to lie comes out, from its pen-down places alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from limner import transforms
from limner.errors import BadInput
from limner.motion.arm.paper import plane_of
from limner.motion.arm.robot import Robot
from limner.simulation.settings import FaultSettings
from limner.types import Drawing, Floats, JointTrajectory, Page, Value, frozen_array

MARGIN_MM = 10.0
"""White around the ink where nobody says how large the sheet is."""

_SAME_MM = 2.0
"""A drawing is the one of a motion if their strokes lie this close (root mean square)."""


@dataclass(frozen=True, eq=False)
class Sheet(Value):
    """Where a sheet lies.

    Attributes:
        base_from_paper: (4, 4) origin at the lower left corner, x right, y up the sheet, z out of it [m].
        page: its size.
    """

    base_from_paper: Floats
    page: Page

    def __post_init__(self) -> None:
        self._freeze("base_from_paper", frozen_array(self.base_from_paper, np.float64, (4, 4), "base_from_paper"))

    def points_mm(self, points_m: Floats) -> Floats:
        """Points (..., 3) of the base frame [m] in the paper frame [mm]."""
        return 1000 * transforms.apply(transforms.inverse(self.base_from_paper), points_m)

    def points_m(self, points_mm: Floats) -> Floats:
        """Points (..., 2) or (..., 3) of the paper frame [mm] in the base frame [m]."""
        points = np.asarray(points_mm) / 1000
        if points.shape[-1] == 2:
            points = np.concatenate([points, np.zeros((*points.shape[:-1], 1))], axis=-1)
        return transforms.apply(self.base_from_paper, points)

    def touched_mm(self, tips: Floats) -> Floats:
        """Where (..., 2) pens with their tips at poses (..., 4, 4) touch the sheet when they slide in or out."""
        local = transforms.inverse(self.base_from_paper) @ tips
        pen, tip = local[..., :3, 2], local[..., :3, 3]
        touched: Floats = 1000 * (tip[..., :2] - pen[..., :2] * (tip[..., 2:] / pen[..., 2:]))
        return touched

    def faulty(self, fault: FaultSettings) -> Sheet:
        """Where it really lies."""
        middle = np.array([self.page.width_mm, self.page.height_mm, 0.0]) / 2000
        towards = np.radians(fault.tilt_towards_deg)
        # Turning about this axis raises the sheet in the direction that was asked for.
        axis = np.array([np.sin(towards), -np.cos(towards), 0.0])
        tilt = transforms.rotation(axis, np.radians(fault.tilt_deg))
        about_middle = transforms.transform(tilt, middle - tilt @ middle + [0, 0, fault.paper_mm / 1000])
        return Sheet(self.base_from_paper @ about_middle, self.page)


def stroke_tips(trajectory: JointTrajectory, robot: Robot) -> dict[int, Floats]:
    """Poses (n, 4, 4) in the base frame that the motion leads the pen's tip through, for each stroke."""
    tips = robot.forward(trajectory.q)
    strokes: dict[int, Floats] = {}
    for index in np.unique(trajectory.stroke[trajectory.down]):
        samples = np.flatnonzero(trajectory.down & (trajectory.stroke == index))
        # A sample says whether the move that ends there draws: the stroke starts at the sample before.
        strokes[int(index)] = tips[np.r_[max(0, samples[0] - 1), samples]]
    return strokes


def find_sheet(trajectory: JointTrajectory, robot: Robot, press_mm: float, drawing: Drawing | None = None) -> Sheet:
    """The sheet that a motion was planned for: the plane of its pen-down places, less the planned press.

    A trajectory says nothing else about its sheet. With the drawing that it draws the sheet's corner, turn and size
    are found too; without, x is the base's x as seen along the sheet, and the sheet ends a margin beyond the ink.

    Args:
        trajectory: the motion.
        robot: that moves.
        press_mm: how far below the sheet the tip is led.
        drawing: what is drawn.

    Raises:
        BadInput: the pen is never down, is led over no plane, or the drawing is another one.
    """
    strokes = stroke_tips(trajectory, robot)
    if not strokes:
        raise BadInput("trajectory: the pen is never down; there is nothing to simulate")
    turn, middle = plane_of(np.concatenate(list(strokes.values())))
    found = Sheet(transforms.transform(turn, middle + turn[:, 2] * press_mm / 1000), Page())
    flat = {index: found.touched_mm(tips) for index, tips in strokes.items()}
    if drawing is not None:
        on_page, corner = _registered(flat, drawing)
        page = drawing.page
    else:
        inked = np.concatenate(list(flat.values()))
        corner, (width, height) = inked.min(0) - MARGIN_MM, np.ptp(inked, axis=0) + 2 * MARGIN_MM
        on_page, page = np.eye(3), Page(float(width), float(height), 0.0)
    return Sheet(transforms.transform(turn @ on_page, found.points_m(corner)), page)


def _registered(flat: dict[int, Floats], drawing: Drawing) -> tuple[Floats, Floats]:
    """Turn (3, 3) and corner (2,) [mm] of the page in the plane's axes (Kabsch 1976, doi:10.1107/S0567739476001873)."""
    if max(flat) >= len(drawing.lines_mm):
        raise BadInput(
            f"drawing: has {len(drawing.lines_mm)} strokes, the trajectory draws stroke {max(flat) + 1};"
            " expected the drawing that it was planned for"
        )
    there = np.concatenate([_evenly(points) for points in flat.values()])
    page = np.concatenate([_evenly(drawing.lines_mm[index]) for index in flat])
    a, b = there - there.mean(0), page - page.mean(0)
    u, _, vt = np.linalg.svd(b.T @ a)
    turn = vt.T @ np.diag([1.0, np.sign(np.linalg.det(vt.T @ u.T))]) @ u.T
    corner: Floats = there.mean(0) - turn @ page.mean(0)
    apart = float(np.sqrt(((there - corner - page @ turn.T) ** 2).sum(1).mean()))
    if apart > _SAME_MM:
        raise BadInput(
            f"drawing: its strokes lie {apart:.0f} mm from those of the trajectory;"
            " expected the drawing that it was planned for"
        )
    whole = np.eye(3)
    whole[:2, :2] = turn
    return whole, corner


def _evenly(line: Floats, count: int = 20) -> Floats:
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    t = np.linspace(0, along[-1], count)
    return np.stack([np.interp(t, along, line[:, 0]), np.interp(t, along, line[:, 1])], axis=1)
