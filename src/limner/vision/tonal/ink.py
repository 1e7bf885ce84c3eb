"""A photo, its face and figure go in; how much ink each place is to get on paper comes out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from limner.settings import SettingsGroup, setting
from limner.types import Face, Photo
from limner.vision.figure import Figure
from limner.vision.hatching.darkness import darkness
from limner.vision.head import BROWS, EYES, LIPS, NOSTRILS, face_frame
from limner.vision.portrait.seen import Seen
from limner.vision.raster import Image, Shape, blurred, distance_to_lines, filled

LOCAL = 0.14
"""Surroundings against which local contrast is measured, standard deviation [outer-eye distances]."""

FLAT = 0.7
"""Ink of what is black all over: what is darker than its surroundings can still be told from it."""

LEAST = 0.07
"""Less ink than this is none: a few lost dots tell nothing."""

SOFT = 0.02
"""Over so much the figure's outline and the borders of its parts are soft [outer-eye distances]."""

FEATURE_REACH = 0.08
"""How far beside its landmarks a feature gets more ink [outer-eye distances]."""

LINE_STRENGTH = 0.25
"""Strength of a dark line that is inked in full, in the unit of ``Seen.both``."""

BUST = np.array([[0.9, 0.15], [1.5, 0.85]])
"""Where, aside of and below the chin, the body begins to fade and has gone [outer-eye distances]."""


@dataclass(frozen=True)
class InkSettings(SettingsGroup):
    """How much ink each place gets in the styles that draw tones: stipple, one-line and scribble."""

    gamma: float = setting(1.2, "ink grows as the darkness to this power; more leaves the skin whiter", low=0.2, high=5)
    contrast: float = setting(1.2, "how much local contrast is raised", low=0, high=5)
    lines: float = setting(0.6, "ink of dark lines, of that of black", low=0, high=5)
    features: float = setting(1.5, "ink of eyes, brows, nose and mouth, against that of skin as dark", low=0.1, high=10)
    hair: float = setting(0.5, "ink of hair, against that of skin as dark", low=0, high=5)
    body: float = setting(0.4, "ink of clothes, against that of skin as dark", low=0, high=5)
    background: float = setting(0.0, "ink of all that is not the person, against that of skin as dark", low=0, high=5)


def wanted_ink(photo: Photo, face: Face, figure: Figure, seen: Seen, settings: InkSettings) -> Image:
    """How much ink each place (H, W) is to get: 0 none, about 1 where the face is darkest.

    The darkness on the person's own scale, its local contrast raised (as an unsharp mask does), and the dark lines;
    more for what a person is known by, less for hair and clothes, nothing for the background.

    Args:
        photo: at the working scale.
        face: in it.
        figure: in it.
        seen: the photo, as the portrait looks at it.
        settings: how much of what.
    """
    unit = face.outer_eye_px
    dark = darkness(photo, face, figure)
    local = dark - blurred(dark, LOCAL * unit)
    tone = np.clip(FLAT * dark + settings.contrast * local, 0, 1) ** settings.gamma
    lines = np.clip(seen.both / LINE_STRENGTH, 0, 1) * settings.lines
    ink = np.clip((np.maximum(tone, lines) - LEAST) / (1 - LEAST), 0, 1)
    wanted: Image = (ink * _parts(face, figure, settings)).astype(np.float32)
    return wanted


def _parts(face: Face, figure: Figure, settings: InkSettings) -> Image:
    """Ink of each part of the picture against that of skin as dark (H, W), its borders soft."""
    share = np.full(figure.figure.shape, settings.background, np.float32)
    share[figure.skin] = 1
    share[figure.hair] = settings.hair
    share[figure.body] = settings.body
    share *= _bust(face, share.shape)
    share = blurred(share, SOFT * face.outer_eye_px)
    emphasis = np.float32(settings.features - 1) * near_features(face, share.shape)
    return np.asarray(share * (1 + emphasis), np.float32)


def _bust(face: Face, shape: Shape) -> Image:
    """1 on the head (H, W), falling to 0 where shoulders and chest are no longer of the portrait."""
    frame = face_frame(face)
    place = frame.from_photo(np.moveaxis(np.indices(shape)[::-1], 0, -1).astype(np.float64))
    chin = frame.from_photo(face.points_px[8])
    aside, below = np.moveaxis(np.abs(place - chin) * [1, 0] + (place - chin) * [0, 1], -1, 0)
    far = [np.clip((end - way) / (end - begin), 0, 1) for way, begin, end in zip((aside, below), *BUST, strict=True)]
    lower = np.clip((below + 0.3) / 0.3, 0, 1)
    bust: Image = np.where(below > 0, far[0] * far[1], 1 - lower * (1 - far[0])).astype(np.float32)
    return bust


def near_features(face: Face, shape: Shape) -> Image:
    """1 on eyes, brows, nostrils and mouth (H, W), falling to 0 beside them."""
    marks = face.points_px
    lines = [marks[one] for one in (*EYES, *BROWS, LIPS, NOSTRILS)]
    distance = distance_to_lines(lines, shape)
    for one in (*EYES, LIPS):
        distance[filled(marks[one], shape)] = 0
    return np.asarray(np.clip(1.5 - distance / np.float32(FEATURE_REACH * face.outer_eye_px), 0, 1), np.float32)
