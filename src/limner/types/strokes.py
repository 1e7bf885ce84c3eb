"""Ordered polylines in the pixels of a photo."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from limner.types.lines import checked_layers, checked_lines, checked_pens, checked_regions, first_layer
from limner.types.page import Pen
from limner.types.values import Floats, Value, frozen_array


@dataclass(frozen=True, eq=False)
class Strokes(Value):
    """Ordered polylines in the photo.

    Attributes:
        lines_px: tuple of (n, 2), photo frame; closed when first = last.
        region: of each line, one of ``REGIONS``.
        weight: (lines,) how much the drawing would miss it, >= 0.
        size_px: width and height of the photo.
        pens: what colours there are; their widths are settled where the strokes are placed on a page.
        layer: (lines,) index of each line's pen; none given: the first.
    """

    lines_px: tuple[Floats, ...]
    region: tuple[str, ...]
    weight: Floats
    size_px: tuple[int, int]
    pens: tuple[Pen, ...] = (Pen(),)
    layer: NDArray[np.int64] = field(default_factory=first_layer)

    def __post_init__(self) -> None:
        self._freeze("lines_px", checked_lines(self.lines_px, "Strokes.lines_px"))
        self._freeze("region", checked_regions(self.region, len(self.lines_px), "Strokes.region"))
        self._freeze("weight", frozen_array(self.weight, np.float64, (len(self.lines_px),), "Strokes.weight"))
        width, height = self.size_px
        self._freeze("size_px", (int(width), int(height)))
        self._freeze("pens", checked_pens(self.pens, "Strokes.pens"))
        self._freeze("layer", checked_layers(self.layer, len(self.lines_px), len(self.pens), "Strokes.layer"))
