"""A drawing as it was traced goes in; one without crumbs, needless lifts and needless points comes out."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from limner import geometry
from limner.drawing.doubles import without_doubles
from limner.drawing.join import Chain, chains
from limner.errors import NothingToDraw
from limner.settings import SettingsGroup, setting
from limner.types import Drawing, Floats


@dataclass(frozen=True)
class CleanSettings(SettingsGroup):
    """What is joined, dropped and smoothed away before strokes are chosen."""

    join_mm: float = setting(
        0.8, "ends of one region's strokes nearer than this are joined; 0 joins none", unit="mm", low=0, high=50
    )
    min_length_mm: float = setting(1.0, "shorter strokes are dropped; 0 keeps dots too", unit="mm", low=0, high=1000)
    double_pens: float = setting(
        1.0,
        "what runs nearer than this beside a heavier line is left out; 0 draws both",
        unit="pen widths",
        low=0,
        high=20,
    )
    tolerance_mm: float = setting(0.15, "a line may move by this to have fewer points", unit="mm", low=0, high=50)


def clean(drawing: Drawing, settings: CleanSettings) -> Drawing:
    """Draw doubled lines once, join strokes whose ends meet, drop crumbs, simplify.

    Lines of different pens have nothing to do with each other. Point trimming by the shape of the line, not only by the
    distance to the next point as in the thesis (4.3.1). Joined strokes weigh as much as their parts together.

    Args:
        drawing: strokes in any order.
        settings: the lengths.

    Returns:
        The drawing with the strokes in the order of their first parts; of each point of a kept stroke the distance
        to the result is at most ``settings.tolerance_mm``, and that of a line left out as double a pen width more.

    Raises:
        NothingToDraw: every stroke is shorter than ``settings.min_length_mm``.
    """
    kept = [piece for part in drawing.by_pen() for piece in _cleaned(part, settings)]
    if drawing.lines_mm and not kept:
        raise NothingToDraw(
            f"every stroke is shorter than {settings.min_length_mm:g} mm (min_length_mm); choose less, or a larger page"
        )
    return dataclasses.replace(
        drawing,
        lines_mm=tuple(line for line, _, _, _ in kept),
        region=tuple(region for _, region, _, _ in kept),
        weight=np.array([weight for _, _, weight, _ in kept]),
        layer=np.array([layer for _, _, _, layer in kept], np.int64),
    )


def _cleaned(drawing: Drawing, settings: CleanSettings) -> list[tuple[Floats, str, float, int]]:
    """Line, region, weight and layer of what is left of a drawing of one pen."""
    given = [geometry.without_repeats(line) for line in drawing.lines_mm]
    pieces = without_doubles(given, drawing.weight, settings.double_pens * drawing.pen.width_mm)
    lines = [piece.line for piece in pieces]
    regions = [drawing.region[piece.source] for piece in pieces]
    weights = [float(drawing.weight[piece.source]) * piece.share for piece in pieces]
    linked = [(_linked(lines, chain, closed), chain) for chain, closed in chains(lines, regions, settings.join_mm)]
    long = [(line, chain) for line, chain in linked if geometry.length(line) >= settings.min_length_mm]
    # A closed line that shrinks to nothing becomes a dot.
    few = map(geometry.without_repeats, geometry.simplify_all([line for line, _ in long], settings.tolerance_mm))
    layer = int(drawing.layer[0])
    return [
        (line, regions[chain[0][0]], sum(weights[i] for i, _ in chain), layer)
        for line, (_, chain) in zip(few, long, strict=True)
    ]


def _linked(lines: list[Floats], chain: Chain, closed: bool) -> Floats:
    parts = [lines[i][::-1] if backwards else lines[i] for i, backwards in chain]
    return geometry.without_repeats(np.concatenate(parts + ([parts[0][:1]] if closed else [])))
