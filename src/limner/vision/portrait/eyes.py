"""A photo and its face go in; both eyes come out: lids, the fold above, iris and pupil."""

from __future__ import annotations

import dataclasses

import numpy as np

from limner import geometry
from limner.types import Face, Floats
from limner.vision.edges.iris import Disc, find_iris
from limner.vision.head import EYES, Frame, face_frame, inside
from limner.vision.portrait.band import measure
from limner.vision.portrait.follow import Manner, follow, settle
from limner.vision.portrait.marks import Mark, curve, runs, taken
from limner.vision.portrait.seen import Seen
from limner.vision.raster import Image, blurred

LIDS = (([36, 37, 38, 39], [36, 41, 40, 39]), ([45, 44, 43, 42], [45, 46, 47, 42]))
"""Upper and lower lid of both eyes, from the outer corner to the inner."""

LASHES_PX = 1.6
"""Distance of the strokes that make a lid heavy: about a pen's width."""

LIMITS = ((-0.85, -0.2), (0.3, 1.0))
"""How far below the middle of the iris the upper and the lower lid pass it, from and to, in radii of the iris."""

OFF = 0.25
"""How far its middle may lie from half-way between the lids, in radii: they cover the rest of its rim."""

MANNER = Manner(stiff=0.04, smooth_px=4)

TURNED = 0.4
"""An eye narrower than this share of the other is turned away."""

DARK_GLASS = 0.3
"""Lightness under an eye, over that of the cheek, below which glasses are dark."""

OPEN, LIKELY_IRIS = 0.05, 0.066
"""Lids farther apart than this show an iris, and its usual radius [outer-eye distances]."""

HATCH_PX = 1.5
"""Distance of the strokes that fill the pupil: about a pen's width."""

GLINT = -0.2
"""Above this the right half of the pupil shines, in its radii below the middle."""

LIGHT_PUPIL, DARK_PUPIL, DARK_IRIS = 0.42, 0.6, -1.5
"""Radius of the pupil over that of the iris, in light and in dark irises; and the lightness between the two."""


def draw_eyes(seen: Seen, face: Face) -> list[Mark]:
    """The strokes of both eyes, but for one turned away and for what dark glasses hide."""
    eyes = [face.points_px[ring[:6]] for ring in EYES]
    widths = [float(np.hypot(*(eye[3] - eye[0]))) for eye in eyes]
    if _behind_dark_glass(seen, face, eyes):
        return []
    marks: list[Mark] = []
    for lids, eye, width in zip(LIDS, eyes, widths, strict=True):
        if width > TURNED * max(widths):
            marks += _eye(seen, face, lids, eye)
    return marks


def _behind_dark_glass(seen: Seen, face: Face, eyes: list[Floats]) -> bool:
    """Whether it is darker under the eyes than any shadow on skin."""
    grey = blurred(seen.grey, 0.03 * face.outer_eye_px)
    down = face_frame(face).axes_px[1]
    middles = np.array([eye.mean(axis=0) for eye in eyes])
    under, cheeks = (seen.at(grey, middles + far * down) for far in (0.11, 0.4))
    return bool((under / np.maximum(cheeks, 1e-3)).mean() < DARK_GLASS)


def _eye(seen: Seen, face: Face, lids: tuple[list[int], list[int]], eye: Floats) -> list[Mark]:
    unit, frame = face.outer_eye_px, face_frame(face)
    disc = find_iris(seen.grey, eye, unit) or _likely_iris(eye, unit)
    guides = [curve(face.points_px[lid]) for lid in lids]
    outside = _without(seen, disc)
    if disc is None:
        shift = settle(outside, guides, 0.06 * unit, outside.fine)
        guides = [guide + shift for guide in guides]
    else:
        shift = settle(outside, guides, 0.03 * unit, outside.fine)
        guides = [guide + shift for guide in guides]
        disc = between_lids(disc, guides, frame)
        guides = [_at_iris(guide, disc, frame, limits) for guide, limits in zip(guides, LIMITS, strict=True)]
    found = [follow(outside, guide, 0.028 * unit, outside.fine, MANNER).line for guide in guides]
    if disc is not None:
        disc = between_lids(disc, found, frame)
        found = [_at_iris(lid, disc, frame, limits) for lid, limits in zip(found, LIMITS, strict=True)]
    above, below = _meeting(*found)
    marks = [*_lashes(seen, above, frame), Mark(taken(below, 0.0, 0.92), "eye", 0.8)]
    return marks if disc is None else [*marks, *_iris(seen, disc, np.concatenate([above, below[::-1]]))]


def _likely_iris(eye: Floats, unit: float) -> Disc | None:
    """The middle of an open eye that lies in the dark."""
    opening = float(np.hypot(*((eye[4] + eye[5] - eye[1] - eye[2]) / 2)))
    return Disc(eye.mean(axis=0), LIKELY_IRIS * unit) if opening > OPEN * unit else None


