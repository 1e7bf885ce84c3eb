"""Annotated faces and the file of a face model in; what that model finds of them out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from limner.types import Face, Floats, Photo
from limner.vision.landmarks.fmp import detector as fmp
from limner.vision.landmarks.fmp.dataset import Sample
from limner.vision.landmarks.fmp.scenes import read_image
from limner.vision.refine.descent_training import detector_errors, mean_face

Watch = Callable[[str, int, int, str], None]

_FOUND = 0.3  # a detection off by more than this part of the outer-eye distance on average is of something else
_OUTER_EYE_PX = 150.0  # size at which faces are looked for: the thesis's
_AROUND = np.array([[1.6, 1.5], [1.6, 2.1]])  # what is searched, in outer-eye distances from the eyes


def detector_name(model: str) -> str:
    """What the detector of a model file is called; the shipped model has no file."""
    return Path(model).stem if model else "limner"


def detections(samples: Sequence[Sample], model: str, watch: Watch) -> list[Face | None]:
    """For each annotated face its detection in the photo, None where there is none.

    Only the surroundings of the face are searched, at one size, so that models for faces of different sizes compare.

    Args:
        samples: the faces.
        model: file of the face model, .npz or .mat; empty for the one that is shipped.
        watch: told of progress.

    Raises:
        BadInput: no usable model, or an image cannot be read.
    """
    found = []
    for k, sample in enumerate(samples):
        watch(detector_name(model), k, len(samples), sample.path.name)
        found.append(_detection(sample, fmp.FmpSettings(model=model, smallest=0.25, threshold=-0.7)))
    watch(detector_name(model), len(samples), len(samples), "")
    return found


def _detection(sample: Sample, settings: fmp.FmpSettings) -> Face | None:
    part, corner, pixel = _surroundings(read_image(sample.path), sample)
    faces = [_moved(face, corner, pixel) for face in fmp.detect(Photo(part), settings) if face.frontal]
    near = [face for face in faces if _error(sample, face) < _FOUND]
    return max(near, key=lambda face: face.score) if near else None


def _surroundings(image: NDArray[np.uint8], sample: Sample) -> tuple[NDArray[np.uint8], Floats, Floats]:
    """The part of a photo around a face, where it is, and the size of its pixels in those of the photo."""
    eyes, unit = np.nanmean(sample.points_px[36:48], axis=0), sample.outer_eye_px
    size = np.array([image.shape[1], image.shape[0]])
    x0, y0 = np.clip(np.floor(eyes - unit * _AROUND[0]), 0, size - 1).astype(int)
    x1, y1 = np.clip(np.ceil(eyes + unit * _AROUND[1]), [x0 + 1, y0 + 1], size).astype(int)
    scale = min(1.0, _OUTER_EYE_PX / unit)
    shape = max(1, round((x1 - x0) * scale)), max(1, round((y1 - y0) * scale))
    part = np.asarray(cv2.resize(image[y0:y1, x0:x1], shape, interpolation=cv2.INTER_AREA), np.uint8)
    return part, np.array([x0, y0], float), np.array([x1 - x0, y1 - y0]) / shape


def _moved(face: Face, corner: Floats, pixel: Floats) -> Face:
    points = (face.points_px + 0.5) * pixel - 0.5 + corner
    box = face.box_px * np.tile(pixel, 2) + np.tile(corner, 2)
    return Face(points, box, face.score, face.yaw_deg, face.detector)


def _error(sample: Sample, face: Face) -> float:
    return float(np.nanmean(np.hypot(*(face.points_px - sample.points_px).T))) / sample.outer_eye_px


def errors_of(samples: Sequence[Sample], faces: Sequence[Face | None]) -> list[Floats]:
    """How a detector is off on faces that people annotated, for the starts of `limner train best`."""
    whole = [
        (sample, face)
        for sample, face in zip(samples, faces, strict=True)
        if face is not None and not sample.machine and sample.known.all()
    ]
    if len(whole) < 3:
        return []
    mean = mean_face([sample.points_px for sample, _ in whole])
    return [error for sample, face in whole for error in detector_errors(face.points_px, sample.points_px, mean)]
