"""A drawing and a budget go in; the strokes that matter most, each as simple as harmless, come out."""

from __future__ import annotations

import dataclasses
import heapq
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from limner import geometry
from limner.drawing.coarsen import Coarsening, coarsenings
from limner.drawing.coverage import Coverage
from limner.drawing.neighbours import nearest
from limner.settings import SettingsGroup, setting
from limner.types import Drawing, Floats


@dataclass(frozen=True)
class SelectSettings(SettingsGroup):
    """How many points the drawing may have, and what is given up for it."""

    points: int | None = setting(
        None, "the drawing has at most this many points; not set: all of them", unit="points", low=2
    )
    minutes: float | None = setting(
        None, "the machine draws at most this long; not set: as long as it takes", unit="min", low=0.01, high=100_000
    )
    coarsest: float = setting(
        0.004,
        "to save points a line may move by this part of the drawing's longer side; 1/200 is harmless",
        unit="of the longer side",
        low=0,
        high=0.1,
    )
    lift_points: float = setting(
        2.0, "when strokes are compared each costs this much more, for its pen lift", unit="points", low=0, high=1000
    )
    shape_value: float = setting(
        0.2, "part of a stroke's weight that its exact shape is worth against its coarsest", low=0, high=1
    )
    nearness: float = setting(
        0.01,
        "lines nearer than this part of the drawing's longer side share their worth",
        unit="of the longer side",
        low=0.001,
        high=1,
    )


@dataclass(frozen=True)
class CostModel:
    """What drawing costs on a machine, about: enough to compare strokes by.

    Attributes:
        stroke_s: of a stroke, to lower and lift the pen, and to start and stop [s].
        point_s: of a vertex [s].
        ink_s_per_mm: of pen-down length [s/mm].
        travel_s_per_mm: of pen-up length [s/mm].
    """

    stroke_s: float
    point_s: float = 0.0
    ink_s_per_mm: float = 0.0
    travel_s_per_mm: float = 0.0


@dataclass(frozen=True)
class TimeLimit:
    """Seconds that a drawing may cost on a machine."""

    seconds: float
    cost: CostModel


@dataclass(frozen=True)
class _Costs:
    """What each version of each stroke costs, summed up from nothing to that version.

    Attributes:
        points: charged, of each version of each stroke.
        seconds: charged; all 0 without a time limit.
        price: by which strokes are compared.
        fixed: seconds of each stroke that do not fall with its length.
    """

    points: list[list[float]]
    seconds: list[list[float]]
    price: list[list[float]]
    fixed: list[float]

    def of_step(self, stroke: int, version: int) -> Floats:
        """Points and seconds (2,) from the version before, or from nothing, to this one."""
        cost = np.array([self.points[stroke][version], self.seconds[stroke][version]])
        if version:
            cost -= [self.points[stroke][version - 1], self.seconds[stroke][version - 1]]
        return cost


def select(drawing: Drawing, settings: SelectSettings, limit: TimeLimit | None = None) -> Drawing:
    """Keep what the drawing would miss most, within the budget.

    Each stroke comes in versions from the coarsest that is harmless to the exact one. What a stroke is worth falls
    with the ink that is already near (``Coverage``); a version is worth the stroke's gain less a share for its error.
    Steps from nothing to the coarsest version and on to finer ones are taken by worth per cost, the best first, until
    one does not fit; if that one is a whole stroke, its longest part that fits is drawn. For a submodular worth the
    strokes taken and the first that does not fit are together worth at least 1 - 1/e of the best choice there is
    (Khuller, Moss & Naor 1999, doi:10.1016/S0020-0190(99)00031-9), and gains are computed anew only where they can
    decide (Minoux 1978). The order of the steps does not depend on the budget, so a larger one never loses anything.

    Args:
        drawing: strokes with their weights.
        settings: the budget of points and what may be given up for it (``minutes`` is for ``within_time``).
        limit: a budget of time by a model of the machine, besides that of points or alone.

    Returns:
        The chosen strokes in the order they came; the drawing itself when it is within the budget. It has at most
        ``settings.points`` points and costs at most ``limit.seconds`` by the model; the weight of a part is its share
        of the length.
    """
    if not drawing.lines_mm or (settings.points is None and limit is None):
        return drawing
    exact = [Coarsening((line,), (1.0,)) for line in drawing.lines_mm]
    budget = np.array([settings.points or np.inf, limit.seconds if limit else np.inf])
    costs = _costs(drawing, exact, settings, limit)
    if sum(p[-1] for p in costs.points) <= budget[0] and sum(s[-1] for s in costs.seconds) <= budget[1]:
        return drawing
    side = float(np.ptp(np.concatenate(drawing.lines_mm), axis=0).max())
    versions = [coarsenings(line, settings.coarsest * side, settings.shape_value) for line in drawing.lines_mm]
    steps = _Steps(drawing, versions, _costs(drawing, versions, settings, limit), settings.nearness * max(side, 1e-6))
    lines, weights = _fill(steps, drawing.weight, budget)
    chosen = sorted(lines)
    return dataclasses.replace(drawing.pick(chosen), lines_mm=tuple(lines[i] for i in chosen), weight=weights[chosen])


