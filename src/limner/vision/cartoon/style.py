"""A photo, its face and figure go in; the strokes of a cartoon in a few inks come out, and its picture."""

from __future__ import annotations

import numpy as np

from limner import geometry
from limner.types import REGIONS, EdgeMap, Face, Floats, Photo, Strokes
from limner.vision.cartoon.abstraction import Abstraction, abstract
from limner.vision.cartoon.settings import CartoonSettings
from limner.vision.cartoon.tones import borders, hatching
from limner.vision.edges.fdog import coherent_lines
from limner.vision.edges.flow import edge_flow
from limner.vision.figure import Figure
from limner.vision.hatching.darkness import darkness
from limner.vision.head import BROWS, EYES, LIPS
from limner.vision.inked import Inked, features, inked
from limner.vision.palette import to_pens
from limner.vision.raster import dilated
from limner.vision.regions import RegionSettings, regions_at

FEATURES = [*EYES, *BROWS, LIPS, [27, 31, 32, 33, 34, 35]]

BY_LANDMARKS = ("eye", "brow", "nose", "mouth", "jaw")
"""Regions whose lines are drawn along the landmarks instead of along the edges of the picture."""

REACH = 0.08
"""How far around the features less is smoothed [outer-eye distances]."""

BORDER_WEIGHT, FILL_WEIGHT = 0.25, 0.04
"""What a stroke of a border and of hatching is worth against an edge in its region."""

WIDTH_PX, ALONG_PX, FLOW_PX = 1.1, 5.0, 3.0
"""Of the edges that are drawn, at the working scale."""


def abstracted(photo: Photo, face: Face, settings: CartoonSettings) -> Abstraction:
    """The picture made simple, less so where the face has its features."""
    unit = face.outer_eye_px
    detail = features(face.points_px, FEATURES, photo.rgb.shape[:2], REACH * unit)
    return abstract(photo.rgb, settings.abstraction, unit, detail)


def cartoon_edges(made: Abstraction, figure: Figure, settings: CartoonSettings) -> EdgeMap:
    """The edges of the figure, followed along the flow, so that they go on."""
    light = np.ascontiguousarray(made.smooth[..., 0])
    flow = edge_flow(light, 1.0, FLOW_PX)
    along = coherent_lines(light, flow, WIDTH_PX, ALONG_PX)
    strength = np.tanh(along * np.float32(settings.abstraction.edge_sharp) * 0.8)
    strength *= dilated(figure.figure, 3)
    angle = np.mod(flow.angle_rad, np.pi).astype(np.float64)
    return EdgeMap(strength > settings.edge, strength.astype(np.float64), np.where(angle >= np.pi, 0.0, angle))


def with_features(edges: Strokes, known: Strokes) -> Strokes:
    """The edges without those of the features, and the features of another drawing of the same face."""
    parts = [
        (strokes, [i for i, region in enumerate(strokes.region) if (region in BY_LANDMARKS) == wanted])
        for strokes, wanted in ((known, True), (edges, False))
    ]
    return Strokes(
        tuple(strokes.lines_px[i] for strokes, some in parts for i in some),
        tuple(strokes.region[i] for strokes, some in parts for i in some),
        np.concatenate([strokes.weight[some] for strokes, some in parts]),
        edges.size_px,
    )


def cartoon_strokes(
    made: Abstraction,
    edges: Strokes,
    seen: tuple[Photo, Face, Figure],
    settings: CartoonSettings,
    importance: RegionSettings,
) -> Strokes:
    """Edges in black, borders and tones in the inks of the picture, the heaviest first.

    Args:
        made: the picture made simple, at the working scale.
        edges: its edges, traced, and the features.
        seen: photo, face and figure at that scale.
        settings: of the cartoon.
        importance: of each region.
    """
    photo, face, figure = seen
    unit = face.outer_eye_px
    dark = darkness(photo, face, figure)
    ground = inked(made.smooth, figure, dark, settings.pens)
    drawn = borders(ground, figure.figure, edges.lines_px, unit, settings.borders) if settings.borders else []
    filled = hatching(_off_eyes(ground, face), unit, settings) if settings.fill else []
    lines = [*edges.lines_px, *(line for line, _ in drawn + filled)]
    regions, weights = _weighed(drawn, BORDER_WEIGHT, face, importance)
    more, lighter = _weighed(filled, FILL_WEIGHT, face, importance)
    layer = np.array([0] * len(edges.lines_px) + [ink for _, ink in drawn + filled], np.int64)
    weight = np.concatenate([edges.weight, weights, lighter])
    named = (*edges.region, *regions, *more)
    order = np.argsort(-weight, kind="stable").tolist()
    return Strokes(
        tuple(lines[i] for i in order),
        tuple(named[i] for i in order),
        weight[order],
        photo.size_px,
        to_pens(ground.inks),
        layer[order],
    )


def _off_eyes(ground: Inked, face: Face) -> Inked:
    """No hatching over the eyes, which lines draw."""
    clear = features(face.points_px, list(EYES), ground.dark.shape, 0.01 * face.outer_eye_px) > 0.3
    return Inked(ground.inks, ground.label, np.where(clear, np.float32(0), ground.dark))


def _weighed(
    strokes: list[tuple[Floats, int]], share: float, face: Face, importance: RegionSettings
) -> tuple[list[str], Floats]:
    """The region of each stroke's middle, and its weight by length."""
    if not strokes:
        return [], np.zeros(0)
    middles = np.array([line[len(line) // 2] if len(line) > 2 else line.mean(axis=0) for line, _ in strokes])
    names = [REGIONS[k] for k in regions_at(middles, face)]
    lengths = np.array([geometry.length(line) for line, _ in strokes]) / face.outer_eye_px
    worth = np.array([max(getattr(importance, name), 1.0) for name in names])
    return names, share * lengths * np.minimum(worth, 4.0)
