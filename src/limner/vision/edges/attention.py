"""A face goes in; how closely to look at each pixel, and for lines of which direction, comes out.

Cheeks, forehead and background show shading, not lines; a lid, a lip, a brow or the jaw is a line even where it is
faint, and it runs along the landmarks. So the same ridge counts for more near a feature and along it, and for less
elsewhere. It only bends thresholds: no line is moved or made up.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from limner.types import Face, Floats
from limner.vision.head import (
    BROWS,
    EYES,
    INNER_LIPS,
    JAW,
    LIPS,
    Ellipse,
    Frame,
    face_frame,
    face_outline,
    head_ellipse,
)
from limner.vision.raster import Image, Mask, Shape, blurred, distance_to_lines, filled, whole

SKIN, HAIR, BODY = 0.6, 0.9, 0.5
"""How closely to look where no feature is: within the face, above and beside it, below the chin."""

OUTLINE = 0.9
"""For a line around the head where its outline may be, curls or not."""

ALONG, ACROSS = 1.0, 0.6
"""Added for a line along a feature; taken, as a share, from one across it."""

NOSE = 1.2
"""At the nose, whose wings and bridge run in all directions."""

BELOW_BROWS = -0.12
"""Where what lies above the eyes begins, under the brows' landmarks [outer-eye distances]."""

MOST_GAIN = 2.0
"""More than ``Attention.gain`` ever gives."""

OUTLINES = (*EYES, *BROWS, LIPS, INNER_LIPS, JAW)
"""Landmarks along which lines run."""

REACH, NOSE_REACH = 0.06, 0.12
"""How far from the landmarks a feature is looked for, standard deviation in outer-eye distances: landmarks err."""


@dataclass(frozen=True, eq=False)
class Attention:
    """Where and how to look.

    Attributes:
        skin: (H, W) 1 within the face, 0 outside.
        nose: (H, W) 1 at the nose, falling to 0 away from it.
        along: (2, H, W) cosine and sine of twice the direction of the nearest outline, as long as it is near (0 to 1).
        frame: the upright frame of the face.
        head: the ellipse around the head.
        chin: how far the jaw goes down [outer-eye distances].
    """

    skin: Image
    nose: Image
    along: Image
    frame: Frame
    head: Ellipse
    chin: float

    def gain(self, pixels: NDArray[np.int64], angle_rad: Image, order: Image) -> Floats:
        """What to multiply ridges with.

        Args:
            pixels: (n, 2) their rows and columns.
            angle_rad: (n,) their direction.
            order: (n,) from 0, neighbours run in all directions, to 1, in the same: curls and strands of hair.

        Returns:
            (n,) about 0.2 to 2.
        """
        rows, columns = pixels.T
        place = self.frame.from_photo(pixels[:, ::-1].astype(np.float64))
        skin = self.skin[rows, columns]
        ground = skin * SKIN + (1 - skin) * self._around(place, angle_rad, order)
        cos, sin = self.along[:, rows, columns]
        along = cos * np.cos(2 * angle_rad) + sin * np.sin(2 * angle_rad)
        guided = ground * (1 + ACROSS * np.minimum(along, 0)) + ALONG * np.maximum(along, 0)
        gain: Floats = np.maximum(guided, NOSE * self.nose[rows, columns]).astype(np.float64)
        return gain

    def _around(self, place: Floats, angle_rad: Image, order: Image) -> Floats:
        """Hair within the head's ellipse; beyond it less and less, least for lines that lead away from the head."""
        beyond = self.head.level(place)
        slope = (place - self.head.centre) / self.head.radii**2
        outward = np.arctan2(*(slope @ self.frame.axes_px).T[::-1])
        leads_away = np.cos(angle_rad - outward) ** 2
        hair = HAIR * np.clip(order / 0.7, 0, 1)
        outline = OUTLINE * _ramp(beyond, 0.8, 0.95) * _ramp(-beyond, -1.35, -1.2) * (1 - leads_away)
        hair = np.maximum(hair, outline)
        hair = hair * (1 - 0.7 * _ramp(beyond, 1.0, 1.25) * leads_away) * (1 - 0.5 * _ramp(beyond, 1.2, 1.5))
        body = _ramp(place[:, 1], self.chin, self.chin + 0.05)
        around: Floats = hair * (1 - (1 - BODY) * body)
        return around


def attention_to(face: Face, shape: Shape) -> Attention:
    """Where to look in a photo (H, W) with a frontal face."""
    frame, unit = face_frame(face), face.outer_eye_px
    return Attention(
        skin=_skin(face, shape),
        nose=np.exp(-((distance_to_lines([face.points_px[31:36]], shape) / np.float32(NOSE_REACH * unit)) ** 2)),
        along=_along(face.points_px, shape, REACH * unit),
        frame=frame,
        head=head_ellipse(face),
        chin=float(frame.from_photo(face.points_px[:17])[:, 1].max()),
    )


def above_the_eyes(face: Face, shape: Shape) -> Mask:
    """Which pixels (H, W) belong to the part of the head from the brows upwards."""
    frame, head = face_frame(face), head_ellipse(face)
    brows = frame.from_photo(face.points_px[17:27]) + np.array([0, BELOW_BROWS])
    outline = head.centre + 1.2 * (head.points(40) - head.centre)
    left, right = outline[:, 0].min(), outline[:, 0].max()
    level = max(brows[0, 1], brows[-1, 1])
    upper = outline[outline[:, 1] < level]
    upper = upper[np.argsort(upper[:, 0])]
    region = np.concatenate([upper, [[right, level]], brows[::-1], [[left, level]]])
    return filled(frame.to_photo(region), shape)


def _skin(face: Face, shape: Shape) -> Image:
    """1 (H, W) within the face, 0 outside, softly: where the hair begins the landmarks do not say."""
    mask = filled(face_outline(face), shape).astype(np.float32)
    return blurred(mask, 0.06 * face.outer_eye_px)


def _along(points_px: Floats, shape: Shape, reach: float) -> Image:
    """Twice the direction of the outlines, as a vector, spread by a Gaussian: one on the line, nought away from it."""
    spread = []
    for part in (np.cos, np.sin):
        drawn = np.zeros(shape, np.float32)
        for landmarks in OUTLINES:
            for a, b in pairwise(points_px[landmarks]):
                twice = 2 * np.arctan2(b[1] - a[1], b[0] - a[0])
                cv2.line(drawn, whole(a).tolist(), whole(b).tolist(), (float(part(twice)),))
        spread.append(blurred(drawn, reach) * np.float32(reach * np.sqrt(2 * np.pi)))
    field = np.stack(spread)
    limited: Image = field / np.maximum(np.hypot(*field), np.float32(1))
    return limited


def _ramp(value: Floats, start: float, end: float) -> Floats:
    """0 up to ``start``, rising to 1 at ``end``."""
    return np.clip((value - start) / (end - start), 0, 1)
