"""An arm and a sheet go in; where the sheet can lie so that all of it is reached comes out, or why it cannot."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from limner import transforms
from limner.errors import BadInput, CannotDraw
from limner.motion.arm.ik import Inverse
from limner.motion.arm.paper import Placement, leant
from limner.motion.arm.robot import Robot
from limner.settings import SettingsGroup, setting
from limner.types import Floats

AUTO = "auto"
THESIS = "thesis"

THESIS_TABLE_M = -0.3
"""Height of the table where the thesis's area is asked for and no height (assumed)."""


@dataclass(frozen=True)
class PlaceSettings(SettingsGroup):
    """Where the sheet lies, in the robot's base frame."""

    at: str = setting(
        AUTO,
        "centre of the sheet and its turn: x,y,z in metres and degrees, such as -0.4,0.3,-0.45,90; auto: search;"
        " thesis: scaled and turned into Dumbo's drawing area in the thesis",
    )
    table_m: float | None = setting(
        None, "height of the table in the base frame, for auto; not set: any", unit="m", low=-10, high=10
    )
    spin_deg: float | None = setting(
        None, "turn of the tool about the pen; not set: whatever suits best", unit="deg", low=-360, high=360
    )
    lean_deg: float = setting(0.0, "the pen may lean up to this from upright, for reach", unit="deg", low=0, high=45)
    tries: int = setting(6, "places that are compared by the time the arm takes there", low=1, high=100)
    swing_deg: float = setting(
        8.0,
        "the pen leans by up to this towards the middle of the drawing, so that the hand moves less than the pen;"
        " 0: the same everywhere, as in the thesis",
        unit="deg",
        low=0,
        high=30,
    )
    step_m: float = setting(0.05, "grid of the search", unit="m", low=0.01, high=0.2)


@dataclass(frozen=True, eq=False)
class ReachMap:
    """How well each place can be drawn at.

    Attributes:
        x_m, y_m, z_m: (nx,), (ny,), (nz,) grid in the base frame.
        spin_rad: (ns,) turns of the tool.
        lean_rad: (nl,) leans of the pen, its upper end towards the arm's first joint.
        arm_m: (3,) where that is.
        margin: (nl, ns, nz, ny, nx) distance to the nearest limit [rad], negative or -inf where not reached.
    """

    x_m: Floats
    y_m: Floats
    z_m: Floats
    spin_rad: Floats
    lean_rad: Floats
    arm_m: Floats
    margin: Floats


def reach_map(robot: Robot, arm: Inverse, settings: PlaceSettings) -> ReachMap:
    """How well the pen can be held, pointing down, at each point of a grid around the arm."""
    if not arm.quick:
        settings = settings.replace(step_m=max(settings.step_m, 0.1), spin_deg=settings.spin_deg or 0.0)
    centre, reach = _reach(robot)
    low, high = (
        np.maximum(centre - reach, robot.sheet_box_m[0] - 0.2),
        np.minimum(centre + reach, robot.sheet_box_m[1] + 0.2),
    )
    x, y = (np.arange(low[k], high[k] + settings.step_m, settings.step_m) for k in range(2))
    z = np.arange(robot.sheet_box_m[0, 2].clip(low[2]), high[2] - 0.2 + 1e-9, 2 * settings.step_m)
    if settings.table_m is not None:
        z = np.array([settings.table_m])
    spins = np.radians([settings.spin_deg] if settings.spin_deg is not None else np.arange(0, 360, 60))
    leans = np.radians(sorted({0.0, settings.lean_deg / 2, settings.lean_deg}))
    points = np.stack(np.meshgrid(z, y, x, indexing="ij")[::-1], axis=-1).reshape(-1, 3)
    near = np.linalg.norm(points - centre, axis=1) < reach
    margin = np.full((len(leans), len(spins), len(points)), -np.inf)
    for k, lean in enumerate(leans):
        for s, spin in enumerate(spins):
            upright = Placement(np.eye(4), float(spin)).tips(1000 * points[near])
            leaning = transforms.transform(leant(lean, _towards(points[near], centre)))
            margin[k, s, near] = arm.margins(_about(points[near], leaning) @ upright)
    return ReachMap(x, y, z, spins, leans, centre, margin.reshape(len(leans), len(spins), len(z), len(y), len(x)))


def _towards(points_m: Floats, centre_m: Floats) -> Floats:
    """Direction (...) in the base's x and y from points (..., 3) to the arm's first joint."""
    away = centre_m - points_m
    direction: Floats = np.arctan2(away[..., 1], away[..., 0])
    return direction


def _about(points_m: Floats, turns: Floats) -> Floats:
    """Rotations (..., 4, 4) about points (..., 3) instead of the origin."""
    return transforms.transform(translation=points_m) @ turns @ transforms.transform(translation=-points_m)


def _reach(robot: Robot) -> tuple[Floats, float]:
    """A point that the arm turns about, and how far its tip gets from there."""
    centre = robot.before[0][:3, 3]
    steps = np.linalg.norm(robot.before[1:, :3, 3], axis=1).sum()
    return centre, float(steps + np.where(robot.prismatic, np.maximum(abs(robot.lower), abs(robot.upper)), 0).sum())


