"""The motion of an arm goes in; where it takes its paper to lie comes out, from its pen-down places alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from limner import transforms
from limner.errors import BadInput
from limner.motion.arm.robot import Robot
from limner.simulation.settings import FaultSettings
from limner.types import Drawing, Floats, JointTrajectory, Page, Value, frozen_array

MARGIN_MM = 10.0
"""White around the ink where nobody says how large the sheet is."""

_FLAT_MM = 1.0
"""Pen-down places farther than this from their plane lie on no sheet."""

_SPREAD_MM = 3.0
"""Places less wide than this tell no plane; the pen's axis does."""

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

    def faulty(self, fault: FaultSettings) -> Sheet:
        """Where it really lies."""
        middle = np.array([self.page.width_mm, self.page.height_mm, 0.0]) / 2000
        towards = np.radians(fault.tilt_towards_deg)
        # Turning about this axis raises the sheet in the direction that was asked for.
        axis = np.array([np.sin(towards), -np.cos(towards), 0.0])
        tilt = transforms.rotation(axis, np.radians(fault.tilt_deg))
        about_middle = transforms.transform(tilt, middle - tilt @ middle + [0, 0, fault.paper_mm / 1000])
        return Sheet(self.base_from_paper @ about_middle, self.page)


def strokes_m(trajectory: JointTrajectory, robot: Robot) -> dict[int, Floats]:
    """Where (n, 3) the motion leads the pen's tip for each stroke [m], in the base frame."""
    tips = robot.forward(trajectory.q)[:, :3, 3]
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
    strokes = strokes_m(trajectory, robot)
    if not strokes:
        raise BadInput("trajectory: the pen is never down; there is nothing to simulate")
    turn, middle = _plane(np.concatenate(list(strokes.values())), trajectory, robot)
    flat = {index: 1000 * (points - middle) @ turn for index, points in strokes.items()}
    if drawing is not None:
        on_page, corner = _registered(flat, drawing)
        page = drawing.page
    else:
        inked = np.concatenate(list(flat.values()))[:, :2]
        corner, (width, height) = inked.min(0) - MARGIN_MM, np.ptp(inked, axis=0) + 2 * MARGIN_MM
        on_page, page = np.eye(3), Page(float(width), float(height), 0.0)
    lowest = middle + turn @ [*corner / 1000, press_mm / 1000]
    return Sheet(transforms.transform(turn @ on_page, lowest), page)


def _plane(points: Floats, trajectory: JointTrajectory, robot: Robot) -> tuple[Floats, Floats]:
    """Axes (3, 3) of the plane, its normal against the pen, and a point of it (3,) [m]."""
    middle = points.mean(0)
    _, spread, axes = np.linalg.svd(points - middle, full_matrices=False)
    spread = 1000 * spread / np.sqrt(len(points))
    pen = robot.forward(trajectory.q[trajectory.down])[:, :3, 2].mean(0)
    if len(spread) < 3 or spread[1] < _SPREAD_MM:
        normal = -pen / np.linalg.norm(pen)
    else:
        normal = -axes[2] * np.sign(axes[2] @ pen)
    off = 1000 * float(np.abs((points - middle) @ normal).max())
    if off > _FLAT_MM:
        raise BadInput(
            f"trajectory: its pen-down places lie up to {off:.1f} mm off their plane, expected at most {_FLAT_MM:g};"
            " it does not draw on a flat sheet"
        )
    along = np.eye(3)[0] if abs(normal[0]) < 0.9 else np.eye(3)[1]
    x = along - (along @ normal) * normal
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(normal, x), normal], axis=1), middle


def _registered(flat: dict[int, Floats], drawing: Drawing) -> tuple[Floats, Floats]:
    """Turn (3, 3) and corner (2,) [mm] of the page in the plane's axes (Kabsch 1976, doi:10.1107/S0567739476001873)."""
    if max(flat) >= len(drawing.lines_mm):
        raise BadInput(
            f"drawing: has {len(drawing.lines_mm)} strokes, the trajectory draws stroke {max(flat) + 1};"
            " expected the drawing that it was planned for"
        )
    there = np.concatenate([_evenly(points[:, :2]) for points in flat.values()])
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
