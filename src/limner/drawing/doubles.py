"""Lines go in; what runs so close beside a heavier one that the pen would draw it twice is left out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from limner import geometry
from limner.drawing.neighbours import nearest
from limner.types import Floats

_PARALLEL = np.cos(np.deg2rad(25))
_LOOK_AT = 6
_ROUNDS = 4
_SHORTEST_RUN = 4.0
"""Lines that run side by side for less than this many widths cross, or meet."""


@dataclass(frozen=True)
class Piece:
    """What is left of a line.

    Attributes:
        line: (n, 2).
        source: index of the line it is of.
        share: of that line's length.
    """

    line: Floats
    source: int
    share: float


def without_doubles(lines: Sequence[Floats], weight: Floats, width: float) -> list[Piece]:
    """Leave out the parts of lines that run beside a heavier line, nearer than ``width`` and parallel to it.

    Args:
        lines: polylines.
        weight: (lines,); of two that weigh the same the first stays.
        width: of the pen, in the unit of the lines; 0 leaves all.

    Returns:
        The pieces in the order of their lines: one with all of it for each line that is nowhere double.
    """
    whole = [Piece(line, i, 1.0) for i, line in enumerate(lines)]
    step = width
    parts = [geometry.resample(line, step) if len(line) > 1 else line for line in lines] if width > 0 else []
    sizes = np.array([len(part) for part in parts], np.int64)
    if sizes.sum() < 2:
        return whole
    stroke = np.repeat(np.arange(len(lines)), sizes)
    covered = _covered(np.concatenate(parts), _ways(parts), stroke, weight, width)
    pieces: list[Piece] = []
    for piece, mask in zip(whole, np.split(covered, np.cumsum(sizes)[:-1]), strict=True):
        kept = _runs_kept(mask, int(np.ceil(_SHORTEST_RUN * width / step)))
        pieces += [piece] if kept is None else _cut(piece, kept, len(mask))
    return pieces


def _ways(parts: Sequence[Floats]) -> Floats:
    """Unit directions at all points; 0 for dots."""
    ways = [np.gradient(part, axis=0) if len(part) > 1 else np.zeros((1, 2)) for part in parts]
    joined = np.concatenate(ways)
    unit: Floats = joined / np.maximum(np.hypot(*joined.T), 1e-12)[:, None]
    return unit


def _covered(
    points: Floats, ways: Floats, stroke: NDArray[np.int64], weight: Floats, width: float
) -> NDArray[np.bool_]:
    """Which points lie beside a point of a heavier line that stays."""
    near = nearest(points, _LOOK_AT)
    rank = np.empty(len(weight), np.int64)
    rank[np.argsort(-weight, kind="stable")] = np.arange(len(weight))
    away = points[:, None] - points[near]
    # The nearest sample may be half a step farther along; how far the line is aside is what counts.
    aside = np.abs(away[..., 0] * ways[near, 1] - away[..., 1] * ways[near, 0])
    beside = (aside < width) & (np.hypot(away[..., 0], away[..., 1]) < 1.2 * width)
    beside &= np.abs((ways[:, None] * ways[near]).sum(axis=2)) > _PARALLEL
    beside &= rank[stroke[near]] < rank[stroke][:, None]
    covered = np.zeros(len(points), bool)
    for _ in range(_ROUNDS):
        covered = (beside & ~covered[near]).any(axis=1)
    # Only what has its cover in the end is left out.
    result: NDArray[np.bool_] = covered & (beside & ~covered[near]).any(axis=1)
    return result


def _runs_kept(covered: NDArray[np.bool_], shortest: int) -> list[tuple[int, int]] | None:
    """Runs of points (first, last) outside the long runs of covered ones; None when there is no such run."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], covered, [False]]).astype(np.int8)))
    doubles = [(a, b) for a, b in edges.reshape(-1, 2).tolist() if b - a >= min(shortest, len(covered))]
    if not doubles:
        return None
    kept, start = [], 0
    for a, b in doubles:
        # One point over, so that the ink still meets.
        kept.append((start, min(a, len(covered) - 1)))
        start = b - 1
    kept.append((start, len(covered) - 1))
    return [(a, b) for a, b in kept if b > a + 1]


def _cut(piece: Piece, kept: list[tuple[int, int]], count: int) -> list[Piece]:
    """The line between places of its ``count`` even samples."""
    line = piece.line
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    places = np.linspace(0, along[-1], count)
    pieces = []
    for a, b in kept:
        ends = np.stack([np.interp(places[[a, b]], along, line[:, k]) for k in (0, 1)], axis=1)
        inside = line[(along > places[a]) & (along < places[b])]
        part = np.concatenate([ends[:1], inside, ends[1:]])
        pieces.append(Piece(part, piece.source, (b - a) / (count - 1)))
    return pieces