def between_lids(disc: Disc, lids: list[Floats], frame: Frame) -> Disc:
    """The iris moved up or down to where an eye that looks at us has it: about the middle of its opening."""
    centre, radius = frame.from_photo(disc.centre), disc.radius / float(np.hypot(*frame.axes_px[0]))
    places = [frame.from_photo(lid) for lid in lids]
    middle = np.mean([place[np.abs(place[:, 0] - centre[0]).argmin(), 1] for place in places])
    centre[1] = np.clip(centre[1], middle - OFF * radius, middle + OFF * radius)
    return Disc(frame.to_photo(centre), disc.radius)


def _at_iris(lid: Floats, disc: Disc, frame: Frame, limits: tuple[float, float]) -> Floats:
    """The lid bent up or down so that it passes the iris within limits, in radii below its centre."""
    place, centre = frame.from_photo(lid), frame.from_photo(disc.centre)
    radius = disc.radius / float(np.hypot(*frame.axes_px[0]))
    beside = (place[:, 0] - centre[0]) / radius
    here = place[np.abs(beside).argmin(), 1]
    wanted = np.clip(here, centre[1] + limits[0] * radius, centre[1] + limits[1] * radius)
    bump = np.exp(-((beside / 2.6) ** 2) / 2)
    return frame.to_photo(place + np.stack([np.zeros_like(bump), bump * (wanted - here)], axis=1))


def _without(seen: Seen, disc: Disc | None) -> Seen:
    """What is seen, but for the iris, whose rim is no lid."""
    if disc is None:
        return seen
    y, x = np.indices(seen.fine.shape)
    inner = np.hypot(x - disc.centre[0], y - disc.centre[1]) < 0.8 * disc.radius
    fine: Image = np.where(inner, np.float32(0), seen.fine)
    return dataclasses.replace(seen, fine=fine)


def _meeting(upper: Floats, lower: Floats) -> tuple[Floats, Floats]:
    """Both lids bent so that they meet in the corners of the eye."""
    lids = []
    corners = [(upper[end] + lower[end]) / 2 for end in (0, -1)]
    for lid in (upper, lower):
        share = np.linspace(0, 1, len(lid))[:, None]
        start, end = np.clip(1 - share / 0.25, 0, 1) ** 2, np.clip(1 - (1 - share) / 0.25, 0, 1) ** 2
        lids.append(lid + start * (corners[0] - lid[0]) + end * (corners[1] - lid[-1]))
    return lids[0], lids[1]


def _lashes(seen: Seen, lid: Floats, frame: Frame) -> list[Mark]:
    """The upper lid, and where it is dark a second stroke above it that begins and ends on it."""
    band = measure(seen, lid, 0.05 * float(np.hypot(*frame.axes_px[0])))
    if np.quantile(band.width, 0.7) < 1.5 * LASHES_PX:
        return [Mark(lid, "eye")]
    share = np.linspace(0, 1, len(lid))[:, None]
    up = -frame.axes_px[1] / np.hypot(*frame.axes_px[1])
    second = lid + 1.1 * LASHES_PX * np.sin(np.pi * share**0.8) * up
    return [Mark(np.concatenate([lid, taken(second, 0.06, 1.0)[::-1]]), "eye")]


def _iris(seen: Seen, disc: Disc, opening: Floats) -> list[Mark]:
    """Rim and pupil as far as the lids leave them free; dark irises have a large one."""
    turn = np.linspace(-np.pi / 2, 1.5 * np.pi, 49)
    rim = disc.centre + disc.radius * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    marks = [Mark(arc, "eye") for arc in _visible(rim, opening)]
    ground = float(seen.at(seen.light, disc.centre + 0.75 * (rim - disc.centre)).mean())
    size = LIGHT_PUPIL if ground > DARK_IRIS else DARK_PUPIL
    hatch = hatched(disc.centre, size * disc.radius)
    return [*marks, *(Mark(part, "eye", 1.5) for part in _visible(hatch, opening))]


def hatched(centre: Floats, radius: float) -> Floats:
    """One stroke to and fro (n, 2) that fills a disc but for a glint at the upper right.

    Args:
        centre: (2,) of the disc.
        radius: of the disc.
    """
    rows = np.linspace(-0.9, 0.9, max(3, round(2 * radius / HATCH_PX)))
    left, right = -np.sqrt(1 - rows**2), np.where(rows < GLINT, 0.0, np.sqrt(1 - rows**2))
    forth = (np.arange(len(rows)) % 2 == 0)[:, None]
    ends = np.where(forth, np.stack([left, right], axis=1), np.stack([right, left], axis=1))
    zigzag = np.stack([ends, np.repeat(rows[:, None], 2, axis=1)], axis=2).reshape(-1, 2)
    return centre + radius * geometry.resample(zigzag, 0.15)


def _visible(line: Floats, opening: Floats) -> list[Floats]:
    """The parts of a line within an outline."""
    return [line[run] for run in runs(inside(line, opening)) if len(run) > 2]
