"""An edge map and a face go in; the edge map without specks, background and body comes out (thesis 3.5)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from limner.settings import SettingsGroup, names_in, setting
from limner.types import EdgeMap, Face, Floats
from limner.vision.head import EYES, face_frame, head_ellipse
from limner.vision.raster import Mask, Shape, depth, distance_to_zero, keep_pieces, whole

ELLIPSE_POINTS = 40

AT_EYES = 0.06
"""What lies this near to the outline of an eye belongs to it [outer-eye distances]."""


@dataclass(frozen=True)
class TrimSettings(SettingsGroup):
    """Which edges go; pixels are those of the working scale."""

    by: str = setting(
        "rectangle,distance,length",
        "rules, one after the other, joined by commas: rectangle = around the face, distance = to the landmarks and the"
        " head's ellipse, boxes = on them, length = of connected pieces; or none",
    )
    beside_px: float = setting(64.0, "rectangle: allowance beyond the ears", unit="px", low=0, high=1000)
    below_px: float = setting(24.0, "rectangle: allowance below the jaw", unit="px", low=0, high=1000)
    near_px: float = setting(
        40.0,
        "distance: pieces farther than this from every landmark and the head ellipse are dropped",
        unit="px",
        low=0,
        high=1000,
    )
    box_px: float = setting(10.0, "boxes: side of each; pieces that touch none are dropped", unit="px", low=1, high=500)
    box_cut: bool = setting(False, "boxes: what lies outside them goes as well")
    fewest_px: int = setting(20, "length: smaller 8-connected pieces are dropped", unit="px", low=0, high=1000)

    def __post_init__(self) -> None:
        super().__post_init__()
        names_in(self.by, RULES, "trim.by")


def trim(edges: EdgeMap, face: Face, settings: TrimSettings) -> EdgeMap:
    """Drop the edges that do not belong to the head.

    Args:
        edges: of a photo at the working scale.
        face: in that photo.
        settings: the rules.
    """
    mask = edges.mask
    for name in names_in(settings.by, RULES, "trim.by"):
        mask = RULES[name](mask, face, settings)
    return EdgeMap(mask, edges.strength, edges.angle_rad)


def head_points(face: Face) -> Floats:
    """The landmarks, and 40 points on the ellipse around the head, as the landmarks end at the brows: (n, 2)."""
    return np.concatenate([face.points_px, face_frame(face).to_photo(head_ellipse(face).points(ELLIPSE_POINTS))])


def rectangle(mask: Mask, face: Face, settings: TrimSettings) -> Mask:
    """What lies right of the left ear, left of the right ear and above the bottom of the jaw, as the face is turned."""
    frame, unit = face_frame(face), face.outer_eye_px
    jaw = frame.from_photo(face.points_px[:17])
    low = jaw[:, 0].min() - settings.beside_px / unit
    high = jaw[:, 0].max() + settings.beside_px / unit
    bottom = jaw[:, 1].max() + settings.below_px / unit
    height, width = mask.shape
    across, down = frame.axes_px / unit**2
    y, x = np.arange(height)[:, None] - frame.origin_px[1], np.arange(width) - frame.origin_px[0]
    beside = x * across[0] + y * across[1]
    within: Mask = (beside >= low) & (beside <= high) & (x * down[0] + y * down[1] <= bottom)
    return mask & within


def distance(mask: Mask, face: Face, settings: TrimSettings) -> Mask:
    """The pieces that come near to a landmark or to the head's ellipse.

    The thesis drops pieces farther from every landmark than 0.05 % of the picture's area: 154 px at 640x480, over
    half a face, and little goes. With the points of the ellipse a third of the outer-eye distance (40 px) takes the
    background and leaves hair, forehead and cheeks. Points outside the picture count at its nearest pixel.
    """
    height, width = mask.shape
    columns, rows = whole(np.clip(head_points(face), 0, [width - 1, height - 1])).T
    empty = np.ones(mask.shape, np.uint8)
    empty[rows, columns] = 0
    return keep_pieces(mask, distance_to_zero(empty) <= settings.near_px, 1)


def boxes(mask: Mask, face: Face, settings: TrimSettings) -> Mask:
    """The pieces that touch a box on a landmark or on a point of the head's ellipse, or what lies in the boxes."""
    inside = in_boxes(face, mask.shape, settings)
    return mask & inside if settings.box_cut else keep_pieces(mask, inside, 1)


def in_boxes(face: Face, shape: Shape, settings: TrimSettings) -> Mask:
    """Pixels (H, W) in the boxes on the landmarks and the head's ellipse (figure 3.12)."""
    inside = np.zeros(shape, bool)
    points, reach = head_points(face), settings.box_px / 2
    limits = np.array(shape[::-1])
    lows = np.clip(np.ceil(points - reach), 0, limits).astype(int)
    highs = np.clip(np.floor(points + reach) + 1, 0, limits).astype(int)
    for (x0, y0), (x1, y1) in zip(lows, highs, strict=True):
        inside[y0:y1, x0:x1] = True
    return inside


def length(mask: Mask, face: Face, settings: TrimSettings) -> Mask:
    """The pieces of enough pixels; those at the eyes count twice: nothing there is large, and all of it matters."""
    return keep_pieces(mask, 1 + _at_eyes(face, mask.shape), settings.fewest_px)


RULES: dict[str, Callable[[Mask, Face, TrimSettings], Mask]] = {
    "rectangle": rectangle,
    "distance": distance,
    "boxes": boxes,
    "length": length,
}
"""Each takes edges (H, W), the face in them and the settings, and gives a part of the edges."""


def _at_eyes(face: Face, shape: Shape) -> Mask:
    """Pixels (H, W) at the eyes."""
    reach = AT_EYES * face.outer_eye_px
    return np.maximum(*(depth(face.points_px[eye], shape, reach) for eye in EYES)) > -reach
