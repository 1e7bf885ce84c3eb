"""A drawing goes in; the same strokes in an order and direction with little pen-up travel come out."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from limner import geometry
from limner.drawing.measure import HOME_MM, travel_hops_mm
from limner.drawing.start import greedy_tour
from limner.drawing.tour import Tour, shake
from limner.settings import SettingsGroup, setting
from limner.types import REGIONS, Drawing, Floats

AUDIENCE: tuple[tuple[str, ...], ...] = (
    ("jaw", "ear"),
    ("eye", "brow"),
    ("nose",),
    ("mouth",),
    ("hair",),
    ("face", "body", "background"),
)
"""What is drawn one after the other before an audience: the contour, then the features, then what frames them."""

_MOST_KICKS = 16_000
_LONGEST_MOVE = 50_000
_LONGEST_MOVE_OF_MANY = 1_000
_MANY = 20_000
_TURNS_OF_RINGS = 2


@dataclass(frozen=True)
class OrderSettings(SettingsGroup):
    """In which order the strokes are drawn, and how hard a short way between them is looked for."""

    by: str = setting(
        "travel",
        "the shortest way between the strokes; what an audience likes to see, contour, eyes, nose, mouth, hair, and"
        " the shortest way within each; or as given",
        choices=("travel", "audience", "given"),
    )
    kicks: int = setting(
        20,
        f"how often the order is shaken to find a shorter one, at most {_MOST_KICKS} together",
        unit="per stroke",
        low=0,
        high=100_000,
    )
    seed: int = setting(0, "of the chance by which the order is shaken", low=0, high=1_000_000)


def order(drawing: Drawing, settings: OrderSettings) -> Drawing:
    """Sequence and turn the strokes so that the pen travels little between them.

    The shortest hops first, then a local search over moves of two and three hops (Lin & Kernighan 1973) that is shaken
    out of its dead ends; pen by pen, since to change them is a stop; a closed stroke may begin at any of its points.
    Bounded by steps and not by time, so the same drawing gives the same order.

    Args:
        drawing: strokes in any order.
        settings: what goes first, and how hard to look.

    Returns:
        The same strokes; ordered by travel their travel, as ``measure`` counts it, is never longer than it was.
    """
    if not drawing.lines_mm or settings.by == "given":
        return drawing
    home = np.array(HOME_MM)
    groups = AUDIENCE if settings.by == "audience" else (None,)
    parts = [Row.of(drawing, regions, layer) for layer in range(len(drawing.pens)) for regions in groups]
    parts = [part for part in parts if part.lines]
    sequence: list[int] = []
    lines: list[Floats] = []
    here = home
    for part, after in zip(parts, [*parts[1:], None], strict=True):
        part = part.shortened(here, after.middle() if after else home, settings)
        sequence, lines, here = sequence + part.sequence, lines + part.lines, part.lines[-1][-1]
    found = Row(sequence, lines)
    shorter = settings.by == "audience" or found.travel_mm() < travel_mm(drawing)
    return found.of_drawing(drawing) if shorter else drawing


def travel_mm(drawing: Drawing) -> float:
    """Length of all pen-up moves."""
    return float(travel_hops_mm(drawing.lines_mm).sum())


@dataclass(frozen=True)
class Row:
    """Strokes of a drawing in a row.

    Attributes:
        sequence: of each its index in the drawing.
        lines: turned, and begun, as they are to be drawn.
    """

    sequence: list[int]
    lines: list[Floats]

    @classmethod
    def of(cls, drawing: Drawing, regions: Sequence[str] | None = None, layer: int = 0) -> Row:
        """A pen's strokes, or those of some regions, as they stand."""
        regions = REGIONS if regions is None else regions
        some = [i for i, k in enumerate(drawing.layer) if k == layer and drawing.region[i] in regions]
        return cls(some, [drawing.lines_mm[i] for i in some])

    def of_drawing(self, drawing: Drawing) -> Drawing:
        """The drawing in this order."""
        return dataclasses.replace(drawing.pick(self.sequence), lines_mm=tuple(self.lines))

    def middle(self) -> Floats:
        """Where the ends of the strokes are on average."""
        middle: Floats = np.mean([line[k] for line in self.lines for k in (0, -1)], axis=0)
        return middle

    def travel_mm(self) -> float:
        """Length of all pen-up moves, from home and back."""
        return float(travel_hops_mm(self.lines).sum())

    def shortened(self, start: Floats, finish: Floats, settings: OrderSettings) -> Row:
        """The strokes in a row that is short from ``start`` over all of them to ``finish``."""
        row = self.settled(start, finish, 0, greedy=True)
        rings = any(map(geometry.is_closed, self.lines))
        # The best beginnings of rings depend on the order, and the order on them.
        for _ in range(_TURNS_OF_RINGS if rings else 0):
            row = row._begun_best(start, finish).settled(start, finish, 0)
        row = row.settled(start, finish, min(settings.kicks * len(self.lines), _MOST_KICKS), settings.seed)
        return row._begun_best(start, finish).settled(start, finish, 0)._begun_best(start, finish) if rings else row

    def settled(self, start: Floats, finish: Floats, kicks: int, seed: int = 0, greedy: bool = False) -> Row:
        """The strokes moved about until no move gains, shaken so often and settled again."""
        ends = np.array([finish, start, *(line[k] for line in self.lines for k in (0, -1))])
        row = greedy_tour(ends) if greedy else list(range(len(ends)))
        tour = Tour(ends, row, _LONGEST_MOVE if len(self.lines) < _MANY else _LONGEST_MOVE_OF_MANY)
        tour.settle(row[1:])
        shake(tour, kicks, seed)
        entered = [(end // 2 - 1, bool(end % 2)) for end in tour.row[2:-2:2]]
        lines = [self.lines[i][::-1] if turned else self.lines[i] for i, turned in entered]
        return Row([self.sequence[i] for i, _ in entered], lines)

    def _begun_best(self, start: Floats, finish: Floats) -> Row:
        """Each ring begun where the way from the stroke before and on to the next is shortest."""
        lines = list(self.lines)
        for i, line in enumerate(lines):
            if geometry.is_closed(line):
                before = lines[i - 1][-1] if i else start
                after = lines[i + 1][0] if i + 1 < len(lines) else finish
                way = np.hypot(*(line[:-1] - before).T) + np.hypot(*(line[:-1] - after).T)
                lines[i] = begin_at(line, int(way.argmin()))
        return Row(self.sequence, lines)


def begin_at(line: Floats, k: int) -> Floats:
    """A closed line that begins and ends at its point ``k``."""
    return np.concatenate([line[k:-1], line[: k + 1]])
