"""A drawing goes in; the pen's way in space comes out: straight down, along the ink, straight up, level on."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from limner import geometry
from limner.errors import NothingToDraw
from limner.settings import SettingsGroup, setting
from limner.types import Drawing, Floats, Page, Value, frozen_array

_NEAR_MM = 1.0
"""An arc over to a stroke that begins nearer than this would bend so sharply that the pen crawls along it."""

_LOWEST_MM = 0.7
"""Height of the lowest arch."""

_GENTLER = 0.6
"""As part of an arch's rise, how far it goes over while it falls: what still swings on from there comes to rest."""

DOT_MM = 0.1
"""Length of the dash that a dot becomes."""


@dataclass(frozen=True, eq=False)
class LiftedPath(Value):
    """Where the pen's tip goes, without time.

    Attributes:
        points_mm: (n, 3) in the paper frame, straight between them.
        down: (n,) whether the move that ends here draws.
        stroke: (n,) index of the stroke, -1 in travel.
        stop: (n,) whether the pen comes to rest here.
    """

    points_mm: Floats
    down: NDArray[np.bool_]
    stroke: NDArray[np.int64]
    stop: NDArray[np.bool_]

    def __post_init__(self) -> None:
        self._freeze("points_mm", frozen_array(self.points_mm, np.float64, (None, 3), "LiftedPath.points_mm"))
        n = len(self.points_mm)
        for name, dtype in (("down", np.bool_), ("stroke", np.int64), ("stop", np.bool_)):
            self._freeze(name, frozen_array(getattr(self, name), dtype, (n,), f"LiftedPath.{name}"))

    def pieces(self) -> list[tuple[int, int]]:
        """First and last index of each piece between two stops."""
        stops = np.flatnonzero(self.stop)
        return [(int(a), int(b)) for a, b in itertools.pairwise(stops)]


@dataclass(frozen=True)
class LiftSettings(SettingsGroup):
    """How an arm leads its pen."""

    paper_mm: float = setting(1.0, "the sheet may lie this much higher than is known", unit="mm", low=0, high=100)
    tilt_deg: float = setting(
        1.0, "and be tilted by this about its middle, against what is known", unit="deg", low=0, high=20
    )
    clear_mm: float = setting(
        0.0, "the pen goes straight up and down to this, above the sheet at its worst", unit="mm", low=0, high=200
    )
    lift_mm: float = setting(2.5, "a long hop is an arch of this height above there", unit="mm", low=0.1, high=200)
    arch: float = setting(
        0.45,
        "height of a short hop's arch, as part of its length; a low one is quick, and shakes the pen",
        low=0.05,
        high=10,
    )
    approach_mm: float = setting(
        60.0,
        "the drawing is come to and left from this height above its first and last place",
        unit="mm",
        low=0.5,
        high=500,
    )
    press_mm: float = setting(
        3.0, "the tip is led this far below the sheet; the pen's spring takes it up", unit="mm", low=0, high=10
    )
    round_mm: float = setting(
        0.15, "corners may be rounded by this, instead of a stop at each; 0: a stop", unit="mm", low=0, high=5
    )
    spacing_mm: float = setting(1.0, "farthest that two poses are apart", unit="mm", low=0.05, high=20)
    corner_deg: float = setting(
        100.0, "the pen comes to rest where a stroke turns by more than this", unit="deg", low=0, high=180
    )

    def arch_mm(self, across_mm: float) -> float:
        """How high a hop arches over where the pen is clear of the paper: a pen that goes far has time to rise."""
        return min(self.lift_mm, max(_LOWEST_MM, self.arch * across_mm))

    def highest_mm(self, away_mm: float) -> float:
        """How high the sheet may lie over where it is taken to lie, so far from its middle."""
        return self.paper_mm + math.tan(math.radians(self.tilt_deg)) * away_mm


