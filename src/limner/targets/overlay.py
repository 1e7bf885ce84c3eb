"""A photo and its faces go in; the photo with their landmarks drawn over it comes out."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from limner.errors import BadInput
from limner.types import Face, Floats, Photo

Rgb = tuple[int, int, int]

_JAW, _BROW, _NOSE, _EYE, _MOUTH = (255, 209, 102), (200, 160, 255), (120, 230, 160), (80, 200, 255), (255, 130, 150)

# First and last point (iBUG-68), whether the curve closes, its colour.
_CURVES: tuple[tuple[int, int, bool, Rgb], ...] = (
    (0, 16, False, _JAW),
    (17, 21, False, _BROW),
    (22, 26, False, _BROW),
    (27, 30, False, _NOSE),
    (31, 35, False, _NOSE),
    (36, 41, True, _EYE),
    (42, 47, True, _EYE),
    (48, 59, True, _MOUTH),
    (60, 67, True, _MOUTH),
)
_SHADE: Rgb = (20, 24, 32)
_BOX: Rgb = (255, 255, 255)

# In parts of the face's size, which is about its outer-eye distance.
_LINE, _DOT, _TAG = 0.012, 0.02, 0.22
_SHIFT = 4
_LARGEST_PX = 100_000_000


def overlay(photo: Photo, faces: Sequence[Face], scale: float = 1.0) -> NDArray[np.uint8]:
    """Draw a curve through each feature's landmarks and a dot on each; several faces get a box and their number.

    Lines and dots grow with the face. A profile, which has other landmarks, gets the dots only.

    Args:
        photo: the picture.
        faces: in it; they are numbered as they stand, from 1.
        scale: of the result against the photo.

    Returns:
        (H, W, 3) uint8 RGB.

    Raises:
        BadInput: the scale is not positive, or makes the picture absurdly large.
    """
    image = _scaled(photo, scale)
    for face in faces:
        _draw_face(image, (face.points_px + 0.5) * scale - 0.5, _size_px(face) * scale)
    if len(faces) > 1:
        for number, face in enumerate(faces, 1):
            image = _tagged(image, face.box_px * scale, str(number), _size_px(face) * scale)
    return image


def _scaled(photo: Photo, scale: float) -> NDArray[np.uint8]:
    import cv2

    width, height = photo.size_px
    if not (scale > 0 and width * height * scale**2 <= _LARGEST_PX):
        raise BadInput(
            f"overlay: {width} x {height} px scaled by {scale:g}; expected 1 px to {_LARGEST_PX // 10**6} MP"
        )
    if scale == 1:
        return photo.rgb.copy()
    size = max(1, round(width * scale)), max(1, round(height * scale))
    image = cv2.resize(photo.rgb, size, interpolation=cv2.INTER_AREA if scale < 1 else cv2.INTER_CUBIC)
    return np.ascontiguousarray(image, dtype=np.uint8)


def _size_px(face: Face) -> float:
    """About the outer-eye distance, also of a profile: a face's box is about twice as wide."""
    return float(np.hypot(*(face.box_px[2:] - face.box_px[:2]))) / 3


def _draw_face(image: NDArray[np.uint8], points: Floats, size: float) -> None:
    import cv2

    line, dot = max(1, round(size * _LINE)), max(1.2, size * _DOT)
    curves = (
        [(_curve(points[a : b + 1], closed), color) for a, b, closed, color in _CURVES] if len(points) == 68 else []
    )
    colors = _point_colors(len(points))

    def draw(target: NDArray[np.uint8], grow: float, shade: Rgb | None) -> None:
        for curve, color in curves:
            cv2.polylines(target, [_fixed(curve)], False, shade or color, line + 2 * round(grow), cv2.LINE_AA, _SHIFT)
        for place, color in zip(_fixed(points).tolist(), colors, strict=True):
            radius = round((dot + grow) * 2**_SHIFT)
            cv2.circle(target, place, radius, shade or (255, 255, 255), cv2.FILLED, cv2.LINE_AA, _SHIFT)
            if shade is None:
                cv2.circle(target, place, round(radius * 0.6), color, cv2.FILLED, cv2.LINE_AA, _SHIFT)

    # A half transparent dark rim keeps the colours apart from any skin.
    shaded = image.copy()
    draw(shaded, max(1.0, line * 0.5), _SHADE)
    cv2.addWeighted(shaded, 0.45, image, 0.55, 0, image)
    draw(image, 0, None)


def _point_colors(count: int) -> list[Rgb]:
    if count != 68:
        return [_EYE] * count
    return [color for a, b, _, color in _CURVES for _ in range(a, b + 1)]


def _curve(points: Floats, closed: bool, steps: int = 12) -> Floats:
    """A smooth curve through the points (Catmull & Rom 1974, uniform)."""
    ends = (points[-1:], points[:2]) if closed else (2 * points[:1] - points[1:2], 2 * points[-1:] - points[-2:-1])
    p = np.concatenate([ends[0], points, ends[1]])
    t = np.linspace(0, 1, steps, endpoint=False)[:, None]
    pieces = [
        0.5 * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t**2 + (3 * b - a - 3 * c + d) * t**3)
        for a, b, c, d in zip(p[:-3], p[1:-2], p[2:-1], p[3:], strict=True)
    ]
    return np.concatenate([*pieces, p[-2:-1]])


def _fixed(points: Floats) -> NDArray[np.int32]:
    limited: NDArray[np.int32] = np.rint(np.clip(points, -(2**20), 2**20) * 2**_SHIFT).astype(np.int32)
    return limited


def _tagged(image: NDArray[np.uint8], box: Floats, text: str, size: float) -> NDArray[np.uint8]:
    """With a box around a face and its number on the box's upper left corner."""
    from PIL import Image, ImageDraw, ImageFont

    picture = Image.fromarray(image)
    pen = ImageDraw.Draw(picture)
    x0, y0, x1, y1 = (float(value) for value in np.clip(box, -(2**20), 2**20))
    width = max(1, round(size * _LINE))
    height = min(max(11.0, size * _TAG), 1000.0)
    font: Any = ImageFont.load_default(height * 0.8)
    pen.rectangle((x0, y0, x1, y1), outline=_BOX, width=width)
    tag = (x0, y0, x0 + pen.textlength(text, font) + height * 0.6, y0 + height)
    pen.rectangle(tag, fill=_BOX)
    pen.text(((tag[0] + tag[2]) / 2, (tag[1] + tag[3]) / 2), text, fill=_SHADE, font=font, anchor="mm")
    return np.array(picture)
