"""A photo and a face go in; the strokes of a line portrait come out (thesis 3.1, 3.5, 4.3)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from limner.errors import BadInput
from limner.settings import SettingsGroup, group
from limner.types import EdgeMap, Face, Photo, Strokes
from limner.vision.edges import EXTRACTORS, CannySettings, GaborSettings
from limner.vision.regions import RegionSettings, regions_and_weights
from limner.vision.scale import ScaleSettings, apply, to_working_scale
from limner.vision.skeleton import skeletonize
from limner.vision.spline_style import SplinesSettings, spline_strokes
from limner.vision.trace import TraceSettings, trace
from limner.vision.trim import TrimSettings, trim

SPLINES = "splines"

STYLES = (*EXTRACTORS, SPLINES)
"""Named ways from a photo and a face to strokes."""


@dataclass(frozen=True)
class LineSettings(SettingsGroup):
    """Everything between a photo and its strokes; an extractor's group bears the name of its style."""

    scale: ScaleSettings = group(ScaleSettings)
    canny: CannySettings = group(CannySettings)
    gabor: GaborSettings = group(GaborSettings)
    splines: SplinesSettings = group(SplinesSettings)
    trim: TrimSettings = group(TrimSettings)
    trace: TraceSettings = group(TraceSettings)
    regions: RegionSettings = group(RegionSettings)


def draw_lines(photo: Photo, face: Face, style: str, settings: LineSettings) -> Strokes:
    """Strokes of a photo, the heaviest first.

    Args:
        photo: any size.
        face: a frontal face in it.
        style: one of ``STYLES``.
        settings: of every stage.

    Returns:
        Strokes in the pixels of the photo; none where nothing is seen.

    Raises:
        BadInput: no such style, a profile, a face of a few pixels, or one outside the photo.
    """
    if style not in STYLES:
        raise BadInput(f"style: '{style}' does not exist; choose from {', '.join(STYLES)}")
    if style == SPLINES:
        return spline_strokes(photo, face, settings.splines, settings.regions)
    working = to_working_scale(photo, face, settings.scale)
    edges = EXTRACTORS[style](working.photo, working.face, getattr(settings, style))
    strokes = edges_to_strokes(edges, working.face, settings)
    lines = tuple(apply(working.photo_from_working, line) for line in strokes.lines_px)
    return Strokes(lines, strokes.region, strokes.weight, photo.size_px)


def edges_to_strokes(edges: EdgeMap, face: Face, settings: LineSettings) -> Strokes:
    """Trim an edge map, thin it, trace it and say what each line belongs to; the heaviest stroke comes first.

    Args:
        edges: of a photo at the working scale.
        face: in that photo.
        settings: those of trim, trace and regions are used.

    Returns:
        Strokes in the pixels of the edge map.
    """
    mask = trim(edges, face, settings.trim).mask
    lines = trace(skeletonize(mask), settings.trace, mask)
    regions, weights = regions_and_weights(lines, edges, face, settings.regions)
    order = np.argsort(-weights, kind="stable")
    height, width = edges.mask.shape
    return Strokes(tuple(lines[i] for i in order), tuple(regions[i] for i in order), weights[order], (width, height))
