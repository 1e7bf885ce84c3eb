"""A photo, its face, figure and lines go in; strokes of hatching that shade the drawing come out (thesis 2.2)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from limner import geometry
from limner.errors import BadInput
from limner.settings import NONE, SettingsGroup, setting
from limner.types import Face, Floats, Photo, Strokes
from limner.vision.edges.iris import find_iris
from limner.vision.figure import Figure
from limner.vision.hatching import direction
from limner.vision.hatching.darkness import darkness, within
from limner.vision.hatching.streamlines import Ground, streamlines
from limner.vision.head import BROWS, EYES, INNER_LIPS, LIPS, face_frame, face_outline
from limner.vision.raster import Image, Mask, blurred, dilated, filled, pieces


class Level(NamedTuple):
    """How much is shaded.

    Attributes:
        from_skin, from_hair, from_body: darkness at which hatching begins.
        widest, closest: spacing of strokes where it begins and where all is dark [outer-eye distances].
        crossed_from: darkness of skin from which a second layer crosses the first.
    """

    from_skin: float
    from_hair: float
    from_body: float
    widest: float
    closest: float
    crossed_from: float


LEVELS = {
    "light": Level(0.45, 0.4, 0.8, 0.13, 0.06, 2.0),
    "medium": Level(0.34, 0.28, 0.55, 0.11, 0.04, 2.0),
    "rich": Level(0.25, 0.16, 0.3, 0.09, 0.027, 0.62),
}
"""From few strokes in the shadows to a full drawing."""

AREAS = ("background", "face", "neck", "hair", "body", "brow", "beard", "lips")
"""Hatching of one does not run on into the next."""

REGION = {
    "face": "face",
    "neck": "body",
    "hair": "hair",
    "body": "body",
    "brow": "brow",
    "beard": "face",
    "lips": "mouth",
}
"""What the strokes of an area belong to."""

KEPT_CLEAR = ("hair", "brow", "face")
"""Regions whose lines hatching keeps off, as it would take their place or cross them."""

FADE = 0.12
"""Over so much darkness the ends of strokes are spread, so that hatching ends like light and not like a wall."""

CALM = {"brow": 0.015, "lips": 0.015, "face": 0.09, "neck": 0.07}
"""Over what tones are averaged, 0.04 elsewhere: wrinkles are lines, not tone [outer-eye distances]."""

BUST = np.array([1.7, 1.15])
"""How far from the chin, aside and below, clothes are shaded [outer-eye distances]."""

DENSER = {"hair": 0.85, "beard": 0.65, "body": 1.3}
"""Spacing against that of skin as dark."""

EYE_ROOM = 0.05
"""How far hatching stays away from the eyes [outer-eye distances]."""

ISLAND = 0.08
"""Shadows on the face smaller than this are left to the lines [square of the outer-eye distance]."""

CROSSING_DEG, CROSSING_SPACING = 40.0, 1.3
"""The second layer's angle to the first, and its spacing against the first's."""

BROW_SPACING = 0.035
"""Spacing in brows, dark at every level [outer-eye distances]."""

PUPIL, PUPIL_SPACING = 0.42, 0.014
"""Radius of the pupil over that of the iris, and spacing of the spiral that fills it [outer-eye distances]."""

WEIGHT = 0.03
"""What a stroke is worth for each outer-eye distance, where all is dark: less than any line, so it is cut first."""


@dataclass(frozen=True)
class ToneSettings(SettingsGroup):
    """Hatching that shades the drawing."""

    level: str = setting(
        NONE,
        "Shading by hatching, from none to a full drawing; nothing in stipple, one-line and scribble",
        choices=(NONE, *LEVELS),
    )
    hatch: str = setting(
        "form", "strokes that follow hair and the form of the face, or all parallel", choices=("form", "parallel")
    )
    angle_deg: float = setting(
        50.0, "direction of parallel strokes, from level, counterclockwise", unit="degrees", low=-180, high=180
    )
    clothes: float = setting(
        0.6, "how dark clothes are drawn, against skin and hair; 0 leaves them white", low=0, high=1
    )
    closest: float = setting(
        0.025, "strokes are never laid closer than this", unit="outer-eye distances", low=0.005, high=1
    )
    shortest: float = setting(0.16, "shorter strokes are left out", unit="outer-eye distances", low=0, high=5)


def hatch(photo: Photo, face: Face, figure: Figure, lines: Strokes, settings: ToneSettings) -> Strokes:
    """Strokes that shade the person, the heaviest first; the background stays white.

    Strokes lie the closer the darker the place is on the person's own scale, follow strands of hair and the form of
    the face, and end, some sooner and some later, where the light begins. Brows and pupils are dark at every level.

    Args:
        photo: at the working scale.
        face: a frontal face in it.
        figure: in it.
        lines: of the drawing, in its pixels; hatching keeps off those in ``KEPT_CLEAR``.
        settings: level and manner.

    Raises:
        BadInput: no such level.
    """
    if settings.level not in LEVELS:
        raise BadInput(f"tone: '{settings.level}' is no level of hatching; choose from {', '.join(LEVELS)}")
    level, unit = LEVELS[settings.level], face.outer_eye_px
    area = areas(face, figure)
    seen = darkness(photo, face, figure)
    dark = _tones(seen, area, face, settings)
    ground = _ground(dark, area, face, _directions(photo, face, seen, area, settings), settings)
    taken = [line for line, region in zip(lines.lines_px, lines.region, strict=True) if region in KEPT_CLEAR]
    strokes = streamlines(ground, taken, settings.shortest * unit)
    if level.crossed_from < 1:
        strokes += streamlines(_crossed(ground, dark, level), [], settings.shortest * unit)
    return _weighed([*strokes, *_pupils(photo, face)], dark, area, face)


def areas(face: Face, figure: Figure) -> NDArray[np.uint8]:
    """The place of each pixel (H, W) in ``AREAS``; eyes and what is between the lips count as background."""
    shape, marks, unit = figure.figure.shape, face.points_px, face.outer_eye_px
    area = np.zeros(shape, np.uint8)
    brows, eyes = np.zeros(shape, bool), np.zeros(shape, bool)
    for brow in BROWS:
        brows |= dilated(_stroke(marks[brow], shape), max(1, round(0.05 * unit)))
    for eye in EYES:
        eyes |= dilated(filled(marks[eye], shape), max(1, round(EYE_ROOM * unit)))
    for name, mask in (
        ("neck", figure.skin),
        ("face", figure.skin & filled(face_outline(face), shape)),
        ("hair", figure.hair),
        ("body", figure.body),
        ("beard", figure.beard),
        ("lips", filled(marks[LIPS], shape)),
        ("background", filled(marks[INNER_LIPS], shape)),
        ("brow", brows & figure.skin),
        ("background", eyes | ~figure.figure),
    ):
        area[mask] = AREAS.index(name)
    return area


def _tones(dark: Image, area: NDArray[np.uint8], face: Face, settings: ToneSettings) -> Image:
    """Darkness (H, W) as it is drawn: calm on skin, with lights in hair and clothes however dark they are."""
    unit, tones = face.outer_eye_px, np.zeros_like(dark)
    for name in AREAS[1:]:
        mask = area == AREAS.index(name)
        if not mask.any():
            continue
        calm = within(dark, mask, CALM.get(name, 0.04) * unit)
        if name in ("hair", "body"):
            low, high = np.percentile(calm[mask], [5, 90])
            calm = calm * (0.6 + 0.4 * np.clip((calm - low) / max(high - low, 0.05), 0, 1))
        if name == "body":
            calm = calm * np.float32(settings.clothes) * _near_neck(face, mask.shape)
        tones[mask] = calm[mask]
    return tones


def _near_neck(face: Face, shape: tuple[int, ...]) -> Image:
    """1 at the neck (H, W), falling to 0 below the shoulders: a bust fades out."""
    frame = face_frame(face)
    place = frame.from_photo(np.moveaxis(np.indices(shape)[::-1], 0, -1).astype(np.float64))
    chin = frame.from_photo(face.points_px[8])
    far = np.hypot(*np.moveaxis((place - chin) / BUST, -1, 0))
    near: Image = np.clip(2.5 * (1 - far), 0, 1).astype(np.float32)
    return near


def _ground(dark: Image, area: NDArray[np.uint8], face: Face, doubled: Image, settings: ToneSettings) -> Ground:
    level, unit = LEVELS[settings.level], face.outer_eye_px
    starts = {
        "hair": level.from_hair,
        "body": level.from_body * settings.clothes,
        "brow": 0.3,
        "beard": level.from_hair,
    }
    start = np.array([2.0, *(starts.get(name, level.from_skin) for name in AREAS[1:])], np.float32)[area]
    depth = np.clip((dark - start) / (1 - start), 0, 1)
    spacing = level.widest * (level.closest / level.widest) ** np.sqrt(depth)
    spacing *= np.array([DENSER.get(name, 1.0) for name in AREAS])[area]
    spacing = np.where(area == AREAS.index("brow"), BROW_SPACING, spacing)
    shaded = (dark > start) & ~_islands((dark > start) & (area == AREAS.index("face")), ISLAND * unit**2)
    spacing = np.where(shaded, unit * np.maximum(spacing, settings.closest), 0).astype(np.float32)
    cos, sin = direction.halved(doubled)
    return Ground(cos, sin, spacing, ((dark - start) / FADE).astype(np.float32), area)


def _islands(mask: Mask, least_px: float) -> Mask:
    """The pieces (H, W) of a mask that are smaller than some number of pixels."""
    _, labels = pieces(mask)
    small: Mask = (np.bincount(labels.ravel()) < least_px)[labels] & mask
    return small


def _directions(photo: Photo, face: Face, dark: Image, area: NDArray[np.uint8], settings: ToneSettings) -> Image:
    """Twice the direction (2, H, W): along strands of hair, bent by the form on skin, straight on clothes."""
    base = direction.parallel(face, settings.angle_deg, area.shape)
    if settings.hatch == "parallel":
        return base
    unit = face.outer_eye_px
    grey = np.asarray(cv2.cvtColor(photo.rgb, cv2.COLOR_RGB2GRAY), np.float32) / np.float32(255)
    strands = direction.along_strands(
        blurred(grey, 0.01 * unit), direction.around_head(face, area.shape), 0.07 * unit, 1e-4
    )
    form = direction.along_strands(blurred(dark, 0.1 * unit), base, 0.2 * unit, 3e-5)
    hairy = np.isin(area, [AREAS.index(name) for name in ("hair", "brow", "beard")])
    return np.where(hairy, strands, np.where(area == AREAS.index("body"), base, form))


def _crossed(ground: Ground, dark: Image, level: Level) -> Ground:
    """A second layer, across the first, where skin is darkest."""
    turn = np.float32(np.deg2rad(CROSSING_DEG))
    cos = ground.cos * np.cos(turn) - ground.sin * np.sin(turn)
    sin = ground.cos * np.sin(turn) + ground.sin * np.cos(turn)
    skin = np.isin(ground.area, [AREAS.index(name) for name in ("face", "neck")])
    dense = ground.spacing * np.float32(CROSSING_SPACING)
    spacing = np.where(skin & (dark > level.crossed_from), dense, 0).astype(np.float32)
    fade = ((dark - level.crossed_from) / FADE).astype(np.float32)
    return Ground(cos, sin, spacing, fade, ground.area)


def _stroke(line: Floats, shape: tuple[int, ...]) -> Mask:
    mask = np.zeros(shape, np.uint8)
    cv2.polylines(mask, [np.rint(line).astype(np.int32)], isClosed=False, color=(1,))
    return mask > 0


def _pupils(photo: Photo, face: Face) -> list[Floats]:
    """A spiral that fills each pupil that is seen."""
    grey = np.asarray(cv2.cvtColor(photo.rgb, cv2.COLOR_RGB2GRAY), np.float32) / np.float32(255)
    discs = [find_iris(grey, face.points_px[eye[:-1]], face.outer_eye_px) for eye in EYES]
    return [_spiral(disc.centre, PUPIL * disc.radius, PUPIL_SPACING * face.outer_eye_px) for disc in discs if disc]


def _spiral(centre: Floats, radius: float, spacing: float) -> Floats:
    turn = np.arange(0, 2 * np.pi * radius / spacing, 0.5)
    out = spacing * turn / (2 * np.pi)
    spiral: Floats = centre + np.stack([out * np.cos(turn), out * np.sin(turn)], axis=1)
    return spiral


def _weighed(strokes: list[Floats], dark: Image, area: NDArray[np.uint8], face: Face) -> Strokes:
    """The strokes with region and weight, the heaviest first."""
    regions, weights = [], []
    height, width = area.shape
    for stroke in strokes:
        column, row = np.clip(np.rint(stroke[len(stroke) // 2]), 0, [width - 1, height - 1]).astype(int)
        regions.append(REGION.get(AREAS[area[row, column]], "eye"))
        tone = float(dark[row, column]) if area[row, column] else 1.0
        weights.append(WEIGHT * geometry.length(stroke) / face.outer_eye_px * tone)
    order = np.argsort(-np.array(weights), kind="stable")
    return Strokes(
        tuple(strokes[i] for i in order), tuple(regions[i] for i in order), np.array(weights)[order], (width, height)
    )
