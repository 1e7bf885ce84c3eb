"""A photo and where it lies on a page go in; what the page frames of it comes out, to stand beside the drawing."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from limner.types import Face, Floats, Page, Photo


def frame_photo(photo: Photo, page_from_photo: Floats, page: Page, px_per_mm: float) -> Photo:
    """The part of a photo that the page shows, in the size in which the page is drawn; white where it ends.

    Args:
        photo: the picture.
        page_from_photo: (2, 3) from its pixels to SVG millimetres (y down), scale and shift only.
        page: the sheet.
        px_per_mm: resolution of the result, as of the drawing beside it.

    Returns:
        Photo as large as the drawing's picture, registered with it within a pixel.
    """
    import cv2

    width, height = max(1, round(page.width_mm * px_per_mm)), max(1, round(page.height_mm * px_per_mm))
    scale = page_from_photo[0, 0] * px_per_mm
    corner = page_from_photo[:, 2] * px_per_mm - 0.5 * scale  # of the photo's upper left pixel, not its centre
    size = np.array(photo.size_px)
    first = np.clip(np.floor(-corner / scale), 0, size).astype(int)
    last = np.clip(np.ceil((np.array([width, height]) - corner) / scale), 0, size).astype(int)
    frame = np.full((height, width, 3), 255, np.uint8)
    if (last <= first).any():
        return Photo(frame)
    to = np.rint(corner + last * scale).astype(int)
    start = np.minimum(np.rint(corner + first * scale).astype(int), to - 1)
    begin, end = np.maximum(start, 0), np.minimum(to, [width, height])
    if (end <= begin).any():
        return Photo(frame)
    part: NDArray[Any] = cv2.resize(
        photo.rgb[first[1] : last[1], first[0] : last[0]],
        tuple((to - start).tolist()),
        interpolation=cv2.INTER_AREA if scale < 1 else cv2.INTER_CUBIC,
    )
    (x0, y0), (x1, y1) = begin - start, end - start
    frame[begin[1] : end[1], begin[0] : end[0]] = part[y0:y1, x0:x1]
    return Photo(frame)


def frame_face(face: Face, page_from_photo: Floats, px_per_mm: float) -> Face:
    """The same face in the pixels of ``frame_photo``'s result."""
    points = (face.points_px @ page_from_photo[:, :2].T + page_from_photo[:, 2]) * px_per_mm - 0.5
    box = (face.box_px.reshape(2, 2) @ page_from_photo[:, :2].T + page_from_photo[:, 2]) * px_per_mm
    return Face(points, box.ravel(), face.score, face.yaw_deg, face.detector)
