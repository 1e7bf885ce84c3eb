"""A photo, its face and what is drawn already go in; the other lines that belong to the person come out."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from limner.types import REGIONS, Face, Floats
from limner.vision.chains import join_gaps
from limner.vision.edges.flow import Flow
from limner.vision.figure import Figure
from limner.vision.head import face_frame, head_ellipse
from limner.vision.portrait.beard import beard_of
from limner.vision.portrait.grow import Rule, grow
from limner.vision.portrait.hair import beside_hair, clutter, hair_of_head, places
from limner.vision.portrait.marks import Mark
from limner.vision.portrait.seen import Seen
from limner.vision.portrait.settings import PortraitSettings
from limner.vision.raster import Mask, Shape, dilated
from limner.vision.regions import regions_at

Labels = NDArray[np.uint8]

RULES = {
    "eye": Rule(0.03, 0.07, 0.14, 0.04, 0.5, 3),
    "bag": Rule(0.2, 0.35, 0.3, 0.06, 0.4, 4),
    "brow": Rule(0.08, 0.15, 0.25, 0.035, 0.6, 4),
    "nose": Rule(0.025, 0.05, 0.10, 0.05, 0.8, 4),
    "mouth": Rule(0.07, 0.14, 0.2, 0.05, 0.6, 4),
    "jaw": Rule(0.05, 0.10, 0.3, 0.07, 0.8, 6),
    "beard": Rule(0.02, 0.04, 0.12, 0.06, 0.6, 4),
    "ear": Rule(0.04, 0.10, 0.15, 0.04, 0.9, 4),
    "hair": Rule(0.014, 0.025, 0.25, 0.05, 0.8, 8),
    "face": Rule(0.045, 0.09, 0.22, 0.07, 0.8, 5),
    "body": Rule(0.05, 0.12, 0.7, 0.14, 0.8, 8),
    "far": Rule(0.03, 0.12, 0.5, 0.05, 0.7, 8),
    "locks": Rule(0.05, 9, 0.25, 0.05, 0.8, 8),
    "background": Rule(9, 9, 9, 0.05, 0, 0),
}
"""By region, lengths in outer-eye distances. Besides the regions: what hangs under the eyes, beards, hair far from the
head, and locks, which begin as hair of the figure and go on outside of it."""

COARSE = 4
"""Regions are looked up at every so many-th pixel."""

BESIDE = 1.5
"""How far to the side of the face the body is drawn [outer-eye distances]."""

OUTLINE = 0.04
"""How far beyond the figure its outline may be seen [outer-eye distances]."""

FAR = 1.15
"""How far out of the head's ellipse only what is clear is taken for hair."""

UPRIGHT = 0.99
"""Cosine to the vertical from which a line that stands above the eyes, far from the head, is a post."""

ABOVE, CLEAR, NEAR = -0.2, 0.08, 0.9
"""Above this [outer-eye distances under the eyes] a border of the hair weaker than that is none; then what is farther
out of the head's ellipse than so much counts as far."""

AWAY, HANGING = 0.6, 0.5
"""Cosine to the way out of the head from which a line leads away, and to the vertical from which it hangs."""

GAP, GAP_BEND = 0.12, np.deg2rad(30)
"""Ends of two lines of a region that face each other over such a gap [outer-eye distances] are joined."""


def draw_rest(seen: Seen, face: Face, figure: Figure, drawn: Sequence[Mark], settings: PortraitSettings) -> list[Mark]:
    """Lines that go on and are clear, the strongest first, none beside another.

    Args:
        seen: the photo.
        face: in it.
        figure: the person.
        drawn: what is there already.
        settings: how much is drawn.
    """
    unit, names = face.outer_eye_px, list(RULES)
    rules = [_scaled(rule, unit, settings) for rule in RULES.values()]
    hair = names.index("hair")
    rules[hair] = dataclasses.replace(rules[hair], apart=settings.hair_apart * unit)
    labels = _labels(face, seen.grey.shape, names, settings.body)
    if not _clear_outline(seen, face, figure):
        labels[(labels == hair) & (_out_of_the_head(face, labels.shape) > NEAR)] = names.index("far")
    locks, background = names.index("locks"), names.index("background")
    rules[locks] = dataclasses.replace(rules[locks], low=max(rules[locks].low, clutter(seen, face, figure)))
    outside = ~dilated(figure.figure, round(OUTLINE * unit))
    hairy = np.isin(labels, [hair, names.index("far")])
    labels[outside & ~hairy] = background
    labels[outside & hairy] = locks
    away, upright = _leading_away(seen.broad, face)
    labels[np.isin(labels, [locks, names.index("far")]) & away | (labels == locks) & upright] = background
    beard = beard_of(face, figure) & np.isin(labels, [names.index(name) for name in ("face", "jaw", "mouth")])
    labels[beard] = names.index("beard")
    before = [(mark.line, rules[names.index(mark.region)].apart) for mark in drawn]
    grown = grow(seen.both, seen.broad, labels, rules, before)
    of_head, marks = hair_of_head(face, figure), []
    for i, name in enumerate(names):
        lines = [found.line for found in grown if found.rule == i]
        if name in ("hair", "far", "locks"):
            lines = [line for line in lines if beside_hair(line, of_head, unit)]
        for line in join_gaps(lines, GAP * unit, GAP_BEND) if lines else []:
            strength = float(np.median(seen.at(seen.both, line)))
            region = {"bag": "eye", "beard": "face", "far": "hair", "locks": "hair"}.get(name, name)
            marks.append(Mark(line, region, rules[i].worth * float(np.clip(strength / 0.15, 0.3, 1))))
    return marks


