"""A drawing of dots goes in; one line through all of them, which never crosses itself, comes out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from limner import geometry
from limner.drawing.measure import HOME_MM
from limner.drawing.order import OrderSettings, Row
from limner.drawing.uncross import uncrossed
from limner.settings import SettingsGroup, setting
from limner.types import Drawing, Floats

CURVE_POINTS = 4
"""Points of the curve that takes the place of a corner, its ends included."""


@dataclass(frozen=True)
class ThreadSettings(SettingsGroup):
    """How the dots of the style one-line are joined to a line."""

    kicks: int = setting(
        5, "how often the tour through the dots is shaken to find a shorter one", unit="per dot", low=0, high=100_000
    )
    seed: int = setting(0, "of the chance by which it is shaken", low=0, high=1_000_000)
    smooth: bool = setting(False, "Curves instead of corners; then a budget of points gives a quarter of the dots")

    @property
    def points_per_dot(self) -> int:
        """Points of the line for each dot."""
        return CURVE_POINTS if self.smooth else 1


def thread(drawing: Drawing, settings: ThreadSettings) -> Drawing:
    """One stroke through all dots: the shortest tour that is found, opened where it would go farthest over the paper.

    The tour is that of ``order``: shortest hops, then a local search (Lin & Kernighan 1973), which is shaken. A tour
    that crosses itself is not the shortest: what crossings are left are undone (``uncross``).

    Args:
        drawing: strokes of one point each.
        settings: how hard to look, and whether corners are rounded.

    Returns:
        A drawing of one stroke, each dot one of its points, or, rounded, the nearer to its curve the sharper.
    """
    home = np.array(HOME_MM)
    search = OrderSettings(kicks=settings.kicks, seed=settings.seed)
    row = Row.of(drawing).shortened(home, home, search)
    line = uncrossed(opened(geometry.without_repeats(np.concatenate(row.lines))))
    if settings.smooth:
        line = rounded(line)
    region = max(sorted(set(drawing.region)), key=drawing.region.count)
    return Drawing((line,), (region,), np.array([drawing.weight.sum()]), drawing.page, (drawing.pen,))


def opened(ring: Floats) -> Floats:
    """A ring of points (n, 2), not closed, begun behind its longest segment, which so is not drawn."""
    ahead = np.hypot(*(np.roll(ring, -1, axis=0) - ring).T)
    return np.roll(ring, -1 - int(ahead.argmax()), axis=0)


def rounded(line: Floats) -> Floats:
    """A line with a curve in place of each corner; one that does not cross itself does not do so afterwards.

    The curve lies in a triangle at the corner into which no other point of the line reaches. As nothing crosses the
    triangle's sides along the line either, nothing enters it.

    Args:
        line: (n, 2).

    Returns:
        (``CURVE_POINTS`` (n - 2) + 2, 2).
    """
    if len(line) < 3:
        return line
    before, corner, after = line[:-2], line[1:-1], line[2:]
    reach = _reach(line)[:, None]
    start, end = corner + reach * (before - corner), corner + reach * (after - corner)
    t = np.linspace(0, 1, CURVE_POINTS)[:, None, None]
    # Quadratic Bezier curves.
    curves = (1 - t) ** 2 * start + 2 * t * (1 - t) * corner + t**2 * end
    return np.concatenate([line[:1], curves.transpose(1, 0, 2).reshape(-1, 2), line[-1:]])


def _reach(line: Floats) -> Floats:
    """How far (n - 2,) along its two segments each corner can be cut, of their lengths: less than half."""
    before, corner, after = line[:-2], line[1:-1], line[2:]
    reach = np.full(len(corner), 0.45)
    for k, (a, b, c) in enumerate(zip(before, corner, after, strict=True)):
        low, high = np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)
        near: NDArray[np.bool_] = ((line >= low) & (line <= high)).all(axis=1)
        near[k : k + 3] = False
        others = line[near] - b
        sides = np.stack([a - b, c - b])
        if not len(others) or abs(np.linalg.det(sides)) < 1e-12:
            continue
        # A point is in the triangle cut off at r where both its coordinates along the sides are >= 0 and sum to <= r.
        along = others @ np.linalg.inv(sides)
        inside = along.sum(axis=1)[(along >= -1e-9).all(axis=1)]
        reach[k] = min(reach[k], 0.9 * inside.min(initial=1.0))
    return reach
