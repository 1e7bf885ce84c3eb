"""An edge map and a face go in; strokes come out: what is trimmed of it, thinned and traced (thesis 3.1, 3.5)."""

from __future__ import annotations

import numpy as np

from limner.stages import Stages
from limner.types import EdgeMap, Face, Strokes
from limner.vision.lines.settings import LineSettings
from limner.vision.regions import RegionSettings, regions_and_weights
from limner.vision.skeleton import skeletonize
from limner.vision.trace import TraceSettings, trace
from limner.vision.trim import trim


def edges_to_strokes(edges: EdgeMap, face: Face, settings: LineSettings, stages: Stages | None = None) -> Strokes:
    """Trim an edge map, thin it, trace it and say what each line belongs to; the heaviest stroke comes first.

    Args:
        edges: of a photo at the working scale.
        face: in that photo.
        settings: those of trim, trace and regions are used.
        stages: as for ``draw_lines``.

    Returns:
        Strokes in the pixels of the edge map.
    """
    stages = stages or Stages()
    trimmed = stages("trim", trim, edges, face, settings.trim)
    return stages("trace", _traced, trimmed, face, settings.trace, settings.regions)


def _traced(edges: EdgeMap, face: Face, settings: TraceSettings, importance: RegionSettings) -> Strokes:
    lines = trace(skeletonize(edges.mask), settings, edges.mask)
    regions, weights = regions_and_weights(lines, edges, face, importance)
    order = np.argsort(-weights, kind="stable")
    height, width = edges.mask.shape
    return Strokes(tuple(lines[i] for i in order), tuple(regions[i] for i in order), weights[order], (width, height))
