"""A drawing and a machine go in; the wanted motion of the pen tip in time comes out."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from limner.motion.machine import Machine
from limner.motion.profile import Profile, profile
from limner.motion.route import Route, route
from limner.types import Drawing, Floats, PenPath

CHORD_MM = 0.02
"""Linear interpolation between two samples is nowhere farther than this from the motion itself, with the pen down."""

RAISED_CHORD_MM = 0.2
"""The same with the pen up, and while it goes up or down."""

_HOME = "home"


def plan(
    drawing: Drawing, machine: Machine, start_mm: Floats | None = None, end_mm: Floats | str | None = _HOME
) -> PenPath:
    """The fastest motion that draws a drawing within the machine's limits.

    The pen starts raised, goes to the first stroke, lowers, draws, raises, and so on; straight up and down, never
    while it moves sideways. Every phase is one of constant acceleration. Samples stand at the ends of phases, and so
    densely within them that linear interpolation stays within ``CHORD_MM``; its mean speeds keep the limits as the
    motion itself does.

    Args:
        drawing: what to draw; none of it is only the way to ``end_mm``.
        machine: how fast.
        start_mm: (2,) where the pen is; the machine's home by default.
        end_mm: (2,) where it goes afterwards; home by default, None for where the last stroke ends.

    Returns:
        PenPath in the paper frame, z = 0 on the paper and ``lift_mm`` with the pen raised.
    """
    home = machine.home_mm(drawing.page)
    end = home if isinstance(end_mm, str) else end_mm
    moves = route(drawing, home if start_mm is None else start_mm, end)
    return _sampled(moves, profile(moves, machine), machine)


def _sampled(moves: Route, fast: Profile, machine: Machine) -> PenPath:
    """Phases of each move: two of the pen's lift before it, then speeding up, running and slowing down."""
    seconds = np.concatenate([_lift_seconds(moves, machine), fast.phase_s], axis=1)
    distance = np.stack(
        [
            (fast.start_mm_s + fast.peak_mm_s) / 2 * fast.phase_s[:, 0],
            fast.peak_mm_s * fast.phase_s[:, 1],
            (fast.peak_mm_s + fast.end_mm_s) / 2 * fast.phase_s[:, 2],
        ],
        axis=1,
    )
    counts = _counts(moves, fast, seconds, machine)
    phase = np.repeat(np.arange(counts.size), counts.ravel())
    move, kind = np.divmod(phase, 5)
    step = np.arange(1, len(phase) + 1) - np.repeat(np.cumsum(counts.ravel()) - counts.ravel(), counts.ravel())
    part = step / counts.ravel()[phase]
    before = np.concatenate([[0.0], np.cumsum(seconds.ravel())[:-1]])
    moved = _moved(fast, distance, move, kind, part * seconds.ravel()[phase])
    draws = moves.draws[move] & (kind > 1)
    position = np.column_stack([_places(moves, fast, move, moved), _heights(moves, move, kind, part) * machine.lift_mm])
    return PenPath(
        np.concatenate([[0.0], np.maximum.accumulate(before[phase] + part * seconds.ravel()[phase])]),
        np.concatenate([[[*moves.vertices_mm[0], machine.lift_mm]], position]),
        np.concatenate([[False], draws]),
        np.concatenate([[-1], np.where(draws, moves.stroke[move], -1)]),
    )


def _lift_seconds(moves: Route, machine: Machine) -> Floats:
    """(m, 2) halves of the pen's lift or fall before each move."""
    whole = moves.lowers * machine.pen_down_s + moves.raises * machine.pen_up_s
    return np.stack([whole / 2, whole / 2], axis=1)


def _counts(moves: Route, fast: Profile, seconds: Floats, machine: Machine) -> NDArray[np.int64]:
    """(m, 5) samples of each phase; a dot has one although it takes no time."""
    lift = np.full((len(seconds), 2), np.sqrt(machine.lift_mm / (8 * RAISED_CHORD_MM)))
    change = np.stack([fast.peak_mm_s - fast.start_mm_s, fast.peak_mm_s * 0, fast.peak_mm_s - fast.end_mm_s], axis=1)
    # The chord of t seconds at acceleration a leaves it by a t^2 / 8; here a t is the change of speed.
    chord = np.where(moves.draws, CHORD_MM, RAISED_CHORD_MM)[:, None]
    run = np.sqrt(change * seconds[:, 2:] / (8 * chord))
    counts = np.where(seconds > 0, np.maximum(np.ceil(np.concatenate([lift, run], axis=1)), 1), 0).astype(np.int64)
    counts[moves.draws & (fast.length_mm == 0), 3] = 1
    return counts


def _moved(fast: Profile, distance: Floats, move: NDArray[np.int64], kind: NDArray[np.int64], t_s: Floats) -> Floats:
    """Length of the move that is behind each sample [mm]."""
    none = np.zeros((len(distance), 2))
    before = np.concatenate([none, none[:, :1], np.cumsum(distance, axis=1)[:, :2]], axis=1)
    speed = np.stack([fast.peak_mm_s * 0, fast.peak_mm_s * 0, fast.start_mm_s, fast.peak_mm_s, fast.peak_mm_s], axis=1)
    took = np.where(fast.phase_s > 0, fast.phase_s, 1)
    change = np.stack([fast.peak_mm_s - fast.start_mm_s, 0 * fast.peak_mm_s, fast.end_mm_s - fast.peak_mm_s], axis=1)
    acceleration = np.concatenate([none, change / took], axis=1)
    moved: Floats = before[move, kind] + speed[move, kind] * t_s + acceleration[move, kind] * t_s**2 / 2
    return moved


def _places(moves: Route, fast: Profile, move: NDArray[np.int64], moved: Floats) -> Floats:
    part = np.clip(moved / np.where(fast.length_mm > 0, fast.length_mm, 1)[move], 0, 1)[:, None]
    last = np.concatenate([move[1:] != move[:-1], [True]])
    # It arrives exactly, whatever rounding leaves.
    part[last & (fast.length_mm[move] > 0)] = 1
    places: Floats = (1 - part) * moves.vertices_mm[move] + part * moves.vertices_mm[move + 1]
    return places


def _heights(moves: Route, move: NDArray[np.int64], kind: NDArray[np.int64], part: Floats) -> Floats:
    """0 on the paper, 1 raised; half the way speeding up, half slowing down."""
    way = np.where(kind == 0, part**2 / 2, 1 - (1 - part) ** 2 / 2)
    lifting = np.where(moves.raises[move], way, 1 - way)
    heights: Floats = np.where(kind < 2, lifting, np.where(moves.draws[move], 0.0, 1.0))
    return heights
