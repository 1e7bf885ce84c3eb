"""A simplified picture of a person goes in; which of a few inks draws each place, and how densely, comes out."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from limner.types import Floats
from limner.vision.figure import Figure
from limner.vision.palette import inks, nearest
from limner.vision.raster import Image, blurred, filled

BLACK = np.array([[0.0, 0.0, 0.0]])
DARKEST, LIGHTEST = 22.0, 62.0
"""Lightness of the coloured inks."""

LEAST_INK = 0.2
"""Paper does for what would have less ink."""


@dataclass(frozen=True, eq=False)
class Inked:
    """Which ink draws each place.

    Attributes:
        inks: (k, 3) CIELab, black first.
        label: (H, W) index of the ink.
        dark: (H, W) share of the paper that the ink covers, 0 to 1; 0 off the figure.
    """

    inks: Floats
    label: NDArray[np.int64]
    dark: Image


def inked(smooth_lab: Image, figure: Figure, dark: Image, count: int) -> Inked:
    """Choose the inks of a picture, and which draws where.

    Args:
        smooth_lab: (H, W, 3) CIELab with flat areas.
        figure: what is drawn.
        dark: (H, W) how dark each place is, on the person's own scale.
        count: of inks, black included.
    """
    lab = smooth_lab.reshape(-1, 3).astype(np.float64)
    drawn = lab[(figure.figure & (dark > LEAST_INK)).ravel()]
    colours = np.concatenate([BLACK, inks(drawn, count - 1, DARKEST, LIGHTEST)]) if count > 1 else BLACK
    # Hue decides, and lightness only a little: how dark it is the spacing says.
    weight = np.array([0.45, 1, 1])
    label = nearest(lab * weight, np.concatenate([BLACK, colours[1:] / [1, 1.35, 1.35]]) * weight)
    label = label.reshape(dark.shape)
    # Cloth has its colour also in the light; skin and hair are paper there.
    chroma = np.hypot(smooth_lab[..., 1], smooth_lab[..., 2]) / 60
    flat = np.where(figure.body, np.minimum((1 - smooth_lab[..., 0] / 100), chroma), 0)
    tone = np.where(figure.figure, np.clip(np.maximum(dark, flat), 0, 1), 0)
    return Inked(colours, label, tone.astype(np.float32))


def features(points_px: Floats, parts: list[list[int]], shape: tuple[int, ...], reach: float) -> Image:
    """From 0 to 1 (H, W) where the features within some landmarks are, fading out."""
    mask = np.zeros(shape, np.float32)
    for part in parts:
        hull = np.asarray(cv2.convexHull(points_px[part].astype(np.float32)), np.float64).reshape(-1, 2)
        mask = np.maximum(mask, filled(hull, shape).astype(np.float32))
    wide = cv2.dilate(mask, np.ones((3, 3), np.uint8), iterations=max(1, round(reach)))
    return blurred(np.asarray(wide, np.float32), max(reach, 0.5))
