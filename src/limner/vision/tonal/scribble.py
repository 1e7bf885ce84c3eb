"""A photo and its face go in; a few very long strokes along the flow, closer where it is dark, come out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from limner import geometry
from limner.settings import SettingsGroup, setting
from limner.types import REGIONS, Face, Floats, Strokes
from limner.vision.hatching import direction
from limner.vision.hatching.streamlines import Ground, streamlines
from limner.vision.portrait.seen import Seen
from limner.vision.raster import Image, blurred, resized, whole
from limner.vision.regions import RegionSettings, regions_at
from limner.vision.tonal.chain import Taste, chained
from limner.vision.tonal.ink import near_features
from limner.vision.trace import smooth

SHY = 2e-5
"""How strongly the direction around the head pulls, against a mean squared change of lightness per pixel."""

CLOSEST_PX = 3.0
"""Strokes are never nearer than this: finer than pixels they could not be told apart."""

FINE = 2
"""Strokes are laid in a picture so many times as large."""

SMOOTH = 2.0
"""Takes the pixels out of a line: standard deviation [its points]."""

FEATURES = 0.4
"""Directions on features are averaged over so much of what they are elsewhere."""

TURN = 0.1
"""What half a turn of a link costs [outer-eye distances of its length]."""

LEAST = 0.3
"""Worth of the least stroke that is drawn [outer-eye distances of its length]."""

MORE = 5.0
"""Worth of a line on a feature, besides its length."""

TRIES = 5
"""How often another spacing is tried for the budget."""

ENOUGH = 0.93
"""So much of the budget is used, if there are tries left."""


class _Look(NamedTuple):
    """Wanted ink (H, W), cosine and sine of the strokes' direction (2, H, W), 1 on features (H, W)."""

    ink: Image
    field: Image
    features: Image


@dataclass(frozen=True)
class ScribbleSettings(SettingsGroup):
    """Long strokes along the flow."""

    points: int = setting(3000, "at most so many points where no budget says how many", unit="points", low=2)
    strokes: int = setting(20, "at most so many strokes", low=1, high=10_000)
    widest: float = setting(
        0.16, "where strokes would be farther apart there is none", unit="outer-eye distances", low=0.02, high=1
    )
    smooth: float = setting(
        0.035, "over how far directions are averaged, a deviation", unit="outer-eye distances", low=0.005, high=0.5
    )
    shortest: float = setting(
        0.06, "shorter stretches along the flow are left out", unit="outer-eye distances", low=0.01, high=1
    )
    light: float = setting(3.0, "how much a way over white paper is avoided", low=0, high=100)
    tolerance: float = setting(
        0.004, "a stroke may move by this to have fewer points", unit="outer-eye distances", low=0, high=0.1
    )


def scribble(ink: Image, seen: Seen, face: Face, settings: ScribbleSettings, regions: RegionSettings) -> Strokes:
    """Few long strokes for a picture of wanted ink, the heaviest first.

    Evenly spaced lines along the flow, as far apart as the wanted ink says, are joined to long strokes.

    Args:
        ink: (H, W) >= 0.
        seen: the photo, as the portrait looks at it.
        face: in it.
        settings: how many strokes and points.
        regions: how much a line of each region matters.
    """
    unit = face.outer_eye_px
    size = FINE * ink.shape[1], FINE * ink.shape[0]
    field = np.stack(direction.halved(np.stack([resized(part, size) for part in _directions(seen, face, settings)])))
    look = _Look(resized(ink, size), field, resized(near_features(face, ink.shape), size))
    best: list[Floats] = []
    scale = 0.03 * FINE * unit
    used = 0
    for _ in range(TRIES):
        lines = _strokes(look, scale, FINE * unit, settings)
        points = sum(map(len, lines))
        if used < points <= settings.points:
            best, used = lines, points
        if ENOUGH * settings.points <= points <= settings.points or not points:
            break
        scale *= points / (0.97 * settings.points)
    return _told([(line + 0.5) / FINE - 0.5 for line in best], face, regions, ink.shape)


def _directions(seen: Seen, face: Face, settings: ScribbleSettings) -> Image:
    """Twice the direction of the strokes (2, H, W): around the head where the photo shows none, finer on features."""
    unit, shape = face.outer_eye_px, seen.grey.shape
    base = direction.around_head(face, shape)
    broad = direction.along_strands(seen.grey, base, settings.smooth * unit, SHY)
    narrow = direction.along_strands(seen.grey, broad, FEATURES * settings.smooth * unit, SHY)
    features: Image = narrow + (1 - near_features(face, shape)) * (broad - narrow)
    return features


def _strokes(look: _Look, scale: float, unit: float, settings: ScribbleSettings) -> list[Floats]:
    """Strokes that are ``scale`` pixels apart where the wanted ink is 1."""
    ink, field, features = look
    spacing = spacing_px(ink, scale, settings.widest * unit)
    ground = Ground(field[0], field[1], spacing, np.ones_like(ink), np.zeros(ink.shape, np.uint8))
    lines = [smooth(line, SMOOTH) for line in streamlines(ground, [], settings.shortest * unit)]
    taste = Taste(settings.light, TURN * unit, LEAST * unit)
    long = chained(lines, _worth(lines, features), np.sqrt(np.clip(ink, 0, 1)), settings.strokes, taste)
    return geometry.simplify_all(long, settings.tolerance * unit)


def _worth(lines: list[Floats], features: Image) -> Floats:
    """Length (lines,), which on a feature counts several times."""
    sampled = [np.clip(whole(line), 0, np.array(features.shape[::-1]) - 1) for line in lines]
    share = [float(features[at[:, 1], at[:, 0]].mean()) for at in sampled]
    return np.array([geometry.length(line) for line in lines]) * (1 + MORE * np.array(share))


def spacing_px(ink: Image, scale: float, widest: float) -> Image:
    """Distance (H, W) of strokes for the wanted ink [px]: its inverse; 0 where there are none."""
    calm = blurred(ink, 1.0)
    spacing = scale / np.maximum(calm, np.float32(1e-6))
    # On whole pixels lines come to lie one farther apart than they are told to.
    return np.where(spacing > widest, 0, np.maximum(spacing, CLOSEST_PX) - 1).astype(np.float32)


def _told(lines: list[Floats], face: Face, regions: RegionSettings, shape: tuple[int, ...]) -> Strokes:
    """What each line mostly belongs to, and its weight."""
    importance = np.array([getattr(regions, name) for name in REGIONS])
    names: list[str] = []
    weights: list[float] = []
    for line in lines:
        labels = regions_at(geometry.resample(line, 2.0), face)
        names.append(REGIONS[int(np.bincount(labels).argmax())])
        weights.append(geometry.length(line) / face.outer_eye_px * float(importance[labels].mean()))
    order = np.argsort(-np.array(weights), kind="stable")
    return Strokes(
        tuple(lines[i] for i in order), tuple(names[i] for i in order), np.array(weights)[order], (shape[1], shape[0])
    )
