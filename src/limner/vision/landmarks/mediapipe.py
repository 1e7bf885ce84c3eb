"""A photo and the face mesh network that the user fetched go in, faces with 68 landmarks come out, largest first."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from limner.settings import SettingsGroup, setting
from limner.types import Face, Floats, Photo
from limner.vision.landmarks import yunet
from limner.vision.landmarks.boxes import distinct
from limner.vision.landmarks.mesh import MARGIN, POINTS, Region, View, turn
from limner.vision.landmarks.model_files import ModelFile, Quiet, check, in_folder, required

NAME = "mediapipe"

Image = NDArray[Any]

MODEL = ModelFile(
    "MediaPipe's face mesh",
    "468 points, 1.2 MB, Apache-2.0",
    "face_landmark.tflite",
    "https://storage.googleapis.com/mediapipe-assets/face_landmark.tflite",
    32 * 2**20,
    (
        "1055cb9d4a9ca8b8c688902a3a5194311138ba256bcc94e336d8373a5f30c814",  # of 2023, as in the last releases
        "c603fa6149219a3e9487dc9abd7a0c24474c77263273d24868378cdf40aa26d1",  # of 2022
    ),
)

_INPUT = 192
"""Side of the square picture that the network sees [px]; its values are 0 to 1, its points lie in that square."""

_FARTHEST = 8 * _INPUT
"""No network that works places a point farther from its picture's corner [px]."""

_PASSES = 2
"""Where the face was found is only near its mesh: the first pass places the square for the second."""

_SAME = 0.5
"""Faces whose boxes share more than this of their union are one."""


@dataclass(frozen=True)
class MediapipeSettings(SettingsGroup):
    """How MediaPipe's face mesh is placed on faces."""

    model: str = setting("", "File of the face mesh, face_landmark.tflite; empty for the one in $LIMNER_MODELS")
    boxes: str = setting(
        "", "File of YuNet (.onnx), which says where faces are; empty for the one in $LIMNER_MODELS, else fmp looks"
    )
    trust: bool = setting(
        False,
        "Use other files than the published ones, which are known by their SHA-256; a damaged one may crash OpenCV",
    )
    least_box: float = setting(0.7, "Least score of a box that YuNet finds", low=0, high=1)
    least_face: float = setting(0.5, "Least probability, by the mesh itself, that there is a face", low=0, high=1)


def detect(photo: Photo, settings: MediapipeSettings, find: Callable[[Photo], Sequence[Face]]) -> tuple[Face, ...]:
    """Place the mesh on every face.

    Args:
        photo: where to look.
        settings: files and limits.
        find: another detector, asked for the faces where there is no file of YuNet.

    Raises:
        BadInput: a file is missing, or holds no such network.
    """
    file = required(MODEL, settings.model, "--model")
    check(MODEL, file, settings.trust)
    network = _load(file)
    faces = [_face(photo, network, region, file) for region in _regions(photo, settings, find)]
    return distinct((face for face in faces if face.score >= settings.least_face), _SAME)


def looked_for(photo: Photo, settings: MediapipeSettings) -> str:
    """In words, what ``detect`` looks for."""
    return f"faces with a probability of at least {settings.least_face:g} by MediaPipe's mesh"


def _regions(photo: Photo, settings: MediapipeSettings, find: Callable[[Photo], Sequence[Face]]) -> tuple[Region, ...]:
    boxes = Path(settings.boxes) if settings.boxes else in_folder(yunet.MODEL)
    if boxes is None:
        return tuple(_around(face) for face in find(photo))
    check(yunet.MODEL, boxes, settings.trust)
    return yunet.find(photo, boxes, settings.least_box)


def _around(face: Face) -> Region:
    """Where the mesh of a face may be, whose landmarks go no higher than the brows."""
    angle = float(np.arctan2(*(face.points_px[45] - face.points_px[36])[::-1])) if face.frontal else 0.0
    axes = turn(angle)
    level = face.points_px @ axes
    low, high = level.min(axis=0), level.max(axis=0)
    low = low - [0, 0.25 * (high[1] - low[1])]
    return Region(axes @ ((low + high) / 2), MARGIN * float((high - low).max()), angle)


def _load(file: Path) -> cv2.dnn.Net:
    # OpenCV 5's new engine keeps only one of the network's two outputs; OpenCV 4 has but the classic one.
    engine = [cv2.dnn.ENGINE_CLASSIC] if hasattr(cv2.dnn, "ENGINE_CLASSIC") else []
    try:
        with Quiet():
            network = cv2.dnn.readNetFromTFLite(str(file), *engine)
            _run(network, np.zeros((_INPUT, _INPUT, 3), np.uint8), file)
    except cv2.error as error:
        raise MODEL.wrong(file, "OpenCV cannot run it") from error
    return network


def _run(network: cv2.dnn.Net, picture: Image, file: Path) -> tuple[Floats, float]:
    """The mesh (468, 3) in the picture [px], pixel centres at index + 0.5, and the logit of a face being there."""
    network.setInput(np.ascontiguousarray(picture.transpose(2, 0, 1)[None], dtype=np.float32) / 255)
    outputs = {output.size: output for output in network.forward(network.getUnconnectedOutLayersNames())}
    if set(outputs) != {3 * POINTS, 1}:
        sizes = " and ".join(map(str, sorted(outputs, reverse=True)))
        raise MODEL.wrong(file, f"it gives {sizes} numbers, expected {3 * POINTS} and 1")
    mesh, logit = outputs[3 * POINTS].reshape(POINTS, 3).astype(np.float64), float(outputs[1].item())
    if not (np.isfinite(logit) and np.abs(mesh).max() < _FARTHEST and np.ptp(mesh[:, :2], axis=0).min() > 1):
        raise MODEL.wrong(file, "it sees a face of no size or far beyond its picture")
    return mesh, logit


def _face(photo: Photo, network: cv2.dnn.Net, region: Region, file: Path) -> Face:
    """The face in a region: the mean of what the network says of it and of its mirror image."""
    for _ in range(_PASSES):
        square, picture = region, _cut(photo, region)
        seen = [View.of(*_run(network, side, file)) for side in (picture, picture[:, ::-1])]
        view = seen[0].mean(seen[1].mirrored(_INPUT))
        region = view.region.within(square, _INPUT)
    points = square.to_photo(view.landmarks, _INPUT)
    box = np.concatenate([points.min(axis=0), points.max(axis=0)])
    return Face(points, box, float(0.5 + np.tanh(view.logit / 2) / 2), view.yaw_deg, NAME)


def _cut(photo: Photo, region: Region) -> Image:
    """The region as the network sees it; beyond the photo its rim goes on."""
    shrink = max(1.0, region.side_px / _INPUT)
    size = tuple(max(1, round(length / shrink)) for length in photo.size_px)
    small = cv2.resize(photo.rgb, size, interpolation=cv2.INTER_AREA)
    corners = np.array([[0.5, 0.5], [1.5, 0.5], [0.5, 1.5]])  # the first pixel, the next in its row, in its column
    first, right, below = (region.to_photo(corners, _INPUT) + 0.5) * size / photo.size_px - 0.5
    small_from_cut = np.column_stack([right - first, below - first, first])
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    return cv2.warpAffine(small, small_from_cut, (_INPUT, _INPUT), flags=flags, borderMode=cv2.BORDER_REPLICATE)
