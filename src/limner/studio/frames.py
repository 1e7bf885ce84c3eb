"""A drawing goes in; the binary frame of it that the page draws comes out (docs/studio-protocol.md says each byte)."""

from __future__ import annotations

import struct

import numpy as np
from numpy.typing import NDArray

from limner.types import REGIONS, Drawing, Floats

LINES, PLAN = 1, 2
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
    joined: Floats = np.concatenate([np.empty((0, 2)), *drawing.lines_mm])
    unit, points = _shortened(joined, drawing.page.height_mm)
    head = struct.pack("<BxxxIIIfI", LINES, rev, len(counts), len(points), unit, 0)
    ends = np.cumsum([0, *counts], dtype="<u4").tobytes()
    regions = bytes(REGIONS.index(region) for region in drawing.region)
    return head + ends + points.tobytes() + regions + drawing.layer.astype("u1").tobytes()


def _shortened(places_mm: Floats, page_height_mm: float) -> tuple[float, NDArray[np.int16]]:
    """The unit [mm], and all places (n, 2) in it, y down."""
    down = [0, page_height_mm] + places_mm * [1, -1]
    unit = max(UNIT_MM, float(np.abs(down).max(initial=0)) / _REACH)
    return unit, np.rint(down / unit).astype("<i2")


def plan_frame(
    rev: int,
    page_height_mm: float,
    t_s: Floats,
    places_mm: Floats,
    stroke: NDArray[np.int64],
    down: NDArray[np.bool_],
    joints: Floats | None = None,
) -> bytes:
    """The motion of a pen, and of the joints that lead it: 24 bytes of head, then times, places, joints, lines, pen.

    Args:
        rev: of the request.
        page_height_mm: of the page, from whose upper edge y goes down in the frame.
        t_s: (n,).
        places_mm: (n, 2) of the tip, page frame.
        stroke: (n,) line that is drawn, -1 in travel.
        down: (n,) whether the move that ends there draws.
        joints: (n, d), or None.
    """
    q = np.zeros((len(t_s), 0)) if joints is None else joints
    unit, places = _shortened(places_mm, page_height_mm)
    head = struct.pack("<BxxxIIIfI", PLAN, rev, len(t_s), q.shape[1], unit, 0)
    parts = (t_s.astype("<f4"), places, q.astype("<f4"), stroke.astype("<i4"), down.astype("u1"))
    return head + b"".join(part.tobytes() for part in parts)
