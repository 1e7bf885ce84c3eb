"""A drawing goes in; the binary frame of it that the page draws comes out (docs/studio-protocol.md says each byte)."""

from __future__ import annotations

import struct

import numpy as np

from limner.types import REGIONS, Drawing, Floats

PREVIEW, PLAN = 1, 2
"""What a frame holds."""

UNIT_MM = 0.01
"""What 1 in an int16 means, unless the page is larger than that reaches."""

_REACH = 32767


def lines_frame(drawing: Drawing, rev: int) -> bytes:
    """The strokes of a drawing: 24 bytes of head, ends and regions of the lines, their points.

    Args:
        drawing: points in the page frame; in the frame y goes down from the upper left corner.
        rev: of the request.
    """
    counts = [len(line) for line in drawing.lines_mm]
    unit, points = short_points(drawing)
    head = struct.pack("<BxHIIIfI", PREVIEW, 0, rev, len(counts), len(points), unit, 0)
    ends = np.cumsum([0, *counts], dtype="<u4").tobytes()
    regions = bytes(REGIONS.index(region) for region in drawing.region)
    return head + ends + points.tobytes() + regions


def short_points(drawing: Drawing) -> tuple[float, np.ndarray[tuple[int, int], np.dtype[np.int16]]]:
    """The unit [mm], and all points (n, 2) in it, y down."""
    joined: Floats = np.concatenate([np.empty((0, 2)), *drawing.lines_mm])
    down = [0, drawing.page.height_mm] + joined * [1, -1]
    unit = max(UNIT_MM, float(np.abs(down).max(initial=0)) / _REACH)
    return unit, np.rint(down / unit).astype("<i2")
