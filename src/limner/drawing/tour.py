"""Ends of strokes in the order of a tour go in; shorter tours through the same strokes come out.

A tour is a row of places 0, 1, 2, ... with two for each stroke: it is entered at the even place and left at the odd
one. Where the pen comes from and goes to stands at both ends of the row and stays there. A move cuts the row into
pieces and puts two or three of them together anew, some of them turned round.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from limner.drawing.neighbours import nearest
from limner.types import Floats

Pieces = tuple[tuple[int, int, bool], ...]
"""Runs of places, first and last included, and whether each is turned round; together they fill one run anew."""

_NEAR = 10
_NEAR_AT_SECOND = 5
_LEAST_GAIN = 1e-9
_ROUNDING = 1e-12
_LONGEST_RUN = 30


class Tour:
    """A tour that can be changed, and changed back.

    Args:
        ends: (2 n, 2) where the tour ends and where it starts, then begin and end of each stroke.
        row: the ends as a tour: two for each stroke, 0 and 1 first.
        longest: no move may touch more places than this, so that one move costs little on a huge tour.
    """

    def __init__(self, ends: Floats, row: list[int], longest: int) -> None:
        n = len(ends)
        # The end of the row is another place than its start, if only in name.
        self.row = [*row, n, n + 1]
        self.at = [0] * (n + 2)
        # Numbers made once: a move writes down the places of all it touches.
        self._places = list(range(n + 2))
        for end, place in zip(self.row, self._places, strict=True):
            self.at[end] = place
        ends = np.concatenate([ends, ends[:1], ends[:1]])
        self.where: list[complex] = (ends @ [1, 1j]).tolist()
        # A hop is asked for far more often than it changes: of each end the one it leads to, and how far that is.
        self.over, self.gap = [-1] * (n + 2), [0.0] * (n + 2)
        for place in range(1, n + 1, 2):
            self._join(self.row[place], self.row[place + 1])
        self.near = _near(ends)
        self.nearest = [near[:_NEAR_AT_SECOND] for near in self.near]
        self.longest = longest
        self.remember = False
        self.undo: list[tuple[int, list[int], list[tuple[int, int]]]] = []

    def length(self) -> float:
        """Of all hops."""
        places = np.array(self.where)[self.row]
        return float(np.abs(places[2::2] - places[1:-1:2]).sum())

    def _join(self, a: int, b: int) -> None:
        """A hop leads from one end to the other."""
        self.over[a], self.over[b] = b, a
        self.gap[a] = self.gap[b] = abs(self.where[a] - self.where[b])

    def settle(self, todo: Iterable[int]) -> float:
        """Make moves that begin at the given ends, and at those that the moves touch, until none gains.

        Returns:
            What was gained.
        """
        queue = list(todo)
        waiting = set(queue)
        gained = 0.0
        k = 0
        while k < len(queue):
            end = queue[k]
            k += 1
            waiting.discard(end)
            gain, pieces = self._best(end)
            while gain > _LEAST_GAIN:
                gained += gain
                for touched in self.make(pieces):
                    if touched not in waiting:
                        waiting.add(touched)
                        queue.append(touched)
                gain, pieces = self._best(end)
        return gained

    def make(self, pieces: Pieces) -> list[int]:
        """Put the pieces together; the ends at their seams are returned."""
        row, at = self.row, self.at
        low = min(pieces)[0]
        new: list[int] = []
        seams = [row[low - 1]]
        hops: list[tuple[int, int]] = []
        before = row[low - 1]
        for first, last, turned in pieces:
            part = row[first : last + 1]
            seams += [row[first], row[last]]
            if turned:
                part.reverse()
            hops.append((before, part[0]))
            before = part[-1]
            new += part
        high = low + len(new)
        seams.append(row[high])
        hops.append((before, row[high]))
        if self.remember:
            cut = [row[low - 1], *(row[last] for _, last, _ in pieces)]
            self.undo.append((low, row[low:high], [(end, self.over[end]) for end in cut]))
        row[low:high] = new
        for a, b in hops:
            self._join(a, b)
        for end, place in zip(new, self._places[low:high], strict=True):
            at[end] = place
        return seams

    def back(self) -> None:
        """Undo every move since ``undo`` was last cleared."""
        for low, old, hops in reversed(self.undo):
            self.row[low : low + len(old)] = old
            for a, b in hops:
                self._join(a, b)
            for end, place in zip(old, self._places[low : low + len(old)], strict=True):
                self.at[end] = place
        self.undo.clear()

    def hop(self, place: int) -> float:
        """Length of the hop from an odd place to the next."""
        return self.gap[self.row[place]]

    def _best(self, end: int) -> tuple[float, Pieces]:
        """The best move that replaces the hop at this end, and what it gains; 0 when none does.

        Hops are replaced one after another as long as what is saved outweighs what is added (Lin & Kernighan 1973,
        doi:10.1287/opre.21.2.498), to a depth of three.
        """
        last = len(self.row) - 1
        place = self.at[end]
        if place in (0, last):
            return 0.0, ()
        if place & 1:
            return self._search(end, 0, 1)
        # Seen from an end where a stroke is entered the row runs backwards.
        gain, pieces = self._search(end, last, -1)
        return gain, tuple((last - high, last - low, turned) for low, high, turned in reversed(pieces))

    def _search(self, a: int, base: int, sign: int) -> tuple[float, Pieces]:
        """The best move that replaces the hop from a, which is left, the row seen as ``row[base + sign * place]``.

        The hop a-b goes for one from a to a near c; then the hop at c has to go, too. Where c is left (odd) the hop
        c-d follows, the run between turns round, and b-d closes the gap; where c is entered (even) the run is cut
        out. In either case a third hop may come in: from d to a near e, in place of e-f, and b-f closes the gap.
        """
        at, where, over, gaps, nearest = self.at, self.where, self.over, self.gap, self.nearest
        p = base + sign * at[a]
        zb = where[over[a]]
        old = gaps[a]
        best = 0.0
        pieces: Pieces = ()
        for c, gap in self.near[a]:
            saved = old - gap
            if saved <= _ROUNDING:
                break
            q = base + sign * at[c]
            d = over[c]
            saved += gaps[c]
            if q & 1:
                gain = saved - abs(zb - where[d])
                if gain > best and abs(q - p) <= self.longest:
                    best, pieces = gain, (((p + 1, q, True) if q > p else (q + 1, p, True)),)
            close = nearest[d]
            if close and saved - close[0][1] > best:
                best, pieces = self._third((base, sign, p, q, zb), close, saved, (best, pieces))
        return best, pieces

    def _third(
        self,
        seen: tuple[int, int, int, int, complex],
        close: list[tuple[int, float]],
        saved: float,
        best: tuple[float, Pieces],
    ) -> tuple[float, Pieces]:
        """The best of ``best`` and the moves with a third hop.

        Args:
            seen: base, sign, p, q and where b is, of ``_search``.
            close: ends near d, and how far.
            saved: by the first two hops, less what the hop from a to c costs.
            best: a gain, and the move that makes it.
        """
        base, sign, p, q, zb = seen
        where, over, gaps = self.where, self.over, self.gap
        made = _turned if q & 1 else _cut
        gained, pieces = best
        for e, gap in close:
            still = saved - gap
            if still <= gained:
                break
            gain = still + gaps[e] - abs(where[over[e]] - zb)
            if gain <= gained:
                continue
            # Most moves gain nothing: where e is and whether it makes a tour is asked of the others only.
            found = made(p, q, base + sign * self.at[e])
            if found and max(found[0][1], found[1][1]) - min(found[0][0], found[1][0]) < self.longest:
                gained, pieces = gain, found
        return gained, pieces


def _turned(p: int, q: int, r: int) -> Pieces | None:
    """The three-hop move after c is left at q (odd): e stands at r; None when it makes no tour."""
    odd = bool(r & 1)
    if q > p:
        if p < r <= q:
            return ((r + 1, q, True), (p + 1, r, False)) if odd and r != q else None
        if odd or r == q + 1:
            return None
        return ((p + 1, q, True), (q + 1, r - 1, True)) if r > q else ((p + 1, q, False), (r, p, True))
    if q < r <= p:
        return ((r, p, True), (q + 1, r - 1, False)) if not odd and r != q + 1 else None
    if not odd or r == q:
        return None
    return ((q + 1, p, False), (r + 1, q, True)) if r < q else ((q + 1, p, True), (p + 1, r, True))


def _cut(p: int, q: int, r: int) -> Pieces | None:
    """The three-hop move after c is entered at q (even), by which a run is cut out: e stands at r."""
    odd = bool(r & 1)
    if q > p + 1:
        if r > q:
            return ((q, r, False), (p + 1, q - 1, True)) if odd else ((q, r - 1, False), (p + 1, q - 1, False))
        if r < p and odd:
            return ((p + 1, q - 1, True), (r + 1, p, False))
        return ((p + 1, q - 1, False), (r, p, False)) if r < p else None
    if q < r < p:
        return ((q, r, True), (r + 1, p, True)) if odd else ((r, p, False), (q, r - 1, False))
    return None


def _near(ends: Floats) -> list[list[tuple[int, float]]]:
    """Near ends of each end and how far they are, the nearest first: of other strokes, and none that home moves at."""
    near = nearest(ends[1:-1], _NEAR + 1) + 1
    gaps = np.hypot(*(ends[1:-1, None] - ends[near]).transpose(2, 0, 1))
    lists = [
        [(b, gap) for b, gap in zip(row, far, strict=True) if b != mate ^ 1][:_NEAR]
        for mate, (row, far) in enumerate(zip(near.tolist(), gaps.tolist(), strict=True), 1)
    ]
    return [[], *lists, []]


def shake(tour: Tour, kicks: int, seed: int = 0) -> float:
    """Swap two neighbouring runs of the tour somewhere, settle, take it back when it did not help; again and again.

    Iterated local search with a double bridge of short runs (Martin, Otto & Felten 1991). The same seed gives the
    same tour.

    Args:
        tour: settled; it is changed.
        kicks: how often.
        seed: of the places.

    Returns:
        What was gained.
    """
    strokes = len(tour.row) // 2 - 2
    if strokes < 4:
        return 0.0
    longest = min(_LONGEST_RUN, strokes // 2)
    rng = np.random.default_rng(seed)
    one, other = rng.integers(1, longest + 1, (2, kicks)).tolist()
    starts = rng.random(kicks).tolist()
    gained = 0.0
    tour.remember = True
    for share, m, n in zip(starts, one, other, strict=True):
        p = 1 + 2 * int(share * (strokes - m - n + 1))
        cut, end = p + 2 * m, p + 2 * (m + n)
        before = tour.hop(p) + tour.hop(cut) + tour.hop(end)
        seams = tour.make(((cut + 1, end, False), (p + 1, cut, False)))
        cut = p + 2 * n
        gain = before - tour.hop(p) - tour.hop(cut) - tour.hop(end) + tour.settle(seams)
        if gain < 0:
            tour.back()
        else:
            gained += gain
            tour.undo.clear()
    tour.remember = False
    return gained
