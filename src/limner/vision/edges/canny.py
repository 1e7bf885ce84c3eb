"""A photo and a face go in; the edges that Canny's detector finds come out (thesis 3.1.2, 3.5)."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from limner.settings import SettingsGroup, setting
from limner.types import EdgeMap, Face, Photo
from limner.vision.edges.ridges import below_pi
from limner.vision.head import face_outline
from limner.vision.raster import Image, Mask, blurred, filled, filtered


@dataclass(frozen=True)
class CannySettings(SettingsGroup):
    """Edges by Canny 1986 (doi:10.1109/TPAMI.1986.4767851); pixels are those of the working scale."""

    blur_px: float = setting(1.4, "blur before the edges are looked for, standard deviation", unit="px", low=0, high=20)
    quantile: float = setting(
        0.7, "share of the pixels that are no edge: where the automatic high threshold lies", low=0, high=0.999
    )
    raise_high: float = setting(
        2.5, "the automatic high threshold is raised by this factor (thesis 3.5)", low=0, high=100
    )
    low_of_high: float = setting(0.6, "low threshold as a share of the high one (thesis 3.5)", low=0, high=1)
    high: float | None = setting(
        None, "high threshold by hand, of the change from black to white over a pixel; or auto", low=0, high=2
    )
    low: float | None = setting(None, "low threshold by hand; or auto: from the high one", low=0, high=2)


def canny_edges(photo: Photo, face: Face, settings: CannySettings) -> EdgeMap:
    """Edges between light and dark, one pixel wide.

    The automatic high threshold is MATLAB's: the gradient's magnitude that 70 % of the pixels stay under. On
    portraits that is far too low, so the thesis takes 2.5 times as much, and 60 % of that for the low one. The pixels
    counted are those of the face: whether the wall behind is plain or full of things must not change how it is drawn.

    Args:
        photo: at the working scale.
        face: in that photo.
        settings: blur and thresholds.

    Returns:
        The edges; ``strength`` is 1 from twice the high threshold on.
    """
    dx, dy = _slopes(photo, settings)
    magnitude = np.hypot(dx, dy)
    low, high = _thresholds_on(magnitude, face, settings)
    strength = np.clip(magnitude / max(2 * high, 1e-9), 0, 1).astype(np.float64)
    tangent = below_pi(np.mod(np.arctan2(dy, dx) + np.pi / 2, np.pi)).astype(np.float64)
    return EdgeMap(_thin_edges(dx, dy, low, high), strength, tangent)


def thresholds_of(photo: Photo, face: Face, settings: CannySettings) -> tuple[float, float]:
    """Low and high threshold that a photo gets."""
    return _thresholds_on(np.hypot(*_slopes(photo, settings)), face, settings)


def _thresholds_on(magnitude: Image, face: Face, settings: CannySettings) -> tuple[float, float]:
    skin = filled(face_outline(face), magnitude.shape)
    return thresholds(magnitude[skin] if skin.any() else magnitude, settings)


def thresholds(magnitude: Image, settings: CannySettings) -> tuple[float, float]:
    """Low and high threshold for gradients of this magnitude."""
    high = settings.high
    if high is None:
        high = settings.raise_high * float(np.quantile(magnitude, settings.quantile))
    low = settings.low if settings.low is not None else settings.low_of_high * high
    return min(low, high), high


def _slopes(photo: Photo, settings: CannySettings) -> tuple[Image, Image]:
    """Change (H, W) of the brightness over a pixel to the right and downward."""
    grey = np.asarray(cv2.cvtColor(photo.rgb, cv2.COLOR_RGB2GRAY), np.float32) / np.float32(255)
    if settings.blur_px:
        grey = blurred(grey, settings.blur_px)
    x = np.array([[-1, 0, 1], [-2, 0, 2], [-1, 0, 1]], np.float32) / np.float32(8)
    return filtered(grey, x), filtered(grey, np.ascontiguousarray(x.T))


def _thin_edges(dx: Image, dy: Image, low: float, high: float) -> Mask:
    """Where the gradient is largest along itself and, by hysteresis, above the thresholds."""
    fine = 2.0**14  # OpenCV takes slopes as 16-bit integers; a slope is at most 1/2
    x, y = (np.rint(slope * np.float32(fine)).astype(np.int16) for slope in (dx, dy))
    return np.asarray(cv2.Canny(x, y, low * fine, high * fine, L2gradient=True)) > 0
