"""A picture of tones goes in; the direction in which its strokes run at each place comes out."""

from __future__ import annotations

import cv2
import numpy as np

from limner.types import Face, Floats
from limner.vision.head import face_frame, head_ellipse
from limner.vision.raster import Image, Shape, blurred


def along_strands(grey: Image, base: Image, sigma: float, shy: float) -> Image:
    """Twice the direction (2, H, W) in which the picture changes least, as unit vectors.

    The eigenvector of the structure tensor (Bigun & Granlund 1987), which the double angle gives without any
    eigenvalues.

    Args:
        grey: (H, W) in [0, 1].
        base: (2, H, W) twice the direction where nothing changes.
        sigma: over how far directions are averaged [px].
        shy: how strongly the base pulls, against a mean squared change of lightness per pixel.
    """
    dx, dy = (np.asarray(cv2.Scharr(grey, cv2.CV_32F, *axes)) / np.float32(32) for axes in ((1, 0), (0, 1)))
    across = np.stack([blurred(dx * dx - dy * dy, sigma), blurred(2 * dx * dy, sigma)])
    return _unit(-across + np.float32(shy) * base)


def around_head(face: Face, shape: Shape) -> Image:
    """Twice the direction (2, H, W) along ellipses about the middle of the head."""
    frame, head = face_frame(face), head_ellipse(face)
    place = frame.from_photo(np.moveaxis(np.indices(shape)[::-1], 0, -1).astype(np.float64))
    out = ((place - head.centre) / head.radii**2) @ frame.axes_px
    return _unit(_doubled(-out[..., 1], out[..., 0]))


def parallel(face: Face, angle_deg: float, shape: Shape) -> Image:
    """Twice one direction (2, H, W) in the frame of the face; 0 is along the eyes, 45 rises to the right."""
    turn = np.deg2rad(angle_deg)
    x, y = np.array([np.cos(turn), -np.sin(turn)]) @ face_frame(face).axes_px
    field = np.broadcast_to(_doubled(np.array(x), np.array(y))[:, None, None], (2, *shape))
    return _unit(np.array(field, np.float32))


def halved(doubled: Image) -> tuple[Image, Image]:
    """Cosine and sine (H, W) each of half the direction."""
    angle = np.arctan2(doubled[1], doubled[0]) / 2
    return np.cos(angle), np.sin(angle)


def _doubled(x: Floats, y: Floats) -> Image:
    field: Image = np.stack([x * x - y * y, 2 * x * y]).astype(np.float32)
    return field


def _unit(field: Image) -> Image:
    unit: Image = field / np.maximum(np.hypot(field[0], field[1]), np.float32(1e-12))
    return unit
