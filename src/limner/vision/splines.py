"""Points along a feature go in; the natural cubic spline through them, or a smoother one near them, comes out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from limner import geometry
from limner.errors import BadInput
from limner.types import Floats

_SAMPLES = 24
"""Places tried on each piece before the nearest of them is made exact."""


@dataclass(frozen=True, eq=False)
class Spline:
    """A piecewise cubic curve with continuous curvature, straight beyond its ends.

    Attributes:
        places: (n,) parameter of the knots, increasing.
        knots: (n, 2) the curve there.
        bends: (n, 2) its second derivative there, 0 at both ends.
    """

    places: Floats
    knots: Floats
    bends: Floats

    def at(self, t: Floats) -> Floats:
        """The curve (m, 2) at parameters (m,) between the first and the last knot."""
        k = np.clip(np.searchsorted(self.places, t, side="right") - 1, 0, len(self.places) - 2)
        h = (self.places[k + 1] - self.places[k])[:, None]
        b = (t[:, None] - self.places[k, None]) / h
        a = 1 - b
        bend = (a**3 - a) * self.bends[k] + (b**3 - b) * self.bends[k + 1]
        curve: Floats = a * self.knots[k] + b * self.knots[k + 1] + bend * h**2 / 6
        return curve

    def line(self, step: float) -> Floats:
        """The curve as a polyline (m, 2) with vertices no farther apart than about ``step``."""
        chord = max(geometry.length(self.knots), step)
        return geometry.resample(self.at(self._grid(max(2, int(np.ceil(2 * chord / step))))), step)

    def nearest(self, points: Floats) -> Floats:
        """The point (m, 2) of the curve that is nearest to each of ``points`` (m, 2)."""
        t = self._grid(_SAMPLES * (len(self.places) - 1) + 1)
        line = self.at(t)
        k = ((points[:, None] - line) ** 2).sum(axis=-1).argmin(axis=1)
        # Between its samples the curve is all but straight, so the nearest point of the two sides next to k is on it.
        sides = [_foot(points, line, t, np.clip(k + shift, 0, len(t) - 2)) for shift in (-1, 0)]
        feet = self.at(np.concatenate(sides)).reshape(2, -1, 2)
        far = ((feet - points) ** 2).sum(axis=-1)
        best: Floats = feet[far.argmin(axis=0), np.arange(len(points))]
        return best

    def _grid(self, count: int) -> Floats:
        return np.linspace(self.places[0], self.places[-1], count)


def _foot(points: Floats, line: Floats, t: Floats, k: np.ndarray[tuple[int], np.dtype[np.intp]]) -> Floats:
    along = line[k + 1] - line[k]
    share = ((points - line[k]) * along).sum(axis=1) / np.maximum((along**2).sum(axis=1), 1e-300)
    foot: Floats = t[k] + np.clip(share, 0, 1) * (t[k + 1] - t[k])
    return foot


def natural_spline(points: Floats, places: Floats | None = None) -> Spline:
    """The natural cubic spline through points (n, 2): of all curves through them the one that bends least.

    Raises:
        BadInput: fewer than two points.
    """
    return smoothing_spline(points, 1.0, places)


def smoothing_spline(points: Floats, p: float, places: Floats | None = None, weights: Floats | None = None) -> Spline:
    """The curve f that minimises p sum w |point - f|^2 + (1 - p) integral |f''|^2 (thesis 3.3.5; Reinsch 1967).

    Args:
        points: (n, 2), in order.
        p: 1 interpolates (the natural cubic spline), 0 gives the straight line nearest to the points.
        places: (n,) increasing parameter of each point; not given: 0, 1, 2, ... as in the thesis.
        weights: (n,) positive; not given: 1.

    Raises:
        BadInput: fewer than two points, or p outside 0 to 1.
    """
    if len(points) < 2 or not 0 <= p <= 1:
        raise BadInput(f"spline: {len(points)} points and p = {p:g}; expected two points or more, and p from 0 to 1")
    t = np.arange(len(points), dtype=np.float64) if places is None else places
    w = np.ones(len(points)) if weights is None else weights
    bends = np.zeros_like(points, dtype=np.float64)
    if len(points) == 2:
        return Spline(t, np.array(points, np.float64), bends)
    differences, energy = _matrices(t)
    loose = (1 - p) * differences.T @ (differences / w[:, None])
    # Solved for bends / p, so that p = 0 needs no case of its own.
    solved = np.linalg.solve(p * energy + loose, differences.T @ points)
    bends[1:-1] = p * solved
    return Spline(t, points - (1 - p) * (differences @ solved) / w[:, None], bends)


def _matrices(t: Floats) -> tuple[Floats, Floats]:
    """Second differences (n, n - 2), and the matrix (n - 2, n - 2) that turns bends into their integrated square."""
    h, n = np.diff(t), len(t)
    differences, inner = np.zeros((n, n - 2)), np.arange(n - 2)
    differences[inner, inner] = 1 / h[:-1]
    differences[inner + 1, inner] = -1 / h[:-1] - 1 / h[1:]
    differences[inner + 2, inner] = 1 / h[1:]
    energy = np.diag((h[:-1] + h[1:]) / 3) + np.diag(h[1:-1] / 6, 1) + np.diag(h[1:-1] / 6, -1)
    return differences, energy
