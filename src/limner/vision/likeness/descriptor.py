"""A small upright picture of a face and its landmarks go in; which edges and dark lines it has where, come out.

Histograms of oriented gradients (Dalal & Triggs 2005, doi:10.1109/CVPR.2005.177) over the face and around each
landmark, in the manner of DAISY (Tola et al. 2010, doi:10.1109/TPAMI.2009.77): a few orientations, each blurred and
sampled. A photo's brow has two edges where a pen draws one line; so the second derivative, which answers to dark lines,
is histogrammed in the same way.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from limner.types import Floats
from limner.vision.likeness.picture import EYES_PX, OUTER_EYE_PX
from limner.vision.raster import Image, blurred

ORIENTATIONS = 6
EDGE_SIGMA_PX, LINE_SIGMA_PX = 1.2, 2.0
"""Gaussians before the first and before the second derivative."""

POOL_SIGMA_PX, GRID_PX, RING_PX = 2.5, 6.0, 9.0
"""How far a place sees; the mesh over the face; how far from a landmark it is looked at."""

LANDMARKS = [17, 19, 21, 22, 24, 26, 27, 30, 31, 33, 35, *range(36, 40), *range(41, 47), 48, 51, 54, 57]
"""Those looked around; not the jaw, on which people and machines disagree."""

_FACE = ((-0.8, 0.8), (-0.55, 1.3))  # x and y of the mesh from between the eyes [outer-eye distances]
_RING = 8  # places around a landmark
_CLIP = 0.3
_LEAST = 0.01
_EVEN_PX, _LEAST_LINE = 8.0, 0.5


def describe(picture: Image, landmarks_px: Floats) -> NDArray[np.float32]:
    """What a face looks like.

    Args:
        picture: (H, W) grey, of ``photo_picture`` or ``drawing_picture``.
        landmarks_px: (68, 2) in it.

    Returns:
        (n,) edges over the face and around the landmarks, then dark lines likewise; all 0 for empty paper.
    """
    parts = []
    for channels in (edges(picture), lines(picture)):
        soft = blurred(channels, POOL_SIGMA_PX)
        parts += [_over_the_face(soft), _around_landmarks(soft, landmarks_px)]
    return np.concatenate(parts)


def describe_landmarks(picture: Image, landmarks_px: Floats) -> NDArray[np.float32]:
    """What a face looks like around each landmark (LANDMARKS, m), edges before dark lines: a part of ``describe``."""
    kinds = (blurred(channels, POOL_SIGMA_PX) for channels in (edges(picture), lines(picture)))
    return np.hstack([_around_landmarks(soft, landmarks_px).reshape(len(LANDMARKS), -1) for soft in kinds])


def landmark_part(descriptor: NDArray[np.float32]) -> NDArray[np.float32]:
    """The part of a whole descriptor (n,) that ``describe_landmarks`` gives (LANDMARKS, m)."""
    kinds = np.split(descriptor, 2)
    around = len(LANDMARKS) * (_RING + 1) * ORIENTATIONS
    return np.hstack([kind[-around:].reshape(len(LANDMARKS), -1) for kind in kinds])


def edges(picture: Image) -> Image:
    """Strength (H, W, ORIENTATIONS) of the gradient along each orientation, dark to light or light to dark."""
    soft = blurred(picture, EDGE_SIGMA_PX)
    x = cv2.Sobel(soft, cv2.CV_32F, 1, 0, ksize=3, scale=1 / 8)
    y = cv2.Sobel(soft, cv2.CV_32F, 0, 1, ksize=3, scale=1 / 8)
    squared = x * x + y * y + 1e-12
    cosine, sine = (x * x - y * y) / squared, 2 * x * y / squared  # of twice the angle
    turn = 2 * _angles()
    near = 0.5 + 0.5 * (cosine[..., None] * np.cos(turn) + sine[..., None] * np.sin(turn))
    return np.asarray(np.sqrt(squared)[..., None] * near**2 * near**2, np.float32)


def lines(picture: Image) -> Image:
    """How much (H, W, ORIENTATIONS) a dark line crosses each orientation, evened out over the picture."""
    soft = blurred(picture, LINE_SIGMA_PX)
    xx = cv2.Sobel(soft, cv2.CV_32F, 2, 0, ksize=3, scale=1 / 4)[..., None]
    yy = cv2.Sobel(soft, cv2.CV_32F, 0, 2, ksize=3, scale=1 / 4)[..., None]
    xy = cv2.Sobel(soft, cv2.CV_32F, 1, 1, ksize=3, scale=1 / 4)[..., None]
    cosine, sine = np.cos(_angles()), np.sin(_angles())
    dark = np.maximum(cosine**2 * xx + sine**2 * yy + 2 * cosine * sine * xy, 0)
    around = blurred(np.asarray((dark * dark).mean(axis=-1), np.float32), _EVEN_PX)
    return np.asarray(dark / np.sqrt(around + _LEAST_LINE**2)[..., None], np.float32)


def _angles() -> NDArray[np.float32]:
    return (np.arange(ORIENTATIONS) * np.pi / ORIENTATIONS).astype(np.float32)


def _over_the_face(channels: Image) -> NDArray[np.float32]:
    """Histograms on a mesh, each over its neighbourhood's strength, so that faint shadows count as hard ones do."""
    x, y = (np.arange(low * OUTER_EYE_PX, high * OUTER_EYE_PX + 1, GRID_PX) for low, high in _FACE)
    places = np.stack(np.meshgrid(x + EYES_PX[0], y + EYES_PX[1]), axis=-1)
    values = _sampled(channels, places)
    energy = cv2.blur((values**2).sum(axis=-1), (3, 3), borderType=cv2.BORDER_REPLICATE)
    even = values / (np.sqrt(np.maximum(energy, 0))[..., None] + _LEAST)
    return np.asarray(np.minimum(even, _CLIP).ravel() / np.sqrt(x.size * y.size), np.float32)


def _around_landmarks(channels: Image, landmarks_px: Floats) -> NDArray[np.float32]:
    turn = 2 * np.pi * np.arange(_RING) / _RING
    ring = np.concatenate([[[0, 0]], RING_PX * np.stack([np.cos(turn), np.sin(turn)], axis=1)])
    values = _sampled(channels, landmarks_px[LANDMARKS][:, None] + ring).reshape(len(LANDMARKS), -1)
    even = values / (np.linalg.norm(values, axis=1, keepdims=True) + _LEAST)
    return np.asarray(np.minimum(even, _CLIP).ravel() / np.sqrt(len(LANDMARKS)), np.float32)


def _sampled(channels: Image, places: Floats) -> NDArray[np.float32]:
    """Channels at places (..., 2) x, y between pixels; the border goes on outside."""
    height, width = channels.shape[:2]
    x, y = np.clip(places[..., 0], 0, width - 1.001), np.clip(places[..., 1], 0, height - 1.001)
    column, row = x.astype(np.int64), y.astype(np.int64)
    right, down = (x - column)[..., None].astype(np.float32), (y - row)[..., None].astype(np.float32)
    upper = channels[row, column] * (1 - right) + channels[row, column + 1] * right
    lower = channels[row + 1, column] * (1 - right) + channels[row + 1, column + 1] * right
    return np.asarray(upper * (1 - down) + lower * down, np.float32)