def _scaled(rule: Rule, unit: float, settings: PortraitSettings) -> Rule:
    """The rule in pixels and in the strength asked for."""
    return Rule(
        rule.low / settings.detail,
        rule.high / settings.detail,
        rule.shortest * unit,
        rule.apart * unit,
        rule.worth,
        rule.smooth,
    )


def _labels(face: Face, shape: Shape, names: list[str], body: float) -> Labels:
    """Index (H, W) into ``names`` of the region of each pixel."""
    y, x = np.mgrid[0 : shape[0] : COARSE, 0 : shape[1] : COARSE].astype(np.float64) + (COARSE - 1) / 2
    points = np.stack([x.ravel(), y.ravel()], axis=1)
    labels = np.array([names.index(name) for name in REGIONS], np.uint8)[regions_at(points, face)]
    frame = face_frame(face)
    jaw, place = frame.from_photo(face.points_px[:17]), frame.from_photo(points)
    none, hair = names.index("background"), names.index("hair")
    labels[labels == none] = hair  # what is no hair is no figure either
    labels[(labels == hair) & (head_ellipse(face).level(place) > FAR)] = names.index("far")
    eyes = frame.from_photo(face.points_px[36:48])[:, 1].mean()
    labels[(labels == names.index("eye")) & (place[:, 1] > eyes + 0.03)] = names.index("bag")
    low = place[:, 1] > jaw[:, 1].max()
    labels[low & np.isin(labels, [hair, names.index("far")])] = names.index("body")
    aside = np.abs(place[:, 0] - jaw[8, 0]) > BESIDE
    labels[low & ((place[:, 1] > jaw[:, 1].max() + body) | aside)] = none
    return np.asarray(cv2.resize(labels.reshape(x.shape), shape[::-1], interpolation=cv2.INTER_NEAREST), np.uint8)


def _clear_outline(seen: Seen, face: Face, figure: Figure) -> bool:
    """Whether lines run along the border of the hair, or hair was only supposed where none is: on a bald head."""
    border = dilated(figure.hair, 1) & ~figure.figure & (places(face, seen.grey.shape)[..., 1] < ABOVE)
    near = np.asarray(cv2.dilate(seen.coarse, np.ones((7, 7), np.uint8)), np.float32)
    return not border.any() or float(np.median(near[border])) > CLEAR


def _out_of_the_head(face: Face, shape: Shape) -> Floats:
    """How far out of the head's ellipse each pixel (H, W) lies: 1 on it."""
    return head_ellipse(face).level(places(face, shape))


def _leading_away(flow: Flow, face: Face) -> tuple[Mask, Mask]:
    """Where (H, W) lines lead away from the head and do not hang as hair does, and where they stand beside it."""
    frame, head = face_frame(face), head_ellipse(face)
    place = places(face, flow.x.shape)
    slope = (place - head.centre) / head.radii**2 @ frame.axes_px
    slope /= np.maximum(np.hypot(slope[..., 0], slope[..., 1]), 1e-9)[..., None]
    down = frame.axes_px[1] / np.hypot(*frame.axes_px[1])
    outward = np.abs(flow.x * slope[..., 0] + flow.y * slope[..., 1])
    hanging = np.abs(flow.x * down[0] + flow.y * down[1])
    upright = (hanging > UPRIGHT) & (place[..., 1] < 0) & (head.level(place) > FAR)
    away = (outward > AWAY) & (hanging < HANGING)
    return away, upright
