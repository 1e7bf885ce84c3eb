"""Ways from a photo and a face to an edge map, by the name of the style that draws with them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from limner.types import EdgeMap, Face, Photo
from limner.vision.edges.canny import CannySettings, canny_edges
from limner.vision.edges.gabor import GaborSettings, gabor_edges, gabor_lines, gabor_sight
from limner.vision.edges.gabor_pyramid import GaborPyramidSettings, gabor_pyramid_edges

EXTRACTORS: dict[str, Callable[[Photo, Face, Any], EdgeMap]] = {
    "gabor": gabor_edges,
    "canny": canny_edges,
    "gabor-pyramid": gabor_pyramid_edges,
}
"""Each takes a photo at the working scale, the face in it, and its own settings."""

IN_TWO: dict[str, tuple[Callable[[Photo, Face, Any], Any], Callable[[Any, Any], EdgeMap]]] = {
    "gabor": (gabor_sight, gabor_lines),
}
"""Extractors of which most does not depend on all settings: what is seen of photo and face with ``settings.seeing()``,
and the lines in that with all of the settings. Who draws again and again keeps the first."""

__all__ = [
    "EXTRACTORS",
    "IN_TWO",
    "CannySettings",
    "GaborPyramidSettings",
    "GaborSettings",
    "canny_edges",
    "gabor_edges",
    "gabor_pyramid_edges",
]
