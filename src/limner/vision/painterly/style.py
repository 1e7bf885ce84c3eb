"""A photo, its face and figure go in; the painting of it comes out, in colours, and as lines of a few pens."""

from __future__ import annotations

import dataclasses

import cv2
import numpy as np
from numpy.typing import NDArray

from limner import geometry
from limner.types import REGIONS, Face, Floats, Photo, Strokes
from limner.vision.figure import Figure
from limner.vision.hatching.darkness import darkness
from limner.vision.hatching.direction import halved
from limner.vision.hatching.streamlines import Ground, streamlines
from limner.vision.head import BROWS, EYES, LIPS, face_outline
from limner.vision.inked import Inked, features, inked
from limner.vision.painterly.brush import SAMPLES, Painting, dab, paint
from limner.vision.painterly.settings import MANNERS, PainterlySettings
from limner.vision.palette import to_lab, to_pens
from limner.vision.raster import Image, Mask, blurred, filled
from limner.vision.regions import RegionSettings, regions_at

FEATURES = [*EYES, *BROWS, LIPS, [27, 31, 32, 33, 34, 35]]

REACH = 0.06
"""How far around the features it is painted as finely [outer-eye distances]."""

HALF = 0.6
"""What a fault counts on hair and clothes, against the face."""

LINE = 0.014
"""Width of a pen's line [outer-eye distances] by which the spacing makes the tone."""

LEAST_INK = 0.12
"""Paper does for what would have less ink."""

SHORTEST = 0.05
"""Shorter lines are left out [outer-eye distances]."""

FADE = 0.1
"""Over so much darkness the ends of lines are spread."""

AGREE = 0.03
"""Over what neighbouring strokes agree on a direction [outer-eye distances]."""

SPOT = 0.8
"""What is darker than this is black."""

SOONER = 0.35
"""By so much sooner on the features."""

AROUND, CRISP = 0.15, 1.5
"""Against what surroundings features are made darker or lighter [outer-eye distances], and how much."""

CALM = 0.015
"""Over what places agree on an ink [outer-eye distances]."""

FINE, ACCENT = 0.02, 0.45
"""Radius of a brush whose strokes are one line [outer-eye distances], and from what darkness they are drawn."""

WEIGHT = 0.2
"""What a line is worth for each outer-eye distance, against an edge in its region."""


def importance(face: Face, shape: tuple[int, ...], settings: PainterlySettings, figure: Mask | None = None) -> Image:
    """How much a fault of the painting counts (H, W): most on the features, least off the figure."""
    unit = face.outer_eye_px
    skin = blurred(filled(face_outline(face), shape).astype(np.float32), 0.1 * unit)
    around = np.full(shape, settings.background, np.float32)
    if figure is not None:
        around += blurred(figure.astype(np.float32), 0.05 * unit) * np.float32(HALF - settings.background)
    marks = features(face.points_px, FEATURES, shape, REACH * unit)
    return np.asarray(np.maximum(around, np.maximum(skin, np.float32(settings.detail) * marks)), np.float32)


def painted(photo: Photo, face: Face, settings: PainterlySettings, figure: Mask | None = None) -> Painting:
    """The painting of a photo: finest on the face's features, coarse off the figure."""
    worth = importance(face, photo.rgb.shape[:2], settings, figure)
    return paint(photo.rgb, worth, MANNERS[settings.manner], face.outer_eye_px, settings.seed)


def painterly_strokes(
    photo: Photo, face: Face, figure: Figure, settings: PainterlySettings, importance: RegionSettings
) -> Strokes:
    """The painting of the figure as lines of a few pens, the heaviest first.

    A brush stroke becomes lines side by side along it, the closer the darker its colour, where no later stroke covers
    it: its width becomes spacing. Where neighbours go one way the lines go on through them. Dark strokes of the finest
    brushes are a line each.

    Args:
        photo: at the working scale.
        face: in it.
        figure: in it; the background stays white.
        settings: the manner, and how many pens.
        importance: of each region.
    """
    painting = painted(photo, face, settings, figure.figure)
    seen = blurred_lab(painting.canvas, 0.03 * face.outer_eye_px)
    dark = darkness(Photo(painting.canvas), face, figure)
    ground = _crisp(inked(seen, figure, dark, settings.pens), face, figure.figure)
    lines, layer = _ruled(painting, ground, figure.figure, face, settings)
    return _weighed(lines, layer, ground, face, importance, photo.size_px)


def _crisp(ground: Inked, face: Face, figure: Mask) -> Inked:
    """With more contrast on the features, and black where it is darkest, there sooner."""
    unit = face.outer_eye_px
    marks = features(face.points_px, FEATURES, figure.shape, 0.03 * unit)
    local = ground.dark - blurred(ground.dark, AROUND * unit)
    dark = np.clip(ground.dark + (np.float32(CRISP) * marks + np.float32(0.3)) * local, 0, 1)
    label = np.where(dark > SPOT - SOONER * marks, 0, ground.label)
    return Inked(ground.inks, label, np.where(figure, dark, 0).astype(np.float32))


def blurred_lab(rgb: NDArray[np.uint8], sigma: float) -> Image:
    """CIELab (H, W, 3) of a blurred picture."""
    return to_lab(np.asarray(cv2.GaussianBlur(rgb, (0, 0), max(sigma, 0.3)), np.uint8))


