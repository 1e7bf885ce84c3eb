"""A drawing and a machine go in; what it costs comes out: the planner's seconds, without its samples."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from limner.motion.machine import Machine
from limner.motion.profile import Profile, profile
from limner.motion.route import Route, route
from limner.types import Drawing, Floats


@dataclass(frozen=True)
class Costs:
    """What a machine needs for a drawing.

    Attributes:
        strokes: lines drawn.
        points: vertices the machine must go to.
        ink_mm: pen-down length.
        travel_mm: pen-up length, from home to home.
        lifts: how often the pen is raised.
        draw_s: time in which it draws.
        travel_s: time in which it moves raised.
        lift_s: time in which it is lowered and raised.
        seconds: all of it.
    """

    strokes: int
    points: int
    ink_mm: float
    travel_mm: float
    lifts: int
    draw_s: float
    travel_s: float
    lift_s: float
    seconds: float


def costs(drawing: Drawing, machine: Machine) -> Costs:
    """Count and add up; ``seconds`` is when ``plan``'s path ends."""
    moves, fast = _planned(drawing, machine)
    lifts, falls = int(moves.raises.sum()), int(moves.lowers.sum())
    lift_s = lifts * machine.pen_up_s + falls * machine.pen_down_s
    draw_s, travel_s = (float(fast.seconds[which].sum()) for which in (moves.draws, ~moves.draws))
    ink_mm, travel_mm = (float(fast.length_mm[which].sum()) for which in (moves.draws, ~moves.draws))
    strokes = len(drawing.lines_mm)
    return Costs(
        strokes, drawing.points, ink_mm, travel_mm, lifts, draw_s, travel_s, lift_s, draw_s + travel_s + lift_s
    )


def seconds(drawing: Drawing, machine: Machine) -> float:
    """How long the machine draws, from home to home."""
    return costs(drawing, machine).seconds


def stroke_seconds(drawing: Drawing, machine: Machine) -> Floats:
    """(strokes,) how long each stroke takes with the pen down, without the way to it."""
    moves, fast = _planned(drawing, machine)
    inked = moves.stroke >= 0
    return np.bincount(moves.stroke[inked], fast.seconds[inked], len(drawing.lines_mm)).astype(np.float64)


def stroke_begins(drawing: Drawing, machine: Machine) -> Floats:
    """(strokes,) when each stroke begins, its pen already lowered [s]."""
    moves, fast = _planned(drawing, machine)
    before = np.cumsum(fast.seconds + moves.lowers * machine.pen_down_s + moves.raises * machine.pen_up_s)
    first = np.flatnonzero(moves.draws & np.concatenate([[True], moves.stroke[1:] != moves.stroke[:-1]]))
    begins: Floats = (before - fast.seconds)[first]
    return begins


def _planned(drawing: Drawing, machine: Machine) -> tuple[Route, Profile]:
    home = machine.home_mm(drawing.page)
    moves = route(drawing, home, home)
    return moves, profile(moves, machine)
