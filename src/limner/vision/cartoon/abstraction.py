"""A picture goes in; the same with flat tones, few lightnesses and dark edges comes out (thesis 2.3.2).

Winnemöller, Olsen & Gooch 2006 (doi:10.1145/1141911.1142018), in CIELab; quick enough for video, and steady in it.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from limner.settings import SettingsGroup, setting
from limner.vision.palette import to_rgb
from limner.vision.raster import Image, blurred

UNIT_PX = 128.0
"""Size of a face [px between the outer eye corners] at which lengths and passes are as the settings say."""

SURROUND = 1.6
"""Width of the surroundings over that of an edge: a difference of Gaussians is then nearest to the Laplacian."""

_WINDOW = 5
_CONTRAST = 15.0  # of the 8-bit CIELab, over which the bilateral filter does not mix
_SOFTEST, _SHARPEST = 0.35, 1.6
_STEEPEST = 2.0  # lightness per pixel
_MOST_PASSES = 24


@dataclass(frozen=True)
class AbstractionSettings(SettingsGroup):
    """How a picture is simplified."""

    passes: int = setting(5, "Passes of the bilateral filter before tones are made", low=1, high=_MOST_PASSES)
    passes_edges: int = setting(
        2, "Passes before edges are looked for, and where the face has its features", low=0, high=_MOST_PASSES
    )
    tones: int = setting(9, "Levels of lightness from black to white", low=2, high=64)
    vivid: float = setting(1.15, "Colours are so much stronger", low=0, high=3)
    edge_px: float = setting(
        1.2, "half the width of an edge on a face of the working scale, standard deviation", unit="px", low=0.3, high=10
    )
    edge_share: float = setting(0.985, "of the surroundings: the nearer to 1, the more edges", low=0.5, high=1)
    edge_sharp: float = setting(1.1, "how soon an edge is black, for each unit of lightness", low=0.01, high=100)


@dataclass(frozen=True, eq=False)
class Abstraction:
    """A picture made simple.

    Attributes:
        smooth: (H, W, 3) CIELab with flat areas, before its lightness is put on levels.
        light: (H, W) lightness on soft levels, 0 to 100.
        ink: (H, W) from 0, paper, to 1, an edge.
        vivid: how much stronger its colours are shown.
    """

    smooth: Image
    light: Image
    ink: Image
    vivid: float

    def rgb(self) -> NDArray[np.uint8]:
        """(H, W, 3) sRGB: the flat colours under the edges."""
        colours = self.smooth[..., 1:] * np.float32(self.vivid)
        lab = np.concatenate([self.light[..., None], colours], axis=-1)
        return to_rgb(lab * (1 - self.ink)[..., None])


def abstract(
    rgb: NDArray[np.uint8], settings: AbstractionSettings, unit_px: float = UNIT_PX, detail: Image | None = None
) -> Abstraction:
    """Make a picture simple.

    An iterated bilateral filter flattens what has little contrast; lightness is put on levels by a soft step, whose
    steepness follows the slope of the picture, so that noise does not make a level jump; edges are where a narrow
    Gaussian is darker than a wide one, softly.

    Args:
        rgb: (H, W, 3).
        settings: how simple.
        unit_px: the size of the face in it [px between the outer eye corners].
        detail: (H, W) from 0 to 1, where the features are: less is smoothed there.
    """
    seen = np.asarray(cv2.cvtColor(rgb, cv2.COLOR_RGB2LAB), np.uint8)
    grow = unit_px / UNIT_PX
    less = _flattened(seen, round(settings.passes_edges * min(grow, 1)), grow)
    more = _flattened(less, max(1, round(settings.passes * max(grow, 0.5))), grow)
    fine, smooth = _scaled(less), _scaled(more)
    if detail is not None:
        smooth += detail[..., None] * (fine - smooth)
    light = on_levels(np.ascontiguousarray(smooth[..., 0]), settings.tones)
    ink = edges(np.ascontiguousarray(fine[..., 0]), settings, settings.edge_px * grow)
    return Abstraction(smooth, light, ink, settings.vivid)


def on_levels(light: Image, tones: int) -> Image:
    """Lightness (H, W) near the middle of its level, but where it changes slowly no step is sharp."""
    step = np.float32(100 / tones)
    dx, dy = (np.asarray(cv2.Sobel(light, cv2.CV_32F, *way, scale=1 / 8), np.float32) for way in ((1, 0), (0, 1)))
    slope = np.minimum(np.hypot(dx, dy), np.float32(_STEEPEST)) / np.float32(_STEEPEST)
    sharp = np.float32(_SOFTEST) + slope * np.float32(_SHARPEST - _SOFTEST)
    # The border between two levels is in the middle of the soft step.
    border = np.rint(light / step) * step
    soft = border + step / 2 * np.tanh(sharp * (light - border)) / np.tanh(sharp * step / 2)
    return np.asarray(np.clip(soft, 0, 100), np.float32)


def edges(light: Image, settings: AbstractionSettings, width_px: float) -> Image:
    """Ink (H, W) where a Gaussian mean of the lightness is less than its share of a wider one."""
    inner, outer = blurred(light, width_px), blurred(light, SURROUND * width_px)
    deeper = np.float32(settings.edge_share) * outer - inner
    ink: Image = np.tanh(np.maximum(deeper, np.float32(0)) * np.float32(settings.edge_sharp))
    return ink


def _flattened(lab: NDArray[np.uint8], passes: int, grow: float) -> NDArray[np.uint8]:
    for _ in range(min(passes, _MOST_PASSES)):
        lab = np.asarray(cv2.bilateralFilter(lab, _WINDOW, _CONTRAST, 2.0 * max(grow, 1.0)), np.uint8)
    return lab


def _scaled(lab: NDArray[np.uint8]) -> Image:
    """OpenCV's 8-bit CIELab in its own units."""
    scaled = lab.astype(np.float32) * np.array([100 / 255, 1, 1], np.float32)
    return np.asarray(scaled - np.array([0, 128, 128], np.float32), np.float32)
