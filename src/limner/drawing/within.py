"""A drawing and a clock go in; as much of it as can be drawn in the time given comes out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from limner.drawing.select import CostModel, SelectSettings, TimeLimit, select
from limner.errors import CannotDraw
from limner.types import Drawing

Finished = TypeVar("Finished")

_TRIES = 16
_ENOUGH = 0.975
_AIM = 0.99


@dataclass(frozen=True)
class Clock:
    """How long a machine draws.

    Attributes:
        seconds: what its planner says of a finished drawing.
        cost: about the same, stroke by stroke.
        name: of the machine, for messages.
    """

    seconds: Callable[[Drawing], float]
    cost: CostModel
    name: str


def within_time(
    drawing: Drawing,
    settings: SelectSettings,
    clock: Clock,
    finish: Callable[[Drawing], tuple[Drawing, Finished]],
) -> tuple[Drawing, Finished]:
    """Choose so much that the finished drawing takes at most ``settings.minutes``, and nearly that if there is enough.

    The model of the costs compares strokes; the planner has the last word. What the model is off by is made good in a
    few rounds of choosing, finishing and timing.

    Args:
        drawing: all that could be drawn.
        settings: the budget of minutes, and of points if there is one, and what may be given up for it.
        clock: of the machine.
        finish: places and orders what was chosen; it may enlarge it, which costs time.

    Returns:
        What ``finish`` gave for the best choice.

    Raises:
        CannotDraw: not even part of a stroke can be drawn in that time.
    """
    limit = 60 * (settings.minutes or float("inf"))
    whole = finish(select(drawing, settings))
    if (spent := clock.seconds(whole[0])) <= limit:
        return whole
    best: tuple[float, tuple[Drawing, Finished]] | None = None
    low, high, budget = 0.0, spent, limit
    for _ in range(_TRIES):
        chosen = select(drawing, settings, TimeLimit(budget, clock.cost))
        found = finish(chosen)
        spent = clock.seconds(found[0]) if chosen.lines_mm else 0.0
        if spent <= limit:
            low = max(low, budget)
            if chosen.lines_mm and (best is None or spent > best[0]):
                best = spent, found
            if spent >= _ENOUGH * limit:
                break
        else:
            high = min(high, budget)
        budget = _next(budget, spent, limit, low, high)
    if best is None:
        raise CannotDraw(
            f"minutes: {clock.name} draws no stroke in {limit / 60:g} min; allow more time, or choose a faster machine"
        )
    return best[1]


def made_within_time(
    make: Callable[[int], tuple[Drawing, Finished]], first: int, most: int, limit_s: float, clock: Clock
) -> tuple[Drawing, Finished]:
    """Make a drawing of so many points that it takes at most the time given, and nearly that if it may have enough.

    Args:
        make: a finished drawing of at most so many points.
        first: how many are tried first.
        most: how many there may be.
        limit_s: the time [s].
        clock: of the machine.

    Returns:
        What ``make`` gave for the best number of points.

    Raises:
        CannotDraw: not even the least drawing can be drawn in that time.
    """
    best: tuple[float, tuple[Drawing, Finished]] | None = None
    low, high, count = 0, most + 1, min(first, most)
    for _ in range(_TRIES):
        found = make(count)
        spent = clock.seconds(found[0])
        if spent <= limit_s:
            low = count
            if best is not None and spent <= best[0]:  # more is not to be had
                break
            best = spent, found
            if spent >= _ENOUGH * limit_s:
                break
        else:
            high = count
        if high - low <= 1:
            break
        count = int(np.clip(count * _AIM * limit_s / max(spent, 1e-9), low + 1, high - 1))
    if best is None:
        raise CannotDraw(
            f"minutes: {clock.name} draws nothing in {limit_s / 60:g} min; allow more time, or choose a faster machine"
        )
    return best[1]


def _next(budget: float, spent: float, limit: float, low: float, high: float) -> float:
    """In proportion to what the last budget cost, if that lies between what was too little and too much."""
    scaled = budget * _AIM * limit / spent if spent > 0 else 2 * budget
    if low < scaled < high:
        return scaled
    return (low + high) / 2 if high > low else scaled
