"""A photo and its face go in; the mouth comes out: the line between the lips, and the lips."""

from __future__ import annotations

import numpy as np

from limner import geometry
from limner.types import Face, Floats
from limner.vision.portrait.band import lenses
from limner.vision.portrait.follow import Manner, follow, settle
from limner.vision.portrait.marks import Mark, curve, runs
from limner.vision.portrait.seen import FlowSettings, Seen, look_at_light

SEEN = 0.05
"""Strength from which a lip is there."""

REDNESS = 1.5
"""How much redder counts as darker where the lips begin: often they are no darker than the skin."""

MANNER = Manner(stiff=0.06, smooth_px=4)

OPEN = 0.03
"""Inner lips farther apart than this show teeth or the mouth's dark [outer-eye distances]."""


def draw_mouth(seen: Seen, face: Face, flow: FlowSettings) -> list[Mark]:
    """The line between the lips, their outlines, and no single tooth."""
    unit, marks = face.outer_eye_px, face.points_px
    gap = float(np.hypot(*(marks[66] - marks[62]))) / unit
    guides = [curve(marks[[48, *range(60, 65), 54]]), curve(marks[[48, 49, 50, 51, 52, 53, 54]])]
    guides.append(curve(marks[[48, 59, 58, 57, 56, 55, 54]]))
    if gap > OPEN:
        guides.append(curve(marks[[48, 60, 67, 66, 65, 64, 54]]))
    shift = settle(seen, guides, 0.09 * unit, seen.coarse)
    lines = [follow(seen, guide + shift, 0.04 * unit, seen.fine, MANNER) for guide in (guides[0], *guides[3:])]
    between = lines[0].line
    found = [Mark(between, "mouth", 1.2)]
    found += [Mark(line, "mouth", 0.8) for line in lenses(seen, between, unit)]
    for lip in lines[1:]:
        for part in lip.parts(SEEN, 0.2 * unit, 0.1 * unit):
            found += [Mark(line, "mouth") for line in _clear_of(part, between, 3.0)]
    redness, offset = _lips(seen, face, flow)
    for guide in guides[1:3]:
        lip = follow(redness, guide + shift - offset, 0.035 * unit, redness.fine, MANNER)
        for part in lip.parts(SEEN, 0.1 * unit, 0.1 * unit):
            found += [Mark(line, "mouth", 0.7) for line in _clear_of(part + offset, between, 3.0)]
    return found


def _lips(seen: Seen, face: Face, flow: FlowSettings) -> tuple[Seen, Floats]:
    """The surroundings of the mouth, redder seen as darker, and where (2,) they begin."""
    height, width = seen.grey.shape
    reach = 0.25 * face.outer_eye_px
    low = np.clip(np.floor(face.points_px[48:60].min(axis=0) - reach), 0, [width - 1, height - 1]).astype(int)
    high = np.clip(np.ceil(face.points_px[48:60].max(axis=0) + reach), low + 1, [width, height]).astype(int)
    part = (slice(low[1], high[1]), slice(low[0], high[0]))
    redder = seen.grey[part] - np.float32(REDNESS) * seen.red[part]
    return look_at_light(redder, seen.red[part], flow), low.astype(np.float64)


def _clear_of(line: Floats, other: Floats, away: float) -> list[Floats]:
    """The longest part of a line that is farther than ``away`` [px] from another, if there is one."""
    points = geometry.resample(line, 2.0)
    clear = np.hypot(*(points[:, None] - geometry.resample(other, 2.0)[None]).transpose(2, 0, 1)).min(axis=1) > away
    parts = [run for run in runs(clear) if len(run) > 4]
    return [points[max(parts, key=len)]] if parts else []
