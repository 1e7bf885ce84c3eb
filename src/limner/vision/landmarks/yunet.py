"""A photo and the file of YuNet go in, the boxes of its faces and how they are tilted come out."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from limner.types import Floats, Photo
from limner.vision.landmarks.mesh import Region
from limner.vision.landmarks.model_files import ModelFile, Quiet

MODEL = ModelFile(
    "YuNet",
    "a face detector, 0.2 MB, MIT",
    "face_detection_yunet*.onnx",
    "https://github.com/opencv/opencv_zoo (models/face_detection_yunet)",
    16 * 2**20,
    (
        "ebafce4e3c118d6554634be5c27ab333b4c047a9a8c3faf1d7cf93101c22f0f0",  # 2026may
        "8f2383e4dd3cfbb4553ea8718107fc0423210dc964f9f4280604804ed2552fa4",  # 2023mar
    ),
)
"""The detector: Wu, Peng & Yu 2023, doi:10.1007/s11633-023-1423-y; it knows faces of 10 to 300 pixels."""

_SIDES = (320, 960)
"""The longer side of the photo is searched at these sizes, the next only where the one before held no face [px]."""

_SHARED = 0.3
"""Of two faces that share more than this of their union the better one stays."""

_SIDE = 1.5
"""Side of a face's region over the longer side of its box."""


def find(photo: Photo, file: Path, least_score: float) -> tuple[Region, ...]:
    """Find faces.

    Args:
        photo: where to look.
        file: of the network.
        least_score: in [0, 1].

    Raises:
        BadInput: the file holds no such network.
    """
    try:
        with Quiet():
            network = cv2.FaceDetectorYN.create(str(file), "", (_SIDES[0], _SIDES[0]), least_score, _SHARED)
            for side in _SIDES:
                found = _search(network, photo, side)
                if len(found):
                    break
    except cv2.error as error:
        raise MODEL.wrong(file, "OpenCV cannot run it") from error
    if not np.isfinite(found).all():
        raise MODEL.wrong(file, "it finds faces at no place")
    return tuple(_region(row) for row in found if (row[2:4] > 0).all())


def _search(network: cv2.FaceDetectorYN, photo: Photo, side: int) -> Floats:
    scale = min(1.0, side / max(photo.size_px))
    size = tuple(max(1, round(length * scale)) for length in photo.size_px)
    picture = cv2.resize(photo.rgb, size, interpolation=cv2.INTER_AREA)
    network.setInputSize(size)
    found = network.detect(np.ascontiguousarray(picture[..., ::-1]))[1]
    if found is None:
        return np.zeros((0, 15))
    rows: Floats = np.asarray(found, np.float64)
    rows[:, :14] /= np.tile(np.array(size) / photo.size_px, 7)
    return rows


def _region(row: Floats) -> Region:
    """A row of YuNet, in whose continuous frame a pixel's centre lies at its index + 0.5."""
    across = row[6:8] - row[4:6]
    return Region(row[:2] + row[2:4] / 2 - 0.5, _SIDE * float(row[2:4].max()), float(np.arctan2(across[1], across[0])))