def lifted_path(drawing: Drawing, settings: LiftSettings) -> LiftedPath:
    """The path of a pen that leaves no trail: each stroke is reached from straight above and left straight upwards.

    The thesis's arm moved sideways while lifting, which drew (section 4.4).

    Args:
        drawing: strokes in drawing order.
        settings: heights, and how far corners may be rounded.

    Returns:
        The path from high above the first stroke to high above the last one.

    Raises:
        NothingToDraw: the drawing has no strokes.
    """
    if not drawing.lines_mm:
        raise NothingToDraw("plan: the drawing has no strokes")
    builder = _Builder(settings, drawing.page)
    builder.begin(drawing.lines_mm[0][0])
    for index, line in enumerate(drawing.lines_mm):
        flat = _drawable(geometry.without_repeats(line))
        drawn = np.column_stack([flat, np.full(len(flat), -settings.press_mm)])
        builder.travel_to(drawn[0])
        builder.draw(drawn, index)
    builder.travel_to(builder.above(drawing.lines_mm[-1][-1]))
    return builder.path()


def _drawable(line: Floats) -> Floats:
    """The line; of a dot, a dash too short to be seen as one: the pen is on the paper for a while."""
    return line if len(line) > 1 else line + DOT_MM / 2 * np.array([[-1, 0], [1, 0]])


class _Builder:
    """Collects a path piece by piece."""

    def __init__(self, settings: LiftSettings, page: Page) -> None:
        self.settings, self.middle_mm = settings, np.array([page.width_mm, page.height_mm]) / 2
        self.points: list[Floats] = []
        self.down, self.stroke, self.stop = [False], [-1], [True]

    def begin(self, place: Floats) -> None:
        """High above a place."""
        self.points = [self.above(place)[None]]

    def above(self, place: Floats) -> Floats:
        """(3,) where a place is come to from and left to."""
        clear = self._highest(place) + self.settings.clear_mm + self.settings.lift_mm
        return np.array([*place[:2], max(self.settings.approach_mm, clear)])

    def draw(self, line: Floats, index: int) -> None:
        """A stroke from where the pen is, at rest at its ends and where it turns sharply."""
        rests = np.flatnonzero(_corners(line, self.settings.corner_deg if self.settings.round_mm else 0.0))
        for a, b in itertools.pairwise(rests):
            self._add(_rounded(line[a : b + 1], self.settings.round_mm, self.settings.spacing_mm), index)

    def travel_to(self, target: Floats) -> None:
        """Up, over and down; its corners are cut where the pen is clear of the paper."""
        at, settings = self.points[-1][-1], self.settings
        highest = [self._highest(end) for end in (at, target)]
        across = float(np.hypot(*(target - at)[:2]))
        height = max(highest) + settings.clear_mm + settings.arch_mm(across)
        if 0 < across < _NEAR_MM and max(at[2], target[2]) < height:
            self._step_to(target, height)
            return
        bend = settings.arch_mm(across) / (2 * settings.arch)
        over = (target - at) * [1, 1, 0] * min(0.5, bend / max(across, 1e-9))
        pieces, last = [at[None]], at
        for end, worst, inwards in zip((at, target), highest, (over, -_GENTLER * over), strict=True):
            rest = height - worst - settings.clear_mm
            corner = np.array([*end[:2], height])
            outwards = np.array([0.0, 0.0, np.clip(end[2] - height, -rest, rest)])
            enter, leave = corner + outwards, corner + inwards
            if end is target:
                enter, leave = leave, enter
            pieces += [_divided(last, enter, settings.spacing_mm), _parabola(enter, corner, leave, settings.spacing_mm)]
            last = leave
        pieces.append(_divided(last, target, settings.spacing_mm))
        self._add(np.concatenate(pieces), -1)

    def _highest(self, place: Floats) -> float:
        """How high the sheet may lie at a place."""
        return self.settings.highest_mm(float(np.hypot(*(place[:2] - self.middle_mm))))

    def _step_to(self, target: Floats, height: float) -> None:
        """Up and down to a place close by, with a rest at the top, where the pen turns back anyway."""
        at = self.points[-1][-1]
        top = np.array([*(at + target)[:2] / 2, height])
        up, down = (self._risen(end, top) for end in (at, target))
        self._add(np.concatenate([at[None], up]), -1)
        self._add(np.concatenate([down[::-1], target[None]]), -1)

    def _risen(self, start: Floats, top: Floats) -> Floats:
        """Points after ``start``, straight up as long as the pen is not clear of the paper, then leaning to the top."""
        clear = min(self._highest(start) + self.settings.clear_mm, top[2])
        enter = np.array([*start[:2], max(clear, start[2])])
        control = np.array([*start[:2], (enter[2] + top[2]) / 2])
        spacing = self.settings.spacing_mm
        return np.concatenate([_divided(start, enter, spacing), _parabola(enter, control, top, spacing)])

    def _add(self, points: Floats, index: int) -> None:
        points = _apart(points)
        if len(points) < 2:
            return
        count = len(points) - 1
        self.points.append(points[1:])
        self.down += [index >= 0] * count
        self.stroke += [index] * count
        self.stop += [False] * (count - 1) + [True]

    def path(self) -> LiftedPath:
        return LiftedPath(np.concatenate(self.points), np.array(self.down), np.array(self.stroke), np.array(self.stop))


