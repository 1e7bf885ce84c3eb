"""Lines and a face go in; the part of the head that each line draws, and how much it matters, come out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from limner import geometry
from limner.settings import SettingsGroup, setting
from limner.types import REGIONS, EdgeMap, Face, Floats
from limner.vision.head import BROWS, EYES, LIPS, NOSTRILS, face_frame, face_outline, head_ellipse, inside

Labels = NDArray[np.uint8]

NEAR = 0.08
"""How far from its landmarks a line still belongs to a feature [outer-eye distances]: lid creases, the brow's hairs."""

HAIR_LEVEL = 1.35
"""How far out of the head's ellipse hair may stand, before a line belongs to the background."""


@dataclass(frozen=True)
class RegionSettings(SettingsGroup):
    """How much a line of the same length and strength matters; what matters most is kept when points are few."""

    eye: float = setting(12.0, "lids, iris, creases", low=0, high=1000)
    brow: float = setting(8.0, "brows", low=0, high=1000)
    nose: float = setting(6.0, "nose", low=0, high=1000)
    mouth: float = setting(8.0, "lips", low=0, high=1000)
    jaw: float = setting(4.0, "outline of the face from ear to ear", low=0, high=1000)
    ear: float = setting(1.5, "ears", low=0, high=1000)
    hair: float = setting(1.5, "hair and outline of the head", low=0, high=1000)
    face: float = setting(1.5, "skin between the features: folds, wrinkles, beard", low=0, high=1000)
    body: float = setting(0.5, "neck and clothes", low=0, high=1000)
    background: float = setting(0.2, "all else", low=0, high=1000)


def regions_and_weights(
    lines: Sequence[Floats], edges: EdgeMap, face: Face, settings: RegionSettings
) -> tuple[tuple[str, ...], Floats]:
    """The region in which most of each line lies, and its weight.

    The weight is the length in outer-eye distances, each part of it times the importance of the region it lies in and
    the strength of the edge there.

    Args:
        lines: polylines (n, 2) [px] of the edge map.
        edges: where they come from.
        face: in the same pixels.
        settings: importance of each region.

    Returns:
        A name out of ``REGIONS`` for each line, and the weights (lines,).
    """
    names: list[str] = []
    weights = np.zeros(len(lines))
    if not lines:
        return (), weights
    strength = cv2.dilate(edges.strength, np.ones((3, 3), np.uint8))  # smoothing may have moved a line by a pixel
    importance = np.array([getattr(settings, name) for name in REGIONS])
    parts = [geometry.resample(line, 2.0) for line in lines]
    points = np.concatenate(parts)
    labels = regions_at(points, face)
    columns, rows = np.rint(np.clip(points, 0, np.array(strength.shape[::-1]) - 1)).astype(np.int64).T
    worth = importance[labels] * strength[rows, columns]
    ends = np.cumsum([len(part) for part in parts])
    for i, (line, start, end) in enumerate(zip(lines, [0, *ends], ends, strict=False)):
        names.append(REGIONS[int(np.bincount(labels[start:end]).argmax())])
        weights[i] = geometry.length(line) / face.outer_eye_px * worth[start:end].mean()
    return tuple(names), weights


def regions_at(points_px: Floats, face: Face) -> Labels:
    """What each point belongs to.

    Args:
        points_px: (n, 2) in the photo of the face.
        face: a frontal one.

    Returns:
        (n,) places in ``REGIONS``.
    """
    frame, head = face_frame(face), head_ellipse(face)
    place, marks = frame.from_photo(points_px), frame.from_photo(face.points_px)
    jaw, brows = marks[:17], marks[17:27]
    beside = np.maximum(jaw[:, 0].min() - place[:, 0], place[:, 0] - jaw[:, 0].max())
    below_chin = place[:, 1] > jaw[:, 1].max()
    labels = np.full(len(place), REGIONS.index("background"), np.uint8)
    for name, where in (
        ("hair", (head.level(place) < HAIR_LEVEL) | (np.abs(beside) < 0.3)),
        ("body", below_chin & (beside < 0.6)),
        ("ear", (beside > -0.05) & (beside < 0.25) & (place[:, 1] > brows[:, 1].mean()) & (place[:, 1] < jaw[3, 1])),
        ("face", inside(place, frame.from_photo(face_outline(face)))),
        ("jaw", _distance(place, jaw) < NEAR),
        ("nose", inside(place, marks[[27, 31, 32, 33, 34, 35]]) | (_distance(place, marks[NOSTRILS]) < NEAR)),
        ("mouth", inside(place, marks[48:60]) | (_distance(place, marks[LIPS]) < NEAR)),
        ("brow", np.minimum(*(_distance(place, marks[brow]) for brow in BROWS)) < NEAR),
        ("eye", np.minimum(*(_distance(place, marks[eye]) for eye in EYES)) < NEAR),
    ):
        labels[where] = REGIONS.index(name)
    return labels


def _distance(points: Floats, line: Floats) -> Floats:
    """Distance (n,) of points to a polyline."""
    nearest: Floats = np.min([geometry.distance_to_segments(points, a, b) for a, b in pairwise(line)], axis=0)
    return nearest
