"""An edge map and a face go in; the edge map without specks, background and body comes out (thesis 3.5)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from limner.settings import SettingsGroup, setting
from limner.types import EdgeMap, Face
from limner.vision.head import EYES, face_frame, head_ellipse
from limner.vision.raster import Image, Mask, Shape, depth, distance_to_zero, pieces, whole

ELLIPSE_POINTS = 40

AT_EYES = 0.06
"""What lies this near to the outline of an eye belongs to it [outer-eye distances]."""


@dataclass(frozen=True)
class TrimSettings(SettingsGroup):
    """Which edges go; pixels are those of the working scale; 0 and false switch a rule off."""

    fewest_px: int = setting(20, "smaller 8-connected pieces are dropped", unit="px", low=0, high=1000)
    near_px: float = setting(
        40.0,
        "pieces farther than this from every landmark and the head ellipse are dropped",
        unit="px",
        low=0,
        high=1000,
    )
    limits: bool = setting(True, "keep only what lies between the ears and above the bottom of the jaw")
    beside_px: float = setting(64.0, "allowance beyond the ears", unit="px", low=0, high=1000)
    below_px: float = setting(24.0, "allowance below the jaw", unit="px", low=0, high=1000)


def trim(edges: EdgeMap, face: Face, settings: TrimSettings) -> EdgeMap:
    """Drop the edges that do not belong to the head.

    The thesis drops pieces farther from every landmark than 0.05 % of the picture's area: 154 px at 640x480, over
    half a face, and little goes. With the 40 points of the head ellipse a third of the outer-eye distance (40 px)
    takes the background and leaves hair, forehead and cheeks.

    Args:
        edges: of a photo at the working scale.
        face: in that photo.
        settings: the rules.
    """
    mask = edges.mask
    if settings.limits:
        mask = mask & _between_the_ears(face, mask.shape, settings)
    if settings.near_px:
        near = _landmark_distance(face, mask.shape) <= settings.near_px
        mask = _keep_pieces(mask, near, 1)
    if settings.fewest_px:
        mask = _keep_pieces(mask, 1 + _at_eyes(face, mask.shape), settings.fewest_px)
    return EdgeMap(mask, edges.strength, edges.angle_rad)


def _between_the_ears(face: Face, shape: Shape, settings: TrimSettings) -> Mask:
    """Right of the left ear, left of the right ear, above the bottom of the jaw, as the face is turned: (H, W)."""
    frame = face_frame(face)
    unit = face.outer_eye_px
    jaw = frame.from_photo(face.points_px[:17])
    low = jaw[:, 0].min() - settings.beside_px / unit
    high = jaw[:, 0].max() + settings.beside_px / unit
    bottom = jaw[:, 1].max() + settings.below_px / unit
    height, width = shape
    across, down = frame.axes_px / unit**2
    y, x = np.arange(height)[:, None] - frame.origin_px[1], np.arange(width) - frame.origin_px[0]
    beside = x * across[0] + y * across[1]
    within: Mask = (beside >= low) & (beside <= high) & (x * down[0] + y * down[1] <= bottom)
    return within


def _keep_pieces(mask: Mask, worth: NDArray[np.generic], least: float) -> Mask:
    """The 8-connected pieces whose pixels are together worth so much."""
    count, labels = pieces(mask)
    pixels = np.nonzero(mask)
    of_pixel = labels[pixels]
    sums = np.bincount(of_pixel, weights=worth[pixels], minlength=count)
    kept = np.zeros_like(mask)
    kept[pixels] = sums[of_pixel] >= least
    return kept


def _at_eyes(face: Face, shape: Shape) -> Mask:
    """Pixels (H, W) at the eyes, which count twice: nothing there is large, and all of it matters."""
    reach = AT_EYES * face.outer_eye_px
    return np.maximum(*(depth(face.points_px[eye], shape, reach) for eye in EYES)) > -reach


def _landmark_distance(face: Face, shape: Shape) -> Image:
    """Distance (H, W) [px] to the nearest of the landmarks and the head ellipse's points.

    Those outside the picture count too, at the nearest pixel of its border.
    """
    points = np.concatenate([face.points_px, face_frame(face).to_photo(head_ellipse(face).points(ELLIPSE_POINTS))])
    height, width = shape
    columns, rows = whole(np.clip(points, 0, [width - 1, height - 1])).T
    empty = np.ones(shape, np.uint8)
    empty[rows, columns] = 0
    return distance_to_zero(empty)
