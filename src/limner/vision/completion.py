"""Strokes and a face go in; the strokes, and splines through the landmarks where a feature has none, come out.

The thesis's last suggestion (3.5): where jaw or features are incomplete, curves through the landmarks replace what is
missing. It warns that they may look artificial, so nothing is added unless asked for.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from limner import geometry
from limner.settings import SettingsGroup, names_in, setting
from limner.types import Face, Floats, Strokes
from limner.vision.head import BROWS, JAW, NOSTRILS
from limner.vision.regions import RegionSettings
from limner.vision.spline_style import INNER_LIPS, LIDS, OUTER_LIPS
from limner.vision.splines import natural_spline

STEP = 0.01
"""Spacing of the places that are looked at [outer-eye distances]."""

GRIP = 0.025
"""How far along the curve ink reaches beyond itself [outer-eye distances]: no gap at a corner between two strokes."""

PARTS: dict[str, tuple[list[int], ...]] = {
    "jaw": (JAW,),
    "brow": BROWS,
    "eye": tuple(lid for eye in LIDS for lid in eye),
    "nose": (NOSTRILS,),
    "mouth": (*INNER_LIPS, *OUTER_LIPS),
}
"""Landmarks of each spline of a feature, by its region; the line between the lips comes before their outlines."""

ALL = "all"


@dataclass(frozen=True)
class CompletionSettings(SettingsGroup):
    """When a stretch of a feature counts as missing; lengths in outer-eye distances."""

    jaw: float = setting(0.09, "ink this near to the jaw's curve is the jaw", low=0, high=1)
    brow: float = setting(0.08, "likewise for brows", low=0, high=1)
    eye: float = setting(0.035, "likewise for lids", low=0, high=1)
    nose: float = setting(0.06, "likewise for the base of the nose", low=0, high=1)
    mouth: float = setting(0.045, "likewise for lips", low=0, high=1)
    bend_deg: float = setting(
        50.0, "ink that runs across the curve by more than this does not count", unit="deg", low=0, high=90
    )
    shortest: float = setting(0.1, "missing stretches shorter than this stay open", low=0, high=10)
    blend: float = setting(0.3, "length over which an added line leaves what it is joined to", low=0, high=10)
    tolerance: float = setting(0.002, "vertices that bend an added line less than this go", low=0, high=0.5)


def names_of(text: str) -> tuple[str, ...]:
    """The features that a text names, separated by commas; all for ``all``, none for ``none`` or nothing.

    Raises:
        BadInput: a feature that does not exist.
    """
    names = names_in(text, (*PARTS, ALL), "complete")
    return tuple(PARTS) if ALL in names else names


def complete(
    strokes: Strokes, face: Face, names: str, settings: CompletionSettings, importance: RegionSettings
) -> Strokes:
    """Add what is missing of some features.

    Args:
        strokes: of a photo; all of them come back as they are.
        face: a frontal one in that photo.
        names: of features, separated by commas (see ``names_of``).
        settings: what counts as missing.
        importance: of each region, for the weights of what is added.

    Raises:
        BadInput: no such feature, a profile, or both outer eye corners are one point.
    """
    lines, regions, weights = list(strokes.lines_px), list(strokes.region), strokes.weight.tolist()
    unit = face.outer_eye_px if names_of(names) else 1.0
    for name in names_of(names):
        for landmarks in PARTS[name]:
            curve = natural_spline(face.points_px[landmarks]).line(STEP * unit)
            near = getattr(settings, name) * unit
            # What was added for one feature is ink for the next: the lips of a closed mouth are one line.
            for added in list(_missing(curve, Ink.of(lines, STEP * unit), near, unit, settings)):
                lines.append(added)
                regions.append(name)
                weights.append(geometry.length(added) / unit * getattr(importance, name))
    order = np.argsort(-np.array(weights), kind="stable")
    ordered = tuple(lines[i] for i in order)
    layer = np.concatenate([strokes.layer, np.zeros(len(lines) - len(strokes.lines_px), np.int64)])[order]
    named = tuple(regions[i] for i in order)
    return Strokes(ordered, named, np.array(weights)[order], strokes.size_px, strokes.pens, layer)


@dataclass(frozen=True, eq=False)
class Ink:
    """Places along lines.

    Attributes:
        points: (n, 2).
        along: (n, 2) direction of the line there, of unit length.
    """

    points: Floats
    along: Floats

    @classmethod
    def of(cls, lines: list[Floats], step: float) -> Ink:
        """Places along lines, each line's ends among them."""
        parts = [part for part in (geometry.resample(line, step) for line in lines) if len(part) > 1]
        if not parts:
            return cls(np.zeros((0, 2)), np.zeros((0, 2)))
        return cls(np.concatenate(parts), np.concatenate([directions(part) for part in parts]))

    def around(self, curve: Floats, reach: float) -> Ink:
        """Those that may be within reach of a curve."""
        within = ((self.points > curve.min(axis=0) - reach) & (self.points < curve.max(axis=0) + reach)).all(axis=1)
        return Ink(self.points[within], self.along[within])


