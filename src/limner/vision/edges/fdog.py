"""Luminance and its flow go in; how strongly a dark line runs along the flow through each pixel comes out."""

from __future__ import annotations

import numpy as np

from limner.vision.edges.flow import Flow, averaged_along, sampled
from limner.vision.raster import Image, blurred, widely_blurred

SURROUND = 1.6
"""Width of the surroundings over that of the line: a difference of Gaussians is then nearest to the Laplacian."""


def coherent_lines(grey: Image, flow: Flow, width_px: float, along_px: float) -> Image:
    """Flow-based difference of Gaussians (Kang et al. 2007, doi:10.1145/1274871.1274878).

    Across the flow a Gaussian less a wider one, along it a Gaussian mean: what goes on counts, specks do not. A dark
    line answers at its middle, the border of a dark area just inside it.

    Args:
        grey: (H, W) luminance.
        flow: of it.
        width_px: standard deviation of the inner Gaussian: about half the width of the lines found.
        along_px: standard deviation along the flow.

    Returns:
        (H, W) >= 0 where it is darker than on both sides, in the unit of the luminance.
    """
    return np.maximum(averaged_along(-_across(grey, flow, width_px), flow, along_px), np.float32(0))


def _across(grey: Image, flow: Flow, width_px: float) -> Image:
    """The difference of Gaussians (H, W) at right angles to the flow."""
    reach = int(np.ceil(3 * SURROUND * width_px))
    offsets = np.arange(-reach, reach + 1)
    inner, outer = (np.exp(-0.5 * (offsets / sigma) ** 2) for sigma in (width_px, SURROUND * width_px))
    kernel = inner / inner.sum() - outer / outer.sum()
    y, x = np.indices(grey.shape, dtype=np.float32)
    total = np.zeros_like(grey)
    for offset, weight in zip(offsets.tolist(), kernel.tolist(), strict=True):
        total += np.float32(weight) * sampled(grey, x - np.float32(offset) * flow.y, y + np.float32(offset) * flow.x)
    return total


def evened(grey: Image, reach_px: float, floor: float) -> Image:
    """Luminance (H, W) whose contrast is about one everywhere: soft light and dark skin draw as hard light does.

    Args:
        grey: (H, W) luminance.
        reach_px: size of the surroundings that are compared, standard deviation.
        floor: contrast below which nothing is amplified, in the unit of the luminance.
    """
    detail = grey - widely_blurred(grey, reach_px)
    around = widely_blurred(np.abs(blurred(detail, 1.0)), reach_px)
    scaled: Image = detail / (around + np.float32(floor))
    return scaled
