"""Machines go in; how quickly their motion is planned, and how long they draw a portrait, come out."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

import numpy as np

from limner.motion import cost, pen
from limner.motion.machine import load_machine
from limner.types import Drawing, Page, Pen

STROKES = 3000
POINTS_PER_STROKE = 20


def planning_cpu_s(clock: Callable[[], float] = time.process_time) -> float:
    """CPU time of the planner, samples and all, for many random strokes."""
    drawing, machine = random_strokes(), load_machine("axidraw")
    start = clock()
    pen.plan(drawing, machine)
    return clock() - start


def random_strokes() -> Drawing:
    """Random walks all over a page."""
    rng = np.random.default_rng(0)
    walks = rng.uniform(10, 130, (STROKES, 1, 2)) + rng.normal(0, 0.4, (STROKES, POINTS_PER_STROKE, 2)).cumsum(axis=1)
    return Drawing(tuple(walks), ("face",) * STROKES, np.ones(STROKES), Page(), (Pen(),))


def drawing_s(drawing: Drawing) -> Iterator[tuple[str, float]]:
    """Name of each plotter whose area is large enough, and how long it draws [s]."""
    for name in ("axidraw", "grbl"):
        yield name, cost.seconds(drawing, load_machine(name))
