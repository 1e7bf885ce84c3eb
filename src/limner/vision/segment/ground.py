"""A photo and its face go in; where the ground runs on smoothly from the upper corners, in light or shadow, comes out.

A shadow on a wall is darker than the wall, but begins gently, has no texture and keeps the wall's colour; hair, cloth
and skin begin at an edge or differ in colour.
"""

from __future__ import annotations

import cv2
import numpy as np

from limner.types import Face
from limner.vision.head import face_frame, head_ellipse
from limner.vision.raster import Image, Mask, blurred, pieces
from limner.vision.segment.texture import Levels

HIGH, CLEAR = 1.0, 1.6
"""The ground is seen at the picture's border so far above the eyes [outer-eye distances] and so far out of the head."""

SMOOTH = (1, 2, 3)
"""It runs on over pixels of no more than these levels of texture; the fewer, the surer."""

HUE_BINS, HUE_STEP = 64, 1 / 28
"""Cells of each opponent colour, and the width of one: opponent colours over lightness."""

SEEN = 0.02
"""A colour belongs to the ground if it is so frequent at the seeds, the most frequent being 1."""

MARGIN = 16.0
"""Lightness counts from here below black: so do shading and CIE's lightness agree."""


def smooth_ground(lab: Image, face: Face, texture: Levels) -> Image:
    """How surely (H, W) the ground is reached, from 0 to 1.

    Where light falls off, L + 16, a and b of CIELAB shrink alike: their ratios tell a shadow from another thing.

    Args:
        lab: CIELAB (H, W, 3) of the small copy.
        face: frontal, in it.
        texture: levels (H, W) at its pixels.
    """
    seeds = _seeds(face, texture.shape)
    alike = _alike(lab, seeds, face)
    reached = np.zeros(texture.shape, np.float32)
    for level in SMOOTH:
        passable = ((texture <= level) & alike).astype(np.uint8)
        wide = np.asarray(cv2.morphologyEx(passable, cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))) > 0
        _, labels = pieces(wide)
        reached += np.isin(labels, np.unique(labels[seeds & wide])).astype(np.float32)
    return reached / np.float32(len(SMOOTH))


def _seeds(face: Face, shape: tuple[int, ...]) -> Mask:
    """The picture's border (H, W) beside and above the head."""
    place = face_frame(face).from_photo(np.moveaxis(np.indices(shape)[::-1], 0, -1).astype(np.float64))
    border = np.zeros(shape, bool)
    border[:2], border[:, :2], border[:, -2:] = True, True, True
    seeds: Mask = border & (place[..., 1] < -HIGH) & (head_ellipse(face).level(place) > CLEAR)
    return seeds


def _alike(lab: Image, seeds: Mask, face: Face) -> Mask:
    """Pixels (H, W) that have the colour of a seed on the same side of the face, in whatever light."""
    hue = cv2.blur(lab[..., 1:] / (lab[..., :1] + np.float32(MARGIN)), (3, 3))
    bins = np.clip(hue / HUE_STEP + HUE_BINS / 2, 0, HUE_BINS - 1).astype(np.int64)
    cell = bins[..., 0] * HUE_BINS + bins[..., 1]
    alike = np.zeros_like(seeds)
    left = np.arange(seeds.shape[1]) < face_frame(face).origin_px[0]
    for side in (left, ~left):
        count = np.bincount(cell[seeds & side], minlength=HUE_BINS**2).reshape(HUE_BINS, HUE_BINS)
        spread = blurred(count.astype(np.float32), 1.0).ravel()
        alike |= side & (spread[cell] > SEEN * max(float(spread.max()), 1e-6))
    return alike