def _ruled(
    painting: Painting, ground: Inked, figure: Mask, face: Face, settings: PainterlySettings
) -> tuple[list[Floats], list[int]]:
    """Lines along the brush strokes, and the ink of each."""
    unit, shape = face.outer_eye_px, figure.shape
    on_top = _on_top(painting, shape)
    doubled = np.stack([blurred(part, AGREE * unit) for part in _directions(painting, on_top)])
    cos, sin = halved(doubled)
    label = _calm(ground.label, len(ground.inks), CALM * unit)
    where = figure & (ground.dark > LEAST_INK)
    spacing = unit * np.maximum(LINE / np.maximum(ground.dark, np.float32(LEAST_INK)), settings.closest)
    fade = np.clip((ground.dark - LEAST_INK) / FADE, 0, 1).astype(np.float32)
    bed = Ground(cos, sin, np.where(where, spacing, 0).astype(np.float32), fade, (label + 1).astype(np.uint8))
    accents = _accents(painting, ground, np.where(figure, on_top, -1), unit)
    lines = [*accents, *streamlines(bed, accents, SHORTEST * unit)]
    middles = [np.clip(np.rint(line[len(line) // 2]).astype(int), 0, np.array(shape[::-1]) - 1) for line in lines]
    return lines, [int(label[y, x]) for x, y in middles]


def _on_top(painting: Painting, shape: tuple[int, ...]) -> NDArray[np.int32]:
    """Which stroke (H, W) is seen at each place; -1 where none is."""
    on_top = np.full(shape, -1, np.int32)
    for k, (line, radius) in enumerate(zip(painting.lines, painting.radius.tolist(), strict=True)):
        dab(on_top, line, radius, [k])
    return on_top


def _directions(painting: Painting, on_top: NDArray[np.int32]) -> Image:
    """Twice the direction (2, H, W) of the stroke on top of each place, as unit vectors."""
    field = np.zeros((*on_top.shape, 2), np.float32)
    for seen in np.unique(on_top[on_top >= 0]).tolist():
        line, radius = painting.lines[seen], float(painting.radius[seen])
        dash = _at_least_a_dash(line, radius)[::SAMPLES]
        dash = dash if len(dash) > 1 else line[[0, -1]]
        steps = np.diff(dash, axis=0)
        turn = 2 * np.arctan2(steps[:, 1], steps[:, 0])
        for k, double in enumerate(np.stack([np.cos(turn), np.sin(turn)], axis=1).tolist()):
            dab(field, dash[k : k + 2], radius, double)
    return np.moveaxis(field, -1, 0)


def _calm(label: NDArray[np.int64], count: int, sigma: float) -> NDArray[np.int64]:
    """Labels (H, W) without specks."""
    shares = [blurred((label == k).astype(np.float32), sigma) for k in range(count)]
    return np.asarray(np.argmax(shares, axis=0), np.int64)


def _accents(painting: Painting, ground: Inked, on_top: NDArray[np.int32], unit: float) -> list[Floats]:
    """The dark strokes of the finest brushes, which are one line wide."""
    tone = _means(ground.dark, on_top, len(painting.lines))
    fine = (painting.radius <= FINE * unit) & (tone > ACCENT)
    found = [(k, part) for k in np.flatnonzero(fine).tolist() for part in _seen(painting.lines[k], on_top, k)]
    return [part for k, part in found if geometry.length(part) >= SHORTEST * unit]


def _means(image: Image, label: NDArray[np.int32], count: int) -> Floats:
    """Mean (count,) of a picture over the pixels of each label; 0 for none."""
    inside = label >= 0
    pixels = np.bincount(label[inside], minlength=count)
    sums = np.bincount(label[inside], weights=image[inside], minlength=count)
    return np.asarray(sums / np.maximum(pixels, 1), np.float64)


def _at_least_a_dash(line: Floats, radius: float) -> Floats:
    """A dab as a dash as long as it is wide."""
    return line if len(line) > 1 else line + radius * np.array([[-0.75, 0.6], [0.75, -0.6]])


def _seen(line: Floats, on_top: NDArray[np.int32], k: int) -> list[Floats]:
    """The parts of a line where its stroke lies on top."""
    fine = geometry.resample(line, 2.0)
    height, width = on_top.shape
    at = np.rint(fine).astype(int)
    inside = ((at >= 0) & (at < [width, height])).all(axis=1)
    at = np.clip(at, 0, [width - 1, height - 1])
    free = inside & (on_top[at[:, 1], at[:, 0]] == k)
    cuts = np.flatnonzero(np.diff(free.astype(np.int8))) + 1
    parts = zip(np.split(fine, cuts), np.split(free, cuts), strict=True)
    return [part for part, is_free in parts if is_free[0] and len(part) > 1]


def _weighed(
    lines: list[Floats],
    layer: list[int],
    ground: Inked,
    face: Face,
    importance: RegionSettings,
    size_px: tuple[int, int],
) -> Strokes:
    """The strokes with region and weight, the heaviest first."""
    if not lines:
        return Strokes((), (), np.zeros(0), size_px, to_pens(ground.inks))
    middles = np.array([line[len(line) // 2] for line in lines])
    names = [REGIONS[k] for k in regions_at(middles, face)]
    at = np.rint(middles).astype(int)
    lengths = np.array([geometry.length(line) for line in lines]) / face.outer_eye_px
    worth = np.array([getattr(importance, name) for name in names])
    weight = WEIGHT * lengths * worth * ground.dark[at[:, 1], at[:, 0]]
    order = np.argsort(-weight, kind="stable").tolist()
    strokes = Strokes(tuple(lines), tuple(names), weight, size_px, to_pens(ground.inks), np.array(layer, np.int64))
    return dataclasses.replace(
        strokes,
        lines_px=tuple(lines[i] for i in order),
        region=tuple(names[i] for i in order),
        weight=weight[order],
        layer=strokes.layer[order],
    )
