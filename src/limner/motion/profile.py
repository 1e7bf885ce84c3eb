"""Moves and a machine go in; for each move how long it speeds up, runs and slows down comes out, looking ahead."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from limner.motion.machine import Machine
from limner.motion.route import Route
from limner.types import Floats

_NOTHING = 1e-9
"""A phase that takes a smaller part of its move is only what rounding left."""


@dataclass(frozen=True)
class Profile:
    """Each move in three phases of constant acceleration: speeding up, running, slowing down.

    Attributes:
        length_mm: (m,) of the move.
        start_mm_s: (m,) speed at its start.
        peak_mm_s: (m,) speed in its middle phase.
        end_mm_s: (m,) speed at its end.
        phase_s: (m, 3) how long each phase takes.
    """

    length_mm: Floats
    start_mm_s: Floats
    peak_mm_s: Floats
    end_mm_s: Floats
    phase_s: Floats

    @property
    def seconds(self) -> Floats:
        """(m,) how long each move takes."""
        total: Floats = self.phase_s.sum(axis=1)
        return total


def profile(moves: Route, machine: Machine) -> Profile:
    """The fastest speeds within the limits, each corner known before it comes.

    The squared speed w at a vertex is limited by its corner, and by w <= w' + 2 a L from either neighbour. The greatest
    w that keeps all three is a running minimum from the left, then from the right: exact, and without a loop.
    """
    along = np.diff(moves.vertices_mm, axis=0)
    length = np.hypot(*along.T)
    speed = np.where(moves.draws, machine.draw_mm_s, machine.travel_mm_s)
    acceleration = np.where(moves.draws, machine.draw_mm_s2, machine.travel_mm_s2)
    squared = _reachable(_corner_limits(moves, along, length, machine) ** 2, 2 * acceleration * length)
    start, end = squared[:-1], squared[1:]
    peak = np.minimum(speed**2, acceleration * length + (start + end) / 2)
    peak = np.maximum(peak, np.maximum(start, end))
    run = np.maximum(length - (2 * peak - start - end) / (2 * acceleration), 0)
    v0, v, v1 = np.sqrt(start), np.sqrt(peak), np.sqrt(end)
    phases = np.stack([(v - v0) / acceleration, run / np.where(v > 0, v, 1), (v - v1) / acceleration], axis=1)
    phases[phases < _NOTHING * phases.sum(axis=1, keepdims=True)] = 0
    return _stretched(Profile(length, v0, v, v1, phases), machine.point_s)


def _corner_limits(moves: Route, along: Floats, length: Floats, machine: Machine) -> Floats:
    """(m + 1,) greatest speed at each vertex; 0 where the pen goes up or down, and at dots."""
    limit = np.zeros(len(length) + 1)
    through = moves.draws[:-1] & moves.draws[1:] & (length[:-1] > 0) & (length[1:] > 0)
    a, b = along[:-1][through], along[1:][through]
    turn = np.arctan2(np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]), (a * b).sum(axis=1))
    reach = (length[:-1][through] + length[1:][through]) / 2
    limit[1:-1][through] = machine.corner_speeds(turn, reach)
    return limit


def _reachable(limit: Floats, gain: Floats) -> Floats:
    """The greatest values w <= limit (m + 1,) that change by at most ``gain`` (m,) from one to the next."""
    total = np.concatenate([[0.0], np.cumsum(gain)])
    ahead = np.minimum.accumulate(limit - total) + total
    back = np.minimum.accumulate((ahead + total)[::-1])[::-1] - total
    reachable: Floats = np.clip(back, 0, limit)
    return reachable


def _stretched(fast: Profile, least_s: float) -> Profile:
    """The same motions, slowed evenly where they would take less than ``least_s``."""
    slower = np.maximum(least_s / np.maximum(fast.seconds, 1e-12), 1)
    slower[fast.length_mm == 0] = 1
    return Profile(
        fast.length_mm,
        fast.start_mm_s / slower,
        fast.peak_mm_s / slower,
        fast.end_mm_s / slower,
        fast.phase_s * slower[:, None],
    )
