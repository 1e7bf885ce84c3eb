"""A sequence of strokes by their two ends goes in; a shorter one, some of them turned round, comes out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from limner.types import Floats

Places = NDArray[np.complex128]

_LONGEST_BLOCK = 3
_GAIN = 1e-9


@dataclass
class Tour:
    """Strokes in the order in which they are drawn, between two stays at home; changed in place.

    Attributes:
        begin, end: (n + 2,) where each stroke begins and ends, x + i y; the first and last are home.
        stroke: (n,) which stroke stands there.
        flipped: (n,) whether it is drawn backwards.
    """

    begin: Places
    end: Places
    stroke: NDArray[np.int64]
    flipped: NDArray[np.bool_]

    @classmethod
    def of(cls, lines: Sequence[Floats], home: Floats) -> Tour:
        """The strokes as they stand."""
        begin = np.array([home, *(line[0] for line in lines), home]) @ [1, 1j]
        end = np.array([home, *(line[-1] for line in lines), home]) @ [1, 1j]
        return cls(begin, end, np.arange(len(lines)), np.zeros(len(lines), bool))

    def reverse(self, i: int, j: int) -> None:
        """Draw the strokes i..j (from 1, both included) in the opposite order and direction."""
        part = slice(i, j + 1)
        self.begin[part], self.end[part] = self.end[part][::-1].copy(), self.begin[part][::-1].copy()
        part = slice(i - 1, j)
        self.stroke[part] = self.stroke[part][::-1].copy()
        self.flipped[part] = ~self.flipped[part][::-1]


def improve(tour: Tour) -> Tour:
    """One round of 2-opt and of Or-opt over all strokes (Or 1976: move up to three to a better place)."""
    n = len(tour.stroke)
    for i in range(1, n + 1):
        _reverse_best(tour, i)
    for block in range(1, min(_LONGEST_BLOCK, n - 1) + 1):
        for i in range(1, n - block + 2):
            _move_best(tour, i, i + block - 1)
    return tour


def _reverse_best(tour: Tour, i: int) -> None:
    """Reverse the run of strokes from ``i`` that saves most travel, if any does."""
    begin, end = tour.begin, tour.end
    before, ends, nexts = end[i - 1], end[i:-1], begin[i + 1 :]
    saved = np.abs(ends - nexts) - np.abs(ends - before) - np.abs(nexts - begin[i])
    best = int(saved.argmax())
    if saved[best] + abs(before - begin[i]) > _GAIN:
        tour.reverse(i, i + best)


def _move_best(tour: Tour, i: int, j: int) -> None:
    """Move the strokes i..j to the gap, and in the direction, that saves most travel, if any does."""
    begin, end = tour.begin, tour.end
    first, last = begin[i], end[j]
    freed = abs(end[i - 1] - first) + abs(last - begin[j + 1]) - abs(end[i - 1] - begin[j + 1])
    if freed <= _GAIN:
        return
    ends, nexts = end[:-1], begin[1:]
    gap = np.abs(ends - nexts)
    forwards = gap - np.abs(ends - first) - np.abs(nexts - last)
    backwards = gap - np.abs(ends - last) - np.abs(nexts - first)
    forwards[i - 1 : j + 1] = backwards[i - 1 : j + 1] = -np.inf
    k = int(np.maximum(forwards, backwards).argmax())
    if freed + max(forwards[k], backwards[k]) <= _GAIN:
        return
    # A move is two or three reversals: of the block with what lies between it and the gap, then of each of them.
    low, high = (k + 1, j) if k < i else (i, k)
    size = j - i + 1
    tour.reverse(low, high)
    block = (low, low + size - 1) if k < i else (high - size + 1, high)
    rest = (low + size, high) if k < i else (low, high - size)
    tour.reverse(*rest)
    if forwards[k] >= backwards[k]:
        tour.reverse(*block)
