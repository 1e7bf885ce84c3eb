"""Luminance goes in; the direction in which the lines around each pixel run, and how clearly they do, comes out."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from limner.vision.raster import Image, blurred


@dataclass(frozen=True, eq=False)
class Flow:
    """The edge tangent flow.

    Attributes:
        x, y: (H, W) float32 of unit length, along the lines; the sign has no meaning.
        coherence: (H, W) float32 from 0, all directions alike, to 1, one only.
    """

    x: Image
    y: Image
    coherence: Image

    @property
    def angle_rad(self) -> Image:
        """(H, W) direction in (-pi, pi], from x towards y (down)."""
        angle: Image = np.arctan2(self.y, self.x)
        return angle


def edge_flow(grey: Image, blur_px: float, reach_px: float) -> Flow:
    """The direction in which the brightness changes least, over a Gaussian neighbourhood.

    Kang et al. 2007 (doi:10.1145/1274871.1274878) turn the tangents of strong edges into a smooth field by repeated
    filtering; the structure tensor, averaged once, gives as good a field (Kyprianidis & Kang 2011,
    doi:10.1111/j.1467-8659.2011.01882.x): in it opposite slopes on both sides of a line agree.

    Args:
        grey: (H, W) luminance.
        blur_px: of the luminance before its slopes are taken, standard deviation; 0 for none.
        reach_px: size of the neighbourhood, standard deviation.
    """
    if blur_px:
        grey = blurred(grey, blur_px)
    dx, dy = slopes(grey)
    xx, xy, yy = (blurred(part, reach_px) for part in (dx * dx, dx * dy, dy * dy))
    along = np.float32(0.5) * np.arctan2(2 * xy, xx - yy) + np.float32(np.pi / 2)
    spread = np.hypot(xx - yy, 2 * xy)
    coherence = spread / (xx + yy + np.float32(1e-7))
    return Flow(np.cos(along), np.sin(along), coherence)


def slopes(grey: Image) -> tuple[Image, Image]:
    """Change (H, W) of the brightness over a pixel to the right and downward, by Scharr's filters."""
    x, y = (
        np.asarray(cv2.Scharr(grey, cv2.CV_32F, *way, scale=1 / 32, borderType=cv2.BORDER_REPLICATE), np.float32)
        for way in ((1, 0), (0, 1))
    )
    return x, y


def averaged_along(image: Image, flow: Flow, sigma_px: float, step_px: float = 1.5) -> Image:
    """A Gaussian mean of a picture (H, W) along the lines of the flow through each pixel.

    Args:
        image: what is averaged.
        flow: the way to go.
        sigma_px: standard deviation along the line; lines are followed for twice that in both directions.
        step_px: from sample to sample.
    """
    field = np.stack([flow.x, flow.y], axis=-1)
    start = np.indices(image.shape, dtype=np.float32)
    total, weights = image.copy(), 1.0
    for sign in (1, -1):
        way: Image = field * np.float32(sign)
        y: Image = start[0]
        x: Image = start[1]
        for k in range(1, int(np.ceil(2 * sigma_px / step_px)) + 1):
            way = _onward(field, way, x, y) if k > 1 else way
            x = np.asarray(x + step_px * way[..., 0], np.float32)
            y = np.asarray(y + step_px * way[..., 1], np.float32)
            weight = float(np.exp(-0.5 * (k * step_px / sigma_px) ** 2))
            total += np.float32(weight) * sampled(image, x, y)
            weights += weight
    return total / np.float32(weights)


def _onward(field: Image, way: Image, x: Image, y: Image) -> Image:
    """The flow (H, W, 2) at the places reached, turned so that it goes on as it came."""
    # Not interpolated: neighbours may have opposite signs, and their mean would be nothing.
    there = np.asarray(cv2.remap(field, x, y, cv2.INTER_NEAREST, borderMode=cv2.BORDER_REPLICATE), np.float32)
    onward = np.copysign(np.float32(1), there[..., 0] * way[..., 0] + there[..., 1] * way[..., 1])
    return there * onward[..., None]


def sampled(image: Image, x: Image, y: Image) -> Image:
    """A picture between its pixels, at places x, y of any one shape; the border is continued."""
    return np.asarray(cv2.remap(image, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE), np.float32)
