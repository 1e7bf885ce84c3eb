"""A drawing and a budget of points go in; the strokes that matter most, each as simple as harmless, come out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from limner import geometry
from limner.drawing.coarsen import Coarsening, coarsenings
from limner.settings import SettingsGroup, setting
from limner.types import Drawing, Floats


@dataclass(frozen=True)
class SelectSettings(SettingsGroup):
    """How many points the drawing may have, and what is given up for it."""

    points: int | None = setting(
        None, "the drawing has at most this many points; not set: all of them", unit="points", low=2
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


@dataclass(frozen=True)
class _Step:
    """Something that points can be spent on: a stroke at its coarsest, or a finer version of it."""

    worth: float
    stroke: int
    level: int
    cost: int


def select(drawing: Drawing, settings: SelectSettings) -> Drawing:
    """Keep what the drawing would miss most, within the budget of points.

    Each stroke comes in versions from the coarsest that is harmless to the exact one. A version's value is the
    stroke's weight less a share for its error; steps from nothing to the coarsest version and on to finer ones are
    taken by value per point, the best first, until one does not fit; if that one is a whole stroke, its longest
    part that fits is drawn. (The greedy solution of a multiple-choice knapsack: Sinha & Zoltners 1979,
    doi:10.1287/opre.27.3.503.) The order of the steps does not depend on the budget, so more points never lose
    weight.

    Args:
        drawing: strokes with their weights.
        settings: the budget and what may be given up for it.

    Returns:
        The chosen strokes in the order they came; the drawing itself when it is within the budget. It has at most
        ``settings.points`` points; the weight of a part is its share of the length.
    """
    budget = settings.points
    if budget is None or drawing.points <= budget or not drawing.lines_mm:
        return drawing
    versions = _versions(drawing, settings)
    lines, weights = _fill(_steps(drawing.weight, versions, settings.lift_points), versions, drawing.weight, budget)
    chosen = sorted(lines)
    return Drawing(
        tuple(lines[i] for i in chosen),
        tuple(drawing.region[i] for i in chosen),
        weights[chosen],
        drawing.page,
        drawing.pen,
    )


def _fill(
    steps: list[_Step], versions: list[Coarsening], weight: Floats, budget: int
) -> tuple[dict[int, Floats], Floats]:
    """The line of each stroke taken, and all weights.

    After the first step that does not fit no new stroke is begun, or a larger budget could have lost it again; what
    is left still refines those that are there.
    """
    level = dict.fromkeys(range(len(versions)), -1)
    lines: dict[int, Floats] = {}
    weights = weight.copy()
    full = False
    for step in steps:
        line = versions[step.stroke].lines[step.level]
        if step.cost <= budget and level[step.stroke] == step.level - 1 and not (full and step.level == 0):
            lines[step.stroke] = line
            level[step.stroke] = step.level
            budget -= step.cost
        elif step.level == 0 and budget >= 2 and not full:
            lines[step.stroke] = part = _longest_part(line, budget)
            weights[step.stroke] *= geometry.length(part) / geometry.length(line)
            break
        full = full or step.cost > budget
    return lines, weights


def _versions(drawing: Drawing, settings: SelectSettings) -> list[Coarsening]:
    points = np.concatenate(drawing.lines_mm)
    side = float(np.ptp(points, axis=0).max())
    return [coarsenings(line, settings.coarsest * side, settings.shape_value) for line in drawing.lines_mm]


def _steps(weight: Floats, versions: list[Coarsening], lift_points: float) -> list[_Step]:
    """All steps, the most valuable per point first; those of one stroke stay in order."""
    steps = []
    for stroke, version in enumerate(versions):
        costs = np.diff([len(line) for line in version.lines], prepend=0)
        gains = np.diff(version.values, prepend=0.0) * weight[stroke]
        worth = gains / (costs + np.where(np.arange(len(costs)) == 0, lift_points, 0))
        worth = np.minimum.accumulate(worth)
        for level, cost in enumerate(costs.tolist()):
            steps.append(_Step(float(worth[level]), stroke, level, cost))
    return sorted(steps, key=lambda step: (-step.worth, step.stroke, step.level))


def _longest_part(line: Floats, points: int) -> Floats:
    along: NDArray[np.float64] = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    start = int(np.argmax(along[points - 1 :] - along[: len(along) - points + 1]))
    return line[start : start + points]