def directions(line: Floats) -> Floats:
    """Direction (n, 2) of a polyline at each of its points, of unit length."""
    slopes = np.gradient(line, axis=0)
    unit: Floats = slopes / np.maximum(np.hypot(*slopes.T), 1e-12)[:, None]
    return unit


def _missing(curve: Floats, ink: Ink, near: float, unit: float, settings: CompletionSettings) -> Iterator[Floats]:
    """The stretches of a curve without ink, each bent to end where the ink goes on."""
    if len(curve) < 2:
        return
    ink = ink.around(curve, near + GRIP * unit)
    beside = _beside(curve, ink, near, GRIP * unit, settings.bend_deg)
    for start, end in _runs(beside.sum(axis=1) == 0):
        if geometry.length(curve[start:end]) < settings.shortest * unit:
            continue
        before = _nearest(ink.points[beside[start - 1]], curve[start]) if start > 0 else None
        after = _nearest(ink.points[beside[end]], curve[end - 1]) if end < len(curve) else None
        line = _joined(curve, (start, end), (before, after), settings.blend * unit)
        yield geometry.simplify(line, settings.tolerance * unit)


def _beside(curve: Floats, ink: Ink, near: float, grip: float, bend_deg: float) -> NDArray[np.bool_]:
    """Which ink lies beside which place of a curve, and runs as the curve does there.

    Args:
        curve: (n, 2).
        ink: m places.
        near: largest distance across the curve.
        grip: largest distance along it.
        bend_deg: largest angle between the two.

    Returns:
        (n, m) bool.
    """
    along = directions(curve)
    apart = ink.points - curve[:, None]
    forward = np.abs((apart * along[:, None]).sum(axis=2))
    sideways = np.abs(apart[..., 0] * along[:, 1, None] - apart[..., 1] * along[:, 0, None])
    alike = np.abs(along @ ink.along.T) >= np.cos(np.deg2rad(bend_deg))
    beside: NDArray[np.bool_] = (forward <= grip) & (sideways <= near) & alike
    return beside


def _nearest(points: Floats, place: Floats) -> Floats:
    nearest: Floats = points[np.hypot(*(points - place).T).argmin()]
    return nearest


def _runs(flags: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First and last + 1 of each run of true."""
    steps = np.diff(np.concatenate([[0], flags.astype(np.int8), [0]]))
    return list(zip(np.flatnonzero(steps == 1).tolist(), np.flatnonzero(steps == -1).tolist(), strict=True))


def _joined(curve: Floats, part: tuple[int, int], anchors: tuple[Floats | None, Floats | None], blend: float) -> Floats:
    """A part of a curve, its ends moved to what they are joined to, smoothly.

    Args:
        curve: (n, 2).
        part: where it starts and ends, the last excluded.
        anchors: where the ink before and after it ends; None where the curve itself begins or ends.
        blend: how far from its ends the part may leave the curve.
    """
    (start, end), (before, after) = part, anchors
    if before is not None:
        start = int(np.hypot(*(curve[:start] - before).T).argmin())
    if after is not None:
        end = end + int(np.hypot(*(curve[end:] - after).T).argmin()) + 1
    bent = curve[start:end].copy()
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(bent, axis=0).T))])
    reach = max(min(blend, along[-1] / 2), 1e-9)
    for anchor, place, away in ((before, 0, along), (after, -1, along[-1] - along)):
        if anchor is not None:
            share = (1 + np.cos(np.pi * np.minimum(away / reach, 1))) / 2
            bent += share[:, None] * (anchor - bent[place])
    return bent
