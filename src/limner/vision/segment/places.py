"""A face goes in; how likely skin, hair, clothes and background are at each place comes out, colours unseen."""

from __future__ import annotations

import cv2
import numpy as np

from limner.types import Face, Floats
from limner.vision.head import EYES, JAW, LIPS, face_frame, face_outline, head_ellipse
from limner.vision.raster import Image, Mask, Shape, depth, dilated, filled

HAIR_LEVELS, HAIR_THERE = (0.75, 0.9, 1.0, 1.15, 1.5, 2.2), (0.97, 0.8, 0.5, 0.3, 0.2, 0.05)
"""How far out of the head's ellipse, and how likely hair or a hat is there."""

BODY_DEPTHS, BODY_THERE = (-0.9, -0.3, 0.0, 0.2, 0.6), (0.0, 0.12, 0.5, 0.93, 0.995)
"""How far below the usual line of neck and shoulders, and how likely the body is there."""

FRINGE = 0.3
"""How likely hair falls into the forehead."""

GROUND = 4.0
"""Log odds of the background where its smooth ground was surely reached."""

LEAST = 0.003
"""No part is quite impossible anywhere, but inside the face."""


def likely_places(face: Face, shape: Shape) -> Image:
    """How likely background, skin, hair and body are (4, H, W) at each pixel, summing to one.

    Hats and scarves on the head count as hair, clothes as body.

    Args:
        face: a frontal face, in pixels of the picture.
        shape: of the picture.
    """
    frame, head = face_frame(face), head_ellipse(face)
    place = frame.from_photo(np.moveaxis(np.indices(shape)[::-1], 0, -1).astype(np.float64))
    jaw = frame.from_photo(face.points_px[JAW])
    out = place - [jaw[[0, 16], 0].mean(), jaw[:, 1].max()]
    level, aside, below = head.level(place), np.abs(out[..., 0]), out[..., 1]
    beside = aside - np.ptp(jaw[:, 0]) / 2
    deep = depth(face_outline(face), shape, 0.5 * face.outer_eye_px).astype(np.float64) / face.outer_eye_px
    brows = frame.from_photo(face.points_px[17:27])[:, 1].min()
    inner = _ramp(deep, -0.12, 0.12) * (1 - FRINGE * _ramp(brows - place[..., 1], 0.1, 0.3))
    ears = 0.5 * _ramp(-beside, -0.22, -0.1) * _ramp(below, -1.25, -1.1) * _ramp(-below, 0.4, 0.6)
    neck = 0.75 * _ramp(-aside, -0.75, -0.5) * _ramp(below, -0.5, -0.3) * _ramp(-below, -0.9, -0.3)
    skin = np.maximum.reduce([0.97 * inner, ears, neck])
    around = np.interp(level, HAIR_LEVELS, HAIR_THERE) * _ramp(-below, -0.4, 0.1)
    falling = 0.3 * _ramp(-aside - 0.6 * below, -1.4, -0.8) * _ramp(below, -1.2, -0.8) * _ramp(-below, -1.3, 0)
    hair = np.maximum(around, falling)
    body = np.interp(below - _shoulders(aside), BODY_DEPTHS, BODY_THERE)
    return _shares(skin, hair, body)


def with_ground(likely: Image, ground: Image) -> Image:
    """The same (4, H, W) once it is known how surely (H, W) the ground was reached."""
    surer = likely.copy()
    surer[0] *= np.exp(GROUND * ground * np.maximum(1 - 2 * likely[3], 0))
    result: Image = surer / surer.sum(axis=0)
    return result


def inside_face(face: Face, shape: Shape) -> Mask:
    """Pixels (H, W) within the hull of the landmarks: skin, whatever their colour."""
    hull = cv2.convexHull(face.points_px.astype(np.float32))[:, 0]
    return filled(np.asarray(hull, np.float64), shape)


def features(face: Face, shape: Shape) -> Mask:
    """Pixels (H, W) of eyes and lips, whose colours say nothing about skin."""
    mask = np.zeros(shape, bool)
    for landmarks in (*EYES, LIPS):
        mask |= filled(face.points_px[landmarks], shape)
    return dilated(mask, max(1, round(0.04 * face.outer_eye_px)))


def above_eyes(face: Face, shape: Shape) -> Image:
    """1 above the forehead (H, W), falling to 0 at the eyes: where the background shows itself most surely."""
    frame = face_frame(face)
    place = frame.from_photo(np.moveaxis(np.indices(shape)[::-1], 0, -1).astype(np.float64))
    return _ramp(-place[..., 1], 0.0, 1.0).astype(np.float32)


def _shoulders(aside: Floats) -> Floats:
    """How far below the chin the upper outline of neck and shoulders runs, this far aside of it."""
    line: Floats = np.interp(aside, [0, 0.45, 0.6, 1.0, 1.5, 2.2, 3.0], [-0.2, 0.1, 0.35, 0.55, 0.75, 1.1, 1.9])
    return line


def _shares(skin: Floats, hair: Floats, body: Floats) -> Image:
    """Skin covers hair, hair covers clothes, and all three the background."""
    shares = [(1 - skin) * (1 - hair) * (1 - body), skin, (1 - skin) * hair, (1 - skin) * (1 - hair) * body]
    likely = np.stack(shares) + LEAST
    result: Image = (likely / likely.sum(axis=0)).astype(np.float32)
    return result


def _ramp(value: Floats, start: float, end: float) -> Floats:
    return np.clip((value - start) / (end - start), 0, 1)
