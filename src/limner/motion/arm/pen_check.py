"""The motion of an arm goes in; an error comes out where its pen is too fast, too low or off the sheet."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from limner import transforms
from limner.errors import BadInput, CannotDraw
from limner.motion.arm.check import TOLERANCE, check
from limner.motion.arm.lifted import LiftSettings
from limner.motion.arm.paper import plane_of
from limner.motion.arm.retime import RetimeSettings
from limner.motion.arm.robot import Robot
from limner.types import Floats, JointTrajectory

SLACK_MM = 0.5
"""How far the tip may be from where it should be: corners are rounded, and splines swing a little."""

SINK_MM = 0.05
"""A lifted tip this far below the sheet is in it."""

_NOWHERE_M = 1000.0  # below the base: the sheet of a motion that neither draws nor says where one is


@dataclass(frozen=True)
class Allowed:
    """How fast the tip may draw [mm/s], and how far below the sheet it may be led [mm]."""

    pen_speed: float = RetimeSettings().pen_speed
    press_mm: float = LiftSettings().press_mm


USUAL = Allowed()


@dataclass(frozen=True, eq=False)
class PenLimits:
    """What a pen may do.

    Attributes:
        base_from_paper: (4, 4) the sheet, z out of it [m].
        size_mm: (2,) of the sheet, or None where nobody says.
        allowed: speed and press.
    """

    base_from_paper: Floats
    size_mm: Floats | None
    allowed: Allowed


def check_motion(motion: JointTrajectory, robot: Robot, allowed: Allowed = USUAL) -> PenLimits:
    """Refuse a motion that exceeds a limit of the joints or of the pen; whatever comes from outside goes through here.

    Args:
        motion: from any source.
        robot: that shall follow it.
        allowed: what its pen may do at most.

    Returns:
        The limits of the pen, for parts of the motion.

    Raises:
        CannotDraw: a limit is exceeded: which, when, by how much.
        BadInput: its pen-down places lie in no plane, and it does not say where its sheet is; or that is no sheet.
    """
    check(motion, robot)
    limits = pen_limits(motion, robot, allowed)
    check_pen(motion, robot, limits)
    return limits


def pen_limits(motion: JointTrajectory, robot: Robot, allowed: Allowed) -> PenLimits:
    """The limits of a motion's pen: over the sheet that it names, else over the plane of its pen-down places.

    Raises:
        BadInput: they lie in no plane, or the sheet that it names is none.
    """
    if len(motion.sheet_m):
        frame, size = _sheet(motion.sheet_m)
        return PenLimits(frame, size, allowed)
    if not motion.down.any():
        return PenLimits(transforms.transform(translation=(0.0, 0.0, -_NOWHERE_M)), None, allowed)
    turn, middle = plane_of(robot.forward(motion.q[motion.down]))
    # The tip is led in a plane that lies below the sheet by the press.
    level = middle + turn[:, 2] * motion.press_mm / 1000
    return PenLimits(transforms.transform(turn, level), None, allowed)


def _sheet(corners_m: Floats) -> tuple[Floats, Floats]:
    """Frame (4, 4) and size (2,) [mm] of a sheet, from its corners.

    Raises:
        BadInput: they are none of a rectangle.
    """
    corner, right, opposite, up = corners_m
    sides = np.stack([right - corner, up - corner])
    size = np.linalg.norm(sides, axis=1)
    askew = np.append(right + up - corner - opposite, sides[0] @ sides[1] / max(float(size.max()), 1e-9))
    if size.min() < 1e-3 or np.abs(askew).max() > SLACK_MM / 1000:
        raise BadInput("trajectory: sheet_m is no rectangle; expected its four corners, counter-clockwise")
    x, y = sides / size[:, None]
    return transforms.transform(np.stack([x, y, np.cross(x, y)], axis=1), corner), 1000 * size


def check_pen(motion: JointTrajectory, robot: Robot, limits: PenLimits) -> None:
    """Refuse a motion whose pen leaves its limits at any sample, or is too fast between samples.

    Raises:
        CannotDraw: what is wrong, when, by how much.
    """
    tips = transforms.inverse(limits.base_from_paper) @ robot.forward(motion.q)
    places = 1000 * tips[:, :3, 3]
    _check_speed(motion, places, limits)
    _check_height(motion, places[:, 2], limits)
    pen = tips[:, :3, 2]
    # A tip below the sheet has pushed the pen in along its axis: there is where it touches.
    level = places[:, 2:] * (places[:, 2:] < 0)
    flat = places[:, :2] - pen[:, :2] / pen[:, 2:] * level if (pen[:, 2] < 0).all() else places[:, :2]
    _check_page(motion, flat, limits)
    _check_trails(motion, flat, places[:, 2])


def _check_speed(motion: JointTrajectory, places: Floats, limits: PenLimits) -> None:
    way = np.linalg.norm(np.diff(places, axis=0), axis=1) * motion.down[1:]
    # Not divided: where no time passes nothing may move.
    allowed = limits.allowed.pen_speed * (1 + TOLERANCE) * np.diff(motion.t_s) + 1e-6
    if (way > allowed).any():
        k = int((way - allowed).argmax())
        seconds = max(float(motion.t_s[k + 1] - motion.t_s[k]), 1e-9)
        raise CannotDraw(
            f"trajectory: the pen draws at {way[k] / seconds:.0f} mm/s at {motion.t_s[k]:.2f} s, over its limit of"
            f" {limits.allowed.pen_speed:g} mm/s; plan it slower, or allow it with arm.retime.pen_speed"
        )


def _check_height(motion: JointTrajectory, height: Floats, limits: PenLimits) -> None:
    lowest = int(height.argmin())
    if height[lowest] < -limits.allowed.press_mm - SLACK_MM:
        raise CannotDraw(
            f"trajectory: the pen's tip goes {-height[lowest]:.1f} mm below the sheet at {motion.t_s[lowest]:.2f} s,"
            f" expected at most {limits.allowed.press_mm:g} mm; look where the sheet lies, or allow it with"
            " arm.lift.press_mm"
        )
    if (drawn := np.flatnonzero(motion.down & (height > SLACK_MM))).size:
        k = drawn[0]
        raise CannotDraw(
            f"trajectory: the pen draws {height[k]:.1f} mm above the sheet at {motion.t_s[k]:.2f} s; it is not for"
            " this sheet"
        )


def _check_page(motion: JointTrajectory, flat: Floats, limits: PenLimits) -> None:
    if limits.size_mm is None:
        return
    beyond = np.maximum(-flat, flat - limits.size_mm).max(1) * motion.down
    if (worst := int(beyond.argmax()), beyond.max())[1] > SLACK_MM:
        x, y = flat[worst]
        width, height = limits.size_mm
        raise CannotDraw(
            f"trajectory: the pen draws at ({x:.0f}, {y:.0f}) mm at {motion.t_s[worst]:.2f} s, off its page of"
            f" {width:.0f} x {height:.0f} mm"
        )


def _check_trails(motion: JointTrajectory, flat: Floats, height: Floats) -> None:
    """In travel the tip is in the sheet only straight over where a stroke ended, or the next one begins."""
    sunk = np.flatnonzero(~motion.down & (height < -SINK_MM))
    away = np.full(len(sunk), np.inf)
    for ends, step in _neighbours(motion.down):
        at = np.searchsorted(ends, sunk) + step
        known = (at >= 0) & (at < len(ends))
        away[known] = np.minimum(away[known], np.hypot(*(flat[sunk[known]] - flat[ends[at[known]]]).T))
    if (away > SLACK_MM).any():
        k = sunk[int(away.argmax())]
        raise CannotDraw(
            f"trajectory: in travel the pen's tip is {-height[k]:.1f} mm below the sheet at {motion.t_s[k]:.2f} s, away"
            " from the strokes; it would leave a trail or hit what lies there"
        )


def _neighbours(down: NDArray[np.bool_]) -> list[tuple[NDArray[np.int64], int]]:
    """Samples at which strokes end and begin, and which of them is next to a sample that is sorted in."""
    change = np.diff(down.astype(np.int8), prepend=0, append=0)
    ends, begins = np.flatnonzero(change < 0) - 1, np.maximum(np.flatnonzero(change > 0) - 1, 0)
    return [(ends, -1), (begins, 0)]
