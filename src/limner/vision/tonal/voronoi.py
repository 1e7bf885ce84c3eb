"""A density goes in; dots that are as dense, each in the middle of its Voronoi cell, come out."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from limner.types import Floats
from limner.vision.raster import Image, resized

CELL_PX = 60.0
"""Where dots are densest a cell has about so many pixels: the density is enlarged for it."""

MOST_PIXELS = 2_000_000
"""A density is not enlarged beyond this."""


def stipple_dots(density: Image, count: int, rounds: int, seed: int) -> Floats:
    """Dots of a density: weighted centroidal Voronoi stippling (Secord 2002, doi:10.1145/508530.508537).

    Each dot moves to the centre of mass of the places nearest to it, again and again (Lloyd's method). The dots
    begin spread evenly along a Hilbert curve in proportion to the density, so that none has far to go.

    Args:
        density: (H, W) >= 0.
        count: how many dots.
        rounds: how often they move.
        seed: of where in its stretch of the curve each begins.

    Returns:
        (n, 2) places [px]; ``count`` of them, or as many as there are pixels of any density where those are fewer.
    """
    scale = _enlargement(density, count)
    height, width = density.shape
    fine = resized(density, (round(width * scale), round(height * scale))) if scale > 1 else density
    fine = np.where(fine > 1e-4 * max(float(fine.max()), 1e-12), fine, 0).astype(np.float32)
    rows, columns = np.nonzero(fine)
    if not len(rows):
        return np.empty((0, 2))
    weights = fine[rows, columns].astype(np.float64)
    places = np.stack([columns, rows], axis=1)
    dots = _along_curve(places, weights, min(count, len(rows)), seed)
    for _ in range(rounds):
        dots = _centred(dots, places, weights, fine.shape)
    unscaled: Floats = (dots + 0.5) / [fine.shape[1] / width, fine.shape[0] / height] - 0.5
    return unscaled


def _enlargement(density: Image, count: int) -> float:
    """How much finer the density is looked at."""
    densest = float(density.max()) / max(float(density.sum()), 1e-12) * count
    most = np.sqrt(MOST_PIXELS / density.size)
    return float(np.clip(np.sqrt(CELL_PX * densest), 1, max(most, 1)))


def _along_curve(places: NDArray[np.intp], weights: Floats, count: int, seed: int) -> Floats:
    """Dots (count, 2) on places (n, 2), one in each equal share of the weight along a Hilbert curve."""
    order = np.argsort(_hilbert(places), kind="stable")
    weight = np.cumsum(weights[order])
    shares = (np.arange(count) + np.random.default_rng(seed).random(count)) / count
    at = np.searchsorted(weight, shares * weight[-1])
    dots: Floats = places[order[np.minimum(at, len(order) - 1)]].astype(np.float64)
    return dots


def _hilbert(places: NDArray[np.intp]) -> NDArray[np.int64]:
    """How far along a Hilbert curve (Hilbert 1891) each place (n, 2) of whole numbers >= 0 lies."""
    x, y = places.T.astype(np.int64)
    along = np.zeros(len(x), np.int64)
    side = 1 << max(int(places.max(initial=1)).bit_length() - 1, 0)
    while side:
        right, below = (x & side) > 0, (y & side) > 0
        along += side * side * ((3 * right) ^ below)
        x, y = x & (side - 1), y & (side - 1)
        flip = right & ~below
        x, y = np.where(flip, side - 1 - x, x), np.where(flip, side - 1 - y, y)
        x, y = np.where(below, x, y), np.where(below, y, x)
        side >>= 1
    return along


def _centred(dots: Floats, places: NDArray[np.intp], weights: Floats, shape: tuple[int, ...]) -> Floats:
    """Each dot in the centre of mass of the places nearest to it; where dots share a pixel, one of them stays."""
    at = np.rint(dots).astype(np.intp)
    free = np.ones(shape, np.uint8)
    free[at[:, 1], at[:, 0]] = 0
    _, cells = cv2.distanceTransformWithLabels(free, cv2.DIST_L2, cv2.DIST_MASK_5, labelType=cv2.DIST_LABEL_PIXEL)
    cell = np.asarray(cells)[places[:, 1], places[:, 0]]
    mass, x, y = (np.bincount(cell, weights * part) for part in (1.0, places[:, 0], places[:, 1]))
    mine = np.asarray(cells)[at[:, 1], at[:, 0]]
    _, first = np.unique(mine, return_index=True)
    moves = np.zeros(len(dots), bool)
    moves[first] = True
    moves[moves] = mass[mine[moves]] > 0
    centred = dots.copy()
    centre = np.stack([x, y], axis=1)[mine[moves]] / mass[mine[moves], None]
    centred[moves] = centre
    return centred
