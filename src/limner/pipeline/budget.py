"""What could be drawn, and a budget, go in; the drawing that keeps to it comes out, on the page and in its order."""

from __future__ import annotations

import dataclasses
from functools import partial

from limner.drawing.compose import ComposeSettings, fill_page
from limner.drawing.order import OrderSettings, order
from limner.drawing.select import CostModel, SelectSettings
from limner.drawing.within import Clock, within_time
from limner.motion.cost import seconds as planned_seconds
from limner.motion.machine import load_machine
from limner.types import Drawing, Floats


def finished(drawing: Drawing, placing: ComposeSettings, ordering: OrderSettings) -> tuple[Drawing, Floats]:
    """The drawing as it fills the page and is drawn, and the map of the page that enlarged it."""
    filling, growth = fill_page(drawing, placing)
    return order(filling, ordering), growth


def timed(
    drawing: Drawing, machine: str, choosing: SelectSettings, placing: ComposeSettings, ordering: OrderSettings
) -> tuple[Drawing, Floats]:
    """So much of the drawing as the machine draws in the minutes it has, finished."""
    return within_time(drawing, choosing, clock_of(machine), partial(finished, placing=placing, ordering=ordering))


def clock_of(machine: str) -> Clock:
    """How long a machine, or its TOML file, draws."""
    mover = load_machine(machine)
    cost = CostModel(**dataclasses.asdict(mover.cost_model()))
    return Clock(partial(planned_seconds, machine=mover), cost, mover.name)