def candidates(
    size_mm: tuple[float, float], reach: ReachMap, best: int = 12, share: float = 1.0, apart_m: float = 0.0
) -> list[Placement]:
    """Places of a sheet, the one with the widest margins over all its area first.

    Args:
        size_mm: of the sheet.
        reach: see there.
        best: so many of them.
        share: of the sheet's sides that the margins are looked at over, from its middle; a pen that leans towards
            the middle is led by a hand that moves less.
        apart_m: least distance of their middles.
    """
    found: list[tuple[float, Placement]] = []
    step = float(reach.x_m[1] - reach.x_m[0])
    for turn in np.radians((0, 90, 180, 270)):
        across = np.abs(np.round([math.cos(turn), math.sin(turn)]))
        width, height = size_mm if across[0] else size_mm[::-1]
        need_x, need_y = (math.ceil(share * side / 2000 / step) for side in (width, height))
        worst = _window_minimum(reach.margin, need_y, need_x)
        for k, s, iz, iy, ix in _best(worst, 10 * best):
            centre = (reach.x_m[ix], reach.y_m[iy], reach.z_m[iz])
            flat = Placement.flat(centre, size_mm, float(turn), float(reach.spin_rad[s]))
            towards = float(_towards(np.array(centre), reach.arm_m)) - float(turn)
            placed = Placement(flat.base_from_paper, flat.spin_rad - float(turn), float(reach.lean_rad[k]), towards)
            found.append((float(worst[k, s, iz, iy, ix]) - 0.5 * float(reach.lean_rad[k]), placed))
    found.sort(key=lambda pair: -pair[0])
    return _apart([placed for _, placed in found], size_mm, apart_m)[:best]


def _apart(placements: list[Placement], size_mm: tuple[float, float], apart_m: float) -> list[Placement]:
    """Those whose middle is far enough from that of all before them that lie the same way round."""
    kept: list[Placement] = []
    for placed in placements:
        near = (one for one in kept if np.allclose(one.base_from_paper[:3, :3], placed.base_from_paper[:3, :3]))
        middle = placed.points_m(np.array(size_mm) / 2)
        if all(np.linalg.norm(one.points_m(np.array(size_mm) / 2) - middle) >= apart_m for one in near):
            kept.append(placed)
    return kept


def _window_minimum(margin: Floats, half_y: int, half_x: int) -> Floats:
    """Least value within a window around each cell of the last two axes; -inf where it leaves the grid."""
    padded = np.pad(margin, [(0, 0)] * 3 + [(half_y, half_y), (half_x, half_x)], constant_values=-np.inf)
    rows = np.lib.stride_tricks.sliding_window_view(padded, 2 * half_y + 1, axis=-2).min(-1)
    result: Floats = np.lib.stride_tricks.sliding_window_view(rows, 2 * half_x + 1, axis=-1).min(-1)
    return result


def _best(worst: Floats, count: int) -> list[tuple[int, ...]]:
    order = np.argsort(-worst, axis=None, kind="stable")[:count]
    return [index for flat in order if worst[index := np.unravel_index(flat, worst.shape)] > 0]


def parse_place(text: str, size_mm: tuple[float, float], spin_deg: float | None) -> Placement:
    """A sheet from its centre and turn in words.

    Raises:
        BadInput: not three or four numbers.
    """
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) not in (3, 4) or not np.isfinite(numbers).all():
        raise BadInput(f"place: '{text}' is no place; expected auto, thesis, x,y,z or x,y,z,turn in metres and degrees")
    turn = math.radians(numbers[3]) if len(numbers) == 4 else 0.0
    return Placement.flat(numbers[:3], size_mm, turn, math.radians(spin_deg or 0.0))


def unreachable(arm: Inverse, placed: Placement, points_mm: Floats, size_mm: tuple[float, float]) -> CannotDraw:
    """What to say when a sheet cannot be reached: how much of it, which part, and why."""
    tips = placed.tips(points_mm)
    margins = arm.margins(tips)
    missed = margins < 0
    if not missed.any():
        return CannotDraw("place: every point can be reached, but not all in one motion; try another place or spin")
    worst = int(margins.argmin())
    part = _part(points_mm[missed].mean(0), size_mm)
    where = ", ".join(f"{value:.3f}" for value in tips[worst][:3, 3])
    share = 100 * missed.mean()
    return CannotDraw(
        f"place: {share:.0f} % of the drawing ({part} of the sheet) cannot be reached; at ({where}) m"
        f" {arm.why(tips[worst])}"
    )


def _part(centre_mm: Floats, size_mm: tuple[float, float]) -> str:
    x, y = centre_mm[0] / size_mm[0] - 0.5, centre_mm[1] / size_mm[1] - 0.5
    words = [
        word
        for word in (
            "lower" if y < -0.1 else "upper" if y > 0.1 else "",
            "left" if x < -0.1 else "right" if x > 0.1 else "",
        )
        if word
    ]
    return " ".join(words) or "middle"