class _Steps:
    """Steps from nothing to a stroke's coarsest version, and on from each version to the next, the best first."""

    def __init__(self, drawing: Drawing, versions: list[Coarsening], costs: _Costs, cell_mm: float) -> None:
        self.versions, self.costs = versions, costs
        self.coverage = Coverage(drawing, cell_mm)
        self.heap = [(-self._worth(i, self.coverage.gain(i)), i, 0, 0) for i in range(len(versions))]
        heapq.heapify(self.heap)
        self.taken = 0

    def _worth(self, stroke: int, gain: float) -> float:
        return gain * self.versions[stroke].values[0] / max(self.costs.price[stroke][0], 1e-12)

    def next(self) -> tuple[int, int] | None:
        """The stroke and version of the best step; None when there is no more."""
        while self.heap:
            worth, stroke, level, known = heapq.heappop(self.heap)
            if level or known == self.taken:
                return stroke, level
            # An old gain is an upper bound: only if it comes first, is it worth computing the new one.
            again = -self._worth(stroke, self.coverage.gain(stroke))
            heapq.heappush(self.heap, (max(again, worth), stroke, 0, self.taken))
        return None

    def take(self, stroke: int, level: int) -> None:
        """Count the step as taken and offer what follows it."""
        if level == 0:
            gain = self.coverage.gain(stroke)
            self.coverage.take(stroke)
            self.taken += 1
            values, price = self.versions[stroke].values, self.costs.price[stroke]
            worth = self._worth(stroke, gain)
            for k in range(1, len(values)):
                worth = min(worth, gain * (values[k] - values[k - 1]) / max(price[k] - price[k - 1], 1e-12))
                heapq.heappush(self.heap, (-worth, stroke, k, 0))


def _fill(steps: _Steps, weight: Floats, budget: Floats) -> tuple[dict[int, Floats], Floats]:
    """The line of each stroke taken, and all weights.

    After the first step that does not fit no new stroke is begun, or a larger budget could have lost it again; what
    is left still refines those that are there.
    """
    costs, versions = steps.costs, steps.versions
    lines: dict[int, Floats] = {}
    level: dict[int, int] = {}
    weights = weight.copy()
    left = budget.copy()
    full = False
    while (step := steps.next()) is not None:
        stroke, k = step
        if level.get(stroke, -1) != k - 1 or (full and k == 0):
            continue
        cost = costs.of_step(stroke, k)
        if (cost <= left).all():
            lines[stroke], level[stroke] = versions[stroke].lines[k], k
            left -= cost
            steps.take(stroke, k)
            continue
        if k == 0:
            part = _part(versions[stroke].lines[0], cost[1], costs.fixed[stroke], left)
            if part is not None:
                lines[stroke] = part
                weights[stroke] *= geometry.length(part) / max(geometry.length(versions[stroke].lines[0]), 1e-12)
                break
        full = True
    return lines, weights


def _part(line: Floats, seconds: float, fixed: float, left: Floats) -> Floats | None:
    """The longest part of a line that fits; None if not even one segment does."""
    points = int(min(left[0], len(line) - 1))
    while points >= 2:
        part = _longest_part(line, points)
        share = max(geometry.length(part) / max(geometry.length(line), 1e-12), points / len(line))
        if fixed + (seconds - fixed) * share <= left[1]:
            return part
        points -= max(1, points // 64)
    return None


def _longest_part(line: Floats, points: int) -> Floats:
    along: NDArray[np.float64] = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    start = int(np.argmax(along[points - 1 :] - along[: len(along) - points + 1]))
    return line[start : start + points]


def _costs(drawing: Drawing, versions: list[Coarsening], settings: SelectSettings, limit: TimeLimit | None) -> _Costs:
    points = [[float(len(line)) for line in version.lines] for version in versions]
    if limit is None:
        none = [[0.0] * len(row) for row in points]
        return _Costs(points, none, [[n + settings.lift_points for n in row] for row in points], [0.0] * len(points))
    cost = limit.cost
    fixed = cost.stroke_s + cost.travel_s_per_mm * _travel_shares(drawing)
    seconds = [
        [base + cost.point_s * len(line) + cost.ink_s_per_mm * geometry.length(line) for line in version.lines]
        for base, version in zip(fixed.tolist(), versions, strict=True)
    ]
    return _Costs(points, seconds, seconds, fixed.tolist())


def _travel_shares(drawing: Drawing) -> Floats:
    """About how far the pen travels for each stroke: half the way from either end to the nearest of another."""
    ends = np.array([line[k] for line in drawing.lines_mm for k in (0, -1)])
    if len(ends) < 4:
        return np.zeros(len(ends) // 2)
    near = nearest(ends, 3)
    gap = np.hypot(*(ends[:, None] - ends[near]).transpose(2, 0, 1))
    gap[near // 2 == np.arange(len(ends))[:, None] // 2] = np.inf
    shares: Floats = gap.min(axis=1).reshape(-1, 2).mean(axis=1)
    return shares
