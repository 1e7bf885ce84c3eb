"""Ways from a photo and a face to an edge map, by the name of the style that draws with them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from limner.types import EdgeMap, Face, Photo
from limner.vision.edges.canny import CannySettings, canny_edges
from limner.vision.edges.gabor import GaborSettings, gabor_edges
from limner.vision.edges.gabor_pyramid import GaborPyramidSettings, gabor_pyramid_edges

EXTRACTORS: dict[str, Callable[[Photo, Face, Any], EdgeMap]] = {
    "gabor": gabor_edges,
    "canny": canny_edges,
    "gabor-pyramid": gabor_pyramid_edges,
}
"""Each takes a photo at the working scale, the face in it, and its own settings."""

__all__ = [
    "EXTRACTORS",
    "CannySettings",
    "GaborPyramidSettings",
    "GaborSettings",
    "canny_edges",
    "gabor_edges",
    "gabor_pyramid_edges",
]
