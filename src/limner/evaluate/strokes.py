"""Strokes go in; how short their order is, and how few curves they need, come out."""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np

from limner import bezier, geometry
from limner.drawing.measure import HOME_MM, measure
from limner.drawing.order import OrderSettings, Row as OrderedRow, order
from limner.evaluate.speed import Row
from limner.targets.svg import to_svg
from limner.targets.svg_read import read_svg
from limner.types import Drawing, Floats

COUNTS = (100, 300, 1000, 3000)
"""How many strokes are put in order."""

TOLERANCE_MM = 0.15
_VPYPE = "vpype linemerge linesort"


def measure_strokes(
    drawing: Drawing, counts: Sequence[int] = COUNTS, kicks: int = 200, smooth: int = 20
) -> Iterator[Row]:
    """Compare travel with what a far longer search finds and, where it is installed, with vpype's; then curves.

    Args:
        drawing: a portrait with many strokes, finely traced.
        counts: of scattered strokes to be put in order.
        kicks: per stroke, of the long search.
        smooth: how many smooth lines are followed by curves.

    Yields:
        One row after the other, as they are ready.
    """
    sets = [("portrait", drawing), *((f"{count} scattered strokes", scattered(count)) for count in counts)]
    for name, strokes in sets:
        start = time.process_time()
        ordered = order(strokes, OrderSettings())
        seconds = time.process_time() - start
        found = measure(ordered).travel_mm
        home = np.array(HOME_MM)
        best = OrderedRow.of(ordered).settled(home, home, kicks * len(strokes.lines_mm), seed=1).travel_mm()
        yield Row(f"travel, {name}, x of the best known", found / best, "", 1.03)
        yield Row(f"time for it, {name}", seconds, "s", 2.0)
        if vpype_program():
            yield Row(f"travel, {name}, x of {_VPYPE}", found / vpype_travel_mm(strokes), "", 0.85)
    yield from _curve_rows("portrait", drawing.lines_mm)
    yield from _curve_rows("smooth lines", [swing(seed) for seed in range(smooth)])


def scattered(count: int, seed: int = 1) -> Drawing:
    """Straight strokes of any direction, most of them short, all over a page."""
    rng = np.random.default_rng(seed)
    middles = rng.uniform([10, 10], [138, 200], (count, 2))
    halves = rng.exponential(2.0, count) * np.exp(1j * rng.uniform(0, 2 * np.pi, count))
    away = np.stack([halves.real, halves.imag], axis=1)
    lines = tuple(np.stack([middles - away, middles + away], axis=1))
    return Drawing(lines, ("face",) * count, np.ones(count))


def swing(seed: int) -> Floats:
    """A smooth line of chance [mm], finely sampled."""
    rng = np.random.default_rng(seed)
    t = np.linspace(0, 1, 400)
    waves = [np.exp(2j * np.pi * k * t) * complex(*rng.normal(0, 8 / k, 2)) for k in (1, 2, 3)]
    place = np.sum(waves, axis=0) + 40 * t
    return np.stack([place.real, place.imag], axis=1)


def vpype_program() -> str | None:
    """Where vpype's command is: beside this Python, or wherever the shell finds it; None if it is not installed."""
    return shutil.which("vpype", path=str(Path(sys.executable).parent)) or shutil.which("vpype")


def vpype_travel_mm(drawing: Drawing) -> float:
    """What vpype's usual commands leave of the travel; the command must be installed."""
    return measure(through_vpype(drawing)).travel_mm


def through_vpype(drawing: Drawing) -> Drawing:
    """A drawing, its lines merged and sorted by vpype's usual commands; the command must be installed."""
    with tempfile.TemporaryDirectory() as folder:
        given, sorted_ = Path(folder) / "given.svg", Path(folder) / "sorted.svg"
        given.write_bytes(to_svg(drawing))
        program = vpype_program() or "vpype"
        command = [program, "read", "--quantization", "0.001mm", str(given), "linemerge", "linesort", "write"]
        subprocess.run([*command, str(sorted_)], check=True, capture_output=True)
        return read_svg(sorted_)


def _curve_rows(name: str, lines: Sequence[Floats]) -> Iterator[Row]:
    curves = [bezier.fit(line, TOLERANCE_MM) for line in lines]
    knots = sum(len(some) + 1 for some in curves)
    points = sum(len(geometry.simplify(line, TOLERANCE_MM)) for line in lines)
    yield Row(f"knots of curves, {name}, x of Douglas-Peucker's points", knots / points, "", 1 / 3)
    worst = max(_apart(line, some) for line, some in zip(lines, curves, strict=True))
    yield Row(f"curve and line apart at most, {name}", worst, "mm", TOLERANCE_MM)


def _apart(line: Floats, curves: Floats) -> float:
    dense = bezier.at(curves, np.linspace(0, 1, 200)).reshape(-1, 2)
    return max(_farthest(geometry.resample(line, 0.1), dense), _farthest(dense[::4], line))


def _farthest(points: Floats, line: Floats) -> float:
    pairs = pairwise(line if len(line) > 1 else np.repeat(line, 2, axis=0))
    return float(np.min([geometry.distance_to_segments(points, a, b) for a, b in pairs], axis=0).max())