def _apart(points: Floats, least_mm: float = 0.02) -> Floats:
    """Points without those that nearly coincide with one before; both ends stay.

    A smooth curve through two points a hair apart may turn there without bound.
    """
    if len(points) < 3:
        return points
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    kept, last = [0], 0.0
    for i in range(1, len(points) - 1):
        if along[i] - last >= least_mm and along[-1] - along[i] >= least_mm:
            kept.append(i)
            last = along[i]
    return points[[*kept, len(points) - 1]]


def _rounded(line: Floats, tolerance: float, spacing: float) -> Floats:
    """A polyline, finely divided, its corners replaced by parabolas that leave them by at most ``tolerance``."""
    if len(line) < 3 or tolerance <= 0:
        return _blended(line, 0.0, spacing)
    ahead = np.diff(line, axis=0)
    ahead = ahead / np.linalg.norm(ahead, axis=1, keepdims=True)
    half_sine = np.sqrt(np.clip((1 - (ahead[:-1] * ahead[1:]).sum(1)) / 2, 1e-12, 1))
    return _blended(line, 2 * tolerance / half_sine, spacing)


def _blended(line: Floats, cut: float | Floats, spacing: float) -> Floats:
    """A polyline with parabolas that begin and end ``cut`` before and after each inner corner, finely divided.

    A parabola takes at most half of each segment beside its corner.
    """
    lengths = np.linalg.norm(np.diff(line, axis=0), axis=1)
    inner = np.minimum(cut, np.minimum(lengths[:-1], lengths[1:]) / 2) if len(line) > 2 else np.zeros(0)
    pieces, at = [line[:1]], line[0]
    for corner, reach, before, after in zip(
        line[1:-1], np.broadcast_to(inner, len(line) - 2), line[:-2], line[2:], strict=True
    ):
        enter = corner + reach * (before - corner) / max(np.linalg.norm(before - corner), 1e-12)
        leave = corner + reach * (after - corner) / max(np.linalg.norm(after - corner), 1e-12)
        pieces += [_divided(at, enter, spacing), _parabola(enter, corner, leave, spacing)]
        at = leave
    pieces.append(_divided(at, line[-1], spacing))
    return np.concatenate(pieces)


def _parabola(start: Floats, control: Floats, end: Floats, spacing: float) -> Floats:
    length = np.linalg.norm(control - start) + np.linalg.norm(end - control)
    if length < 1e-9:
        return np.zeros((0, 3))
    t = np.linspace(0, 1, max(4, int(np.ceil(2 * length / spacing))) + 1)[1:, None]
    return np.asarray((1 - t) ** 2 * start + 2 * t * (1 - t) * control + t**2 * end)


def _divided(start: Floats, end: Floats, spacing: float) -> Floats:
    """Points after ``start`` up to and with ``end``, evenly spaced; none where both are one."""
    length = np.linalg.norm(end - start)
    if length < 1e-9:
        return np.zeros((0, 3))
    count = int(np.ceil(length / spacing))
    share = np.arange(1, count + 1)[:, None] / count
    return np.asarray(start + share * (end - start))


def _corners(line: Floats, turn_deg: float) -> NDArray[np.bool_]:
    """Where (n,) a polyline turns by more than an angle; its ends count."""
    turns = np.ones(len(line), bool)
    if len(line) > 2:
        ahead = np.diff(line, axis=0)
        ahead = ahead / np.linalg.norm(ahead, axis=1, keepdims=True)
        turns[1:-1] = (ahead[:-1] * ahead[1:]).sum(1) < np.cos(np.radians(turn_deg))
    return turns
