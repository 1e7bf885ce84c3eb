"""A simplified picture of a person goes in; the borders of its tones and hatching in a few inks come out."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from limner import geometry
from limner.types import Floats
from limner.vision.cartoon.settings import CartoonSettings
from limner.vision.hatching.streamlines import Ground, streamlines
from limner.vision.inked import LEAST_INK, Inked
from limner.vision.raster import Mask, blurred, distance_to_lines, pieces
from limner.vision.trace import smooth

SMALLEST = 0.006
"""Tones on less than this are left out [square of the outer-eye distance]."""

SMOOTH = 0.03
"""Bays and bumps of borders smaller than this go [outer-eye distances]."""

SHORTEST = 0.12
"""Shorter hatching is left out [outer-eye distances]."""

LINE = 0.018
"""Width of a pen's line [outer-eye distances] by which the spacing makes the tone."""

SPOT = 0.82
"""What is darker than this is hatched in black whatever its ink, as comics have it."""

NEAR = 0.05
"""A border nearer to an edge than this is drawn by the edge [outer-eye distances]."""

ANGLES_DEG = (50.0, 35.0, 65.0, 20.0, 80.0, 5.0)
"""Direction of each ink's hatching, from level, counterclockwise."""


def hatching(ground: Inked, unit: float, settings: CartoonSettings) -> list[tuple[Floats, int]]:
    """Straight strokes, each with its ink: the closer the darker."""
    found: list[tuple[Floats, int]] = []
    fade = np.ones_like(ground.dark)
    for ink in range(len(ground.inks)):
        where = (ground.label == ink) & (ground.dark > LEAST_INK)
        where = where | (ground.dark > SPOT) if ink == 0 else where & (ground.dark <= SPOT)
        where = blurred(where.astype(np.float32), SMOOTH * unit) > 0.5
        # Spacing in steps: a tone is an area of one spacing, as the picture's levels are.
        steps = np.ceil(blurred(ground.dark, SMOOTH * unit) * 4) / 4
        spacing = unit * np.clip(LINE / np.maximum(steps, np.float32(1e-3)), settings.closest, settings.widest)
        turn = np.deg2rad(ANGLES_DEG[ink % len(ANGLES_DEG)])
        cos, sin = (np.full_like(fade, value) for value in (np.cos(turn), -np.sin(turn)))
        layer = Ground(cos, sin, np.where(where, spacing, 0).astype(np.float32), fade, where.astype(np.uint8))
        found += [(line[[0, -1]], ink) for line in streamlines(layer, [], SHORTEST * unit)]
    return found


def borders(ground: Inked, figure: Mask, edges: Sequence[Floats], unit: float, count: int) -> list[tuple[Floats, int]]:
    """The borders of some levels of darkness within the figure and off its edges, each with its dark side's ink."""
    calm = blurred(ground.dark, SMOOTH * unit)
    inner = cv2.erode(figure.astype(np.uint8), np.ones((3, 3), np.uint8), iterations=max(1, round(0.03 * unit))) > 0
    free = inner & (distance_to_lines(edges, figure.shape) > NEAR * unit)
    found: list[tuple[Floats, int]] = []
    for level in np.linspace(0.3, 0.75, count).tolist():
        mask = _without_specks(inner & (calm > level), SMALLEST * unit**2)
        outlines, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE)
        for outline in outlines:
            ring = np.asarray(outline, np.float64).reshape(-1, 2)
            if len(ring) < 0.3 * unit:
                continue
            ink = int(np.bincount(ground.label[ring[:, 1].astype(int), ring[:, 0].astype(int)]).argmax())
            closed = smooth(np.concatenate([ring, ring[:1]]), SMOOTH * unit)
            found += [(part, ink) for part in _inside(closed, free) if geometry.length(part) > 0.2 * unit]
    return found


def _without_specks(mask: Mask, least_px: float) -> Mask:
    """Without small pieces and small holes."""
    for _ in range(2):
        _, labels = pieces(mask)
        mask = ~((np.bincount(labels.ravel()) >= least_px)[labels] & mask)
    return mask


def _inside(ring: Floats, inner: Mask) -> list[Floats]:
    """The parts of a ring that are in a mask, and do not run along its border."""
    away = cv2.erode(inner.astype(np.uint8), np.ones((5, 5), np.uint8), borderType=cv2.BORDER_CONSTANT, borderValue=0)
    at = np.clip(np.rint(ring).astype(int), 0, np.array(inner.shape[::-1]) - 1)
    free = away[at[:, 1], at[:, 0]] > 0
    cuts = np.flatnonzero(np.diff(free.astype(int))) + 1
    parts = np.split(ring, cuts)
    kept = [part for part, is_free in zip(parts, np.split(free, cuts), strict=True) if is_free[0] and len(part) > 2]
    if len(kept) > 1 and free[0] and free[-1]:
        kept = [np.concatenate([kept[-1], kept[0][1:]]), *kept[1:-1]]
    return kept
