"""Lines whose page is not known go in; the smallest of the usual pages that holds them comes out."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from limner.types import Floats, Page
from limner.units import PAGES_MM

FARTHEST_MM = 1e6
"""No plotter's pen goes farther: a file that says so is for something else, or damaged."""


def page_for(lines_mm: Sequence[Floats]) -> Page:
    """A named page, upright or across, without margin; one as large as the lines where none is large enough."""
    reach = np.concatenate([[[0.0, 0.0]], *lines_mm]).max(axis=0)
    sides = sorted({pair for size in PAGES_MM.values() for pair in (size, size[::-1])}, key=lambda s: (s[0] * s[1], s))
    for width, height in sides:
        if reach[0] <= width and reach[1] <= height:
            return Page(width, height, 0.0)
    return Page(max(1.0, float(reach[0])), max(1.0, float(reach[1])), 0.0)
