"""A photo goes in; what the portrait looks at comes out: light, flow, and dark lines fine and coarse."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from limner.settings import SettingsGroup, setting
from limner.types import Floats, Photo
from limner.vision.edges.fdog import coherent_lines, evened
from limner.vision.edges.flow import Flow, edge_flow, sampled
from limner.vision.raster import Image, resized

COARSE = 2
"""The coarse lines are looked for in a picture this many times smaller."""


@dataclass(frozen=True)
class FlowSettings(SettingsGroup):
    """How lines are seen; pixels are those of the working scale."""

    width_px: float = setting(
        1.0, "half the width of the finest lines, standard deviation; the coarse ones are twice as wide", unit="px",
        low=0.5, high=10,
    )  # fmt: skip
    along_px: float = setting(
        5.0, "how far a line is followed to see whether it goes on, standard deviation", unit="px", low=1, high=50
    )
    reach_px: float = setting(2.5, "neighbourhood that agrees on a direction", unit="px", low=0.5, high=50)
    contrast_px: float = setting(
        32.0, "surroundings whose contrast is evened out, standard deviation", unit="px", low=4, high=500
    )
    floor: float = setting(0.01, "contrast below which nothing is amplified, of black to white", low=1e-5, high=1)


@dataclass(frozen=True, eq=False)
class Seen:
    """A photo as the portrait looks at it.

    Attributes:
        grey: (H, W) lightness in [0, 1].
        red: (H, W) from green to red, a* of CIELab, in the unit of the lightness.
        light: (H, W) the same with contrast evened out: about 0 on average, about 1 from dark to light.
        flow: direction of the lines; ``broad`` the same over a wider neighbourhood, for hair and outlines.
        fine, coarse: (H, W) >= 0 strength of the dark lines, in the unit of ``light``.
    """

    grey: Image
    red: Image
    light: Image
    flow: Flow
    broad: Flow
    fine: Image
    coarse: Image

    @property
    def both(self) -> Image:
        """(H, W) strength of the lines, whatever their width."""
        return np.maximum(self.coarse, self.fine)

    def at(self, image: Image, points: Floats) -> Floats:
        """A picture at points (..., 2)."""
        flat = points.reshape(-1, 2).astype(np.float32)
        # OpenCV's remap takes pictures of at most 2^15 pixels a side.
        rows = np.pad(flat, ((0, -len(flat) % 256), (0, 0))).reshape(-1, 256, 2)
        values = sampled(image, rows[..., 0], rows[..., 1]).ravel()[: len(flat)]
        return values.reshape(points.shape[:-1]).astype(np.float64)


def look_at(photo: Photo, settings: FlowSettings) -> Seen:
    """See a photo at the working scale."""
    lab = np.asarray(cv2.cvtColor(photo.rgb.astype(np.float32) / 255, cv2.COLOR_RGB2LAB), np.float32) / 100
    return look_at_light(np.ascontiguousarray(lab[..., 0]), np.ascontiguousarray(lab[..., 1]), settings)


def look_at_light(grey: Image, red: Image, settings: FlowSettings) -> Seen:
    """See lightness (H, W) and redness (H, W), as ``Seen`` has them."""
    light = evened(grey, settings.contrast_px, settings.floor)
    flow = edge_flow(light, 1.0, settings.reach_px)
    fine = coherent_lines(light, flow, settings.width_px, settings.along_px)
    height, width = grey.shape
    size = (-(-width // COARSE), -(-height // COARSE))
    small = resized(light, size, cv2.INTER_AREA)
    bent = edge_flow(small, 0.7, settings.reach_px)
    coarse = resized(coherent_lines(small, bent, settings.width_px, settings.along_px), (width, height))
    x, y = (resized(part, (width, height), cv2.INTER_NEAREST) for part in (bent.x, bent.y))
    broad = Flow(x, y, resized(bent.coherence, (width, height)))
    return Seen(grey, red, light, flow, broad, fine, coarse)
