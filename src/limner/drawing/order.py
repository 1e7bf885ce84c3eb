"""A drawing goes in; the same strokes in an order and direction with little pen-up travel come out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from limner import geometry
from limner.drawing.measure import HOME_MM, travel_hops_mm
from limner.drawing.tour import Tour, improve
from limner.settings import SettingsGroup, setting
from limner.types import Drawing, Floats

_LEAST_GAIN = 0.002


@dataclass(frozen=True)
class OrderSettings(SettingsGroup):
    """How hard a short way between the strokes is looked for."""

    passes: int = setting(
        20, "rounds of improving the order, each over all strokes; 0 keeps the order given", low=0, high=1000
    )


def order(drawing: Drawing, settings: OrderSettings) -> Drawing:
    """Sequence and turn the strokes so that the pen travels little between them.

    The nearest end next, then rounds of 2-opt and Or-opt until one gains less than 1/500; a closed stroke may begin
    at any of its points. Deterministic, as it is bounded by rounds and not by time.

    Args:
        drawing: strokes in any order.
        settings: how many rounds.

    Returns:
        The same strokes; their travel, as ``measure`` counts it, is never longer than it was.
    """
    if not drawing.lines_mm or settings.passes == 0:
        return drawing
    sequence, lines = _nearest_next(drawing.lines_mm)
    if _travel_mm(lines) > _travel_mm(drawing.lines_mm):
        sequence, lines = list(range(len(drawing.lines_mm))), list(drawing.lines_mm)
    for _ in range(settings.passes):
        before = _travel_mm(lines)
        tour = improve(Tour.of(lines, np.array(HOME_MM)))
        sequence = [sequence[i] for i in tour.stroke]
        lines = [lines[i][::-1] if flip else lines[i] for i, flip in zip(tour.stroke, tour.flipped, strict=True)]
        lines = _begin_best(lines)
        if _travel_mm(lines) > before * (1 - _LEAST_GAIN):
            break
    if _travel_mm(lines) > _travel_mm(drawing.lines_mm):
        return drawing
    return Drawing(
        tuple(lines),
        tuple(drawing.region[i] for i in sequence),
        drawing.weight[sequence],
        drawing.page,
        drawing.pen,
    )


def _travel_mm(lines: Sequence[Floats]) -> float:
    return float(travel_hops_mm(lines).sum())


def begin_at(line: Floats, k: int) -> Floats:
    """A closed line that begins and ends at its point ``k``."""
    return np.concatenate([line[k:-1], line[: k + 1]])


def _nearest_next(lines: tuple[Floats, ...]) -> tuple[list[int], list[Floats]]:
    """From home always on to the nearest point where a stroke can begin."""
    places, stroke, vertex = _beginnings(lines)
    free = np.ones(len(places), bool)
    here = np.array(HOME_MM)
    sequence: list[int] = []
    turned: list[Floats] = []
    while free.any():
        distance = np.hypot(places[:, 0] - here[0], places[:, 1] - here[1])
        k = int(np.where(free, distance, np.inf).argmin())
        i = int(stroke[k])
        turned.append(_begun(lines[i], int(vertex[k])))
        sequence.append(i)
        free[stroke == i] = False
        here = turned[-1][-1]
    return sequence, turned


def _beginnings(lines: tuple[Floats, ...]) -> tuple[Floats, NDArray[np.int64], NDArray[np.int64]]:
    """Where strokes can begin: both ends of an open one, any point of a closed one; (n, 2), its stroke, its index."""
    where = [np.arange(len(line) - 1) if geometry.is_closed(line) else np.unique([0, len(line) - 1]) for line in lines]
    places = np.concatenate([line[k] for line, k in zip(lines, where, strict=True)])
    return places, np.repeat(np.arange(len(lines)), [len(k) for k in where]), np.concatenate(where)


def _begun(line: Floats, k: int) -> Floats:
    if geometry.is_closed(line):
        return begin_at(line, k)
    return line[::-1] if k else line


def _begin_best(lines: list[Floats]) -> list[Floats]:
    """Each closed stroke begun where the way from the stroke before and on to the next is shortest."""
    home = np.array([HOME_MM])
    result = list(lines)
    for i, line in enumerate(lines):
        if geometry.is_closed(line):
            before = result[i - 1][-1:] if i else home
            after = lines[i + 1][:1] if i + 1 < len(lines) else home
            way = np.hypot(*(line[:-1] - before).T) + np.hypot(*(line[:-1] - after).T)
            result[i] = begin_at(line, int(way.argmin()))
    return result
