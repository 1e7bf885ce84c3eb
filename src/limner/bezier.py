"""Polylines go in; few cubic Bezier curves near them come out, or points along such curves, denser where they bend."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from limner import geometry
from limner.types import Floats

CORNER_DEG = 50.0
"""A sharper bend stays a corner."""

_REACH = 4.0
_SAMPLES = 30
_ROUNDS = 4
_MARGIN = 0.85
_MOST_POINTS = 4000
_DENSE = 48
_AT_ONCE = 100_000


def fit(line: Floats, tolerance: float) -> Floats:
    """The fewest cubic Bezier curves found that follow a line, smooth but at its corners.

    From each knot the longest stretch that one cubic can follow: least squares with the tangents given where the curve
    goes on smoothly, parameters improved by Newton's method (Schneider 1990, in Graphics Gems, ch. 9). Where curves
    would need no fewer knots than straight lines do, straight lines are returned.

    Args:
        line: (n, 2) in any unit; closed when first = last.
        tolerance: no point of the line is farther from the curves than this, and none of theirs from the line.

    Returns:
        (m, 4, 2) control points, each curve beginning where the one before ends; a dot is one curve of no length.
    """
    line = geometry.without_repeats(line)
    few = geometry.without_repeats(geometry.simplify(line, tolerance))
    if len(few) < 3 or tolerance <= 0:
        return straight(line if tolerance <= 0 else few)
    path = _Path(line, tolerance)
    corners = path.corners()
    closed_smooth = geometry.is_closed(line) and len(corners) < 3 and path.bend(0) < CORNER_DEG
    curves: list[Floats] = []
    for first, last in pairwise(corners):
        curves += path.follow(first, last, closed_smooth)
        if len(curves) + 1 >= len(few):
            return straight(few)
    return np.array(curves)


def straight(line: Floats) -> Floats:
    """A polyline as curves."""
    return straight_between(line[:-1], line[1:]) if len(line) > 1 else straight_between(line, line)


def straight_between(a: Floats, b: Floats) -> Floats:
    """Lines from points to points, (m, 2) each, as curves."""
    return np.stack([a, a + (b - a) / 3, a + (b - a) * 2 / 3, b], axis=1)


def are_straight(curves: Floats) -> NDArray[np.bool_]:
    """Which of the curves are straight lines as ``straight`` makes them: (m,)."""
    off = np.abs(curves - straight_between(curves[:, 0], curves[:, 3])).max(axis=(1, 2))
    flat: NDArray[np.bool_] = off <= 1e-9 * (1 + np.abs(curves).max())
    return flat


def at(curves: Floats, t: Floats) -> Floats:
    """Points of curves (m, 4, 2) or of one (4, 2) at parameters (k,): (m, k, 2) or (k, 2)."""
    s = 1 - t
    weights = np.stack([s * s * s, 3 * s * s * t, 3 * s * t * t, t * t * t], axis=-1)
    points: Floats = weights @ curves
    return points


def flatten(curves: Floats, chord_error: float) -> Floats:
    """Points along curves, dense in bends and sparse on straights, so that chords are nowhere farther than asked.

    On an arc of curvature k a chord of length s is k s^2 / 8 away; so points stand at equal steps of the integral of
    sqrt(k). Knots are kept.

    Args:
        curves: (m, 4, 2), each beginning where the one before ends.
        chord_error: in the unit of the curves.

    Returns:
        (n, 2) polyline.
    """
    parts = [curves[0, :1]]
    for curve in curves:
        count = 1
        while True:
            t = _by_bend(curve, count)
            points = at(curve, t)
            middle = at(curve, ((t[:-1, None] * [3, 2, 1] + t[1:, None] * [1, 2, 3]) / 4).ravel())
            ends = np.repeat(points[:-1], 3, axis=0), np.repeat(points[1:], 3, axis=0)
            worst = float(geometry.distance_to_segments(middle, *ends).max())
            if worst <= chord_error or count >= _MOST_POINTS:
                break
            count = max(count + 1, int(count * min(np.sqrt(worst / chord_error), 4) * 0.9))
        parts.append(points[1:])
    return geometry.without_repeats(np.concatenate(parts))


def _by_bend(curve: Floats, count: int) -> Floats:
    """Parameters of ``count`` steps of equal bend."""
    t = np.linspace(0, 1, 4 * _DENSE + 1)
    speed = 3 * _derivative(curve, t)
    turn = np.unwrap(np.arctan2(speed[:, 1], speed[:, 0]))
    length = np.hypot(*np.diff(at(curve, t), axis=0).T)
    step = np.sqrt(np.abs(np.diff(turn)) * length) + 1e-3 * length + 1e-12
    along = np.concatenate([[0.0], np.cumsum(step)])
    return np.interp(np.linspace(0, along[-1], count + 1), along, t)


def _derivative(curve: Floats, t: Floats) -> Floats:
    """A third of the derivative by the parameter."""
    s, leg = 1 - t, np.diff(curve, axis=0)
    slope: Floats = np.stack([s * s, 2 * s * t, t * t], axis=-1) @ leg
    return slope


class _Path:
    """A line with points so dense that what is near them is near the line."""

    def __init__(self, line: Floats, tolerance: float) -> None:
        self.tolerance = tolerance
        self.closed = geometry.is_closed(line)
        gaps = np.hypot(*np.diff(line, axis=0).T)
        step = max(tolerance, float(gaps.sum()) / _MOST_POINTS)
        counts = np.maximum(np.ceil(gaps / step).astype(np.int64), 1)
        self.vertex: NDArray[np.int64] = np.concatenate([[0], np.cumsum(counts)])
        places = np.arange(self.vertex[-1] + 1)
        self.points = np.stack([np.interp(places, self.vertex, line[:, k]) for k in (0, 1)], axis=1)
        self.along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(self.points, axis=0).T))])

    def corners(self) -> list[int]:
        """Where the line begins, bends sharply (the sharpest place of each bend), and ends."""
        bends = np.array([self.bend(int(k)) for k in self.vertex[1:-1]])
        found = [0]
        for place in np.argsort(-bends, kind="stable"):
            k = int(self.vertex[place + 1])
            if bends[place] < CORNER_DEG:
                break
            if min(abs(self.along[k] - self.along[other]) for other in found) > self.tolerance * _REACH / 2:
                found.append(k)
        return [*sorted(found), len(self.points) - 1]

    def bend(self, k: int) -> float:
        """By how many degrees the line turns at a point."""
        one, other = self._away(k, -1), self._away(k, 1)
        return float(np.degrees(np.arccos(np.clip(-one @ other, -1, 1))))

    def tangent(self, k: int) -> Floats:
        """Direction of the line at a point, looking both ways."""
        return _unit(self._away(k, 1) - self._away(k, -1))

    def _away(self, k: int, sign: int) -> Floats:
        """Direction from a point to where the line is a reach farther on."""
        total = self.along[-1]
        place = self.along[k] + sign * self.tolerance * _REACH
        place = place % total if self.closed else min(max(place, 0.0), total)
        there = np.array([np.interp(place, self.along, self.points[:, axis]) for axis in (0, 1)])
        return _unit(there - self.points[k])

    def follow(self, first: int, last: int, smooth_ends: bool) -> list[Floats]:
        """Curves from one corner to the next."""
        curves: list[Floats] = []
        k, tangent = first, self.tangent(first) if smooth_ends else None
        while k < last:
            k, curve, tangent = self._longest(k, last, tangent, smooth_ends)
            curves.append(curve)
        return self._even(first, last, len(curves), smooth_ends) or curves

    def _even(self, first: int, last: int, count: int, smooth_ends: bool) -> list[Floats]:
        """As many curves of equal length, so that the last is no crumb; none if they do not follow the line."""
        places = np.linspace(self.along[first], self.along[last], count + 1)
        knots = np.searchsorted(self.along, places).clip(first, last).tolist()
        knots[-1] = last
        curves: list[Floats] = []
        for i, j in pairwise(knots):
            start = self.tangent(i) if i > first or smooth_ends else None
            end = self.tangent(j) if j < last or smooth_ends else None
            curve = self._curve(i, j, start, end) if j > i else None
            if curve is None:
                return []
            curves.append(curve)
        return curves

    def _longest(self, k: int, last: int, tangent: Floats | None, smooth_end: bool) -> tuple[int, Floats, Floats]:
        """The longest stretch from k that one curve follows: its end, the curve, the tangent there."""
        good, bad = k + 1, last + 1
        best = straight(self.points[k : k + 2])[0]
        reach = min(last, k + 16)
        while good < bad - 1:
            curve = self._curve(k, reach, tangent, self.tangent(reach) if reach < last or smooth_end else None)
            if curve is None:
                bad = reach
            else:
                good, best = reach, curve
            reach = min(last, k + 2 * (reach - k)) if bad > last else (good + bad) // 2
            if good == last:
                break
        return good, best, self.tangent(good)

    def _curve(self, i: int, j: int, start: Floats | None, end: Floats | None) -> Floats | None:
        """One curve along the points i..j within the tolerance both ways; None if it was not found."""
        all_points = self.points[i : j + 1]
        some = np.unique(np.linspace(0, j - i, min(j - i + 1, _SAMPLES)).astype(np.int64))
        points = all_points[some]
        t = (self.along[i + some] - self.along[i]) / (self.along[j] - self.along[i])
        most = self.tolerance * _MARGIN
        for _ in range(_ROUNDS):
            curve = _least_squares(points, t, start, end)
            off = at(curve, t) - points
            worst = np.hypot(*off.T).max()
            if worst > 30 * self.tolerance:
                return None
            if worst <= most and self._near(curve, all_points):
                return curve
            slope = 3 * _derivative(curve, t)
            t = np.clip(t - (off * slope).sum(axis=1) / np.maximum((slope * slope).sum(axis=1), 1e-12), 0, 1)
            t[0], t[-1] = 0.0, 1.0
            if (np.diff(t) < 0).any():
                return None
        return None

    def _near(self, curve: Floats, points: Floats) -> bool:
        """Whether curve and points are within the tolerance of each other, both ways."""
        dense = at(curve, np.linspace(0, 1, min(max(2 * _SAMPLES, 2 * len(points)), _MOST_POINTS)))
        most = self.tolerance * (1 + _MARGIN) / 2
        return _farthest(points, dense) <= most and _farthest(dense, points) <= most


def _farthest(points: Floats, line: Floats) -> float:
    """The largest distance of the points to a polyline."""
    worst = 0.0
    for part in np.array_split(points, len(points) * len(line) // _AT_ONCE + 1):
        distance = geometry.distance_to_segments(part[:, None], line[:-1], line[1:])
        worst = max(worst, float(distance.min(axis=1).max()))
    return worst


def _unit(vector: Floats) -> Floats:
    unit: Floats = vector / max(float(np.hypot(*vector)), 1e-12)
    return unit


def _least_squares(points: Floats, t: Floats, start: Floats | None, end: Floats | None) -> Floats:
    """The cubic from the first point to the last that is nearest to the others at their parameters.

    Where a tangent is given the control point lies on it, else anywhere.
    """
    s = 1 - t
    first, last = points[0], points[-1]
    inner = np.stack([3 * s * s * t, 3 * s * t * t])
    fixed = np.outer(s**3 + inner[0], first) + np.outer(t**3 + inner[1], last)
    columns = []
    for weight, tangent, sign in ((inner[0], start, 1.0), (inner[1], end, -1.0)):
        ways = np.eye(2) if tangent is None else sign * tangent[None]
        columns += [np.outer(weight, way).ravel() for way in ways]
    system = np.stack(columns, axis=1)
    normal = system.T @ system + 1e-9 * np.eye(len(columns))
    found = np.linalg.solve(normal, system.T @ (points - fixed).ravel())
    least = 1e-3 * np.hypot(*(last - first))
    split = 2 if start is None else 1
    one = found[:2] if start is None else max(found[0], least) * start
    other = found[split:] if end is None else -max(found[split], least) * end
    return np.stack([first, first + one, last + other, last])
