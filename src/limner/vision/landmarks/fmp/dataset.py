"""A folder of annotated face images in; samples with the person, the 68 landmarks and the yaw of each out."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from limner.errors import BadInput
from limner.storage import read_bytes, unpack_npz
from limner.types import Floats, Value, frozen_array
from limner.vision.landmarks import mesh
from limner.vision.photo import photo_size

JAW = slice(0, 17)

SURE = 0.9999
"""Score from which a machine's landmarks count; it was less where a hand, a cap, or a shadow hid the eyes, where the
head hung down, and on half of the profiles (seen by eye on 70 free portraits)."""

NOSE_REACH = 0.45
"""How far the nose tip stands before the outer eye corners, in outer-eye distances (adults, roughly)."""


@dataclass(frozen=True, eq=False)
class Sample(Value):
    """One annotated face.

    Attributes:
        path: the image.
        person: who it is, the same in all photos of that person: ``<folder>/<first part of the file name>``.
        points_px: (68, 2) in iBUG-68 order, photo frame; NaN where a landmark is not known.
        size_px: width and height of the image.
        machine: whether a program, not a person, placed the landmarks.
        guessed: (68,) which landmarks are no more than a guess.
    """

    path: Path
    person: str
    points_px: Floats
    size_px: tuple[int, int]
    machine: bool = False
    guessed: NDArray[np.bool_] = dataclasses.field(default_factory=lambda: np.zeros(68, bool))

    def __post_init__(self) -> None:
        points = np.array(self.points_px, dtype=np.float64)
        if np.isinf(points).any():
            raise BadInput(f"{self.path}: a landmark at infinity; expected numbers, or NaN for one that is not known")
        frozen_array(np.nan_to_num(points), np.float64, (68, 2), f"{self.path}: landmarks")
        points.setflags(write=False)
        self._freeze("points_px", points)
        self._freeze("guessed", frozen_array(self.guessed, np.bool_, (68,), f"{self.path}: guessed"))

    @property
    def known(self) -> NDArray[np.bool_]:
        """(68,) which landmarks are known."""
        return np.asarray(np.isfinite(self.points_px).all(axis=1), np.bool_)

    @property
    def outer_eye_px(self) -> float:
        """Distance of the outer eye corners; NaN when one is not known."""
        return float(np.hypot(*(self.points_px[45] - self.points_px[36])))

    @property
    def tilt_deg(self) -> float:
        """Slope of the line through the outer eye corners, positive = clockwise; NaN when one is not known."""
        return float(np.degrees(np.arctan2(*(self.points_px[45] - self.points_px[36])[::-1])))

    @property
    def yaw_deg(self) -> float:
        """Turn of the head, roughly, by the nose tip between the eyes; positive = nose to image right; 0 if unknown."""
        left, right, tip = self.points_px[[36, 45, 30]]
        axis = (right - left) / self.outer_eye_px
        aside = float((tip - (left + right) / 2) @ axis) / self.outer_eye_px
        return float(np.nan_to_num(np.degrees(np.arctan(aside / NOSE_REACH))))

    @property
    def box_px(self) -> Floats:
        """(4,) x0, y0, x1, y1 around the known landmarks."""
        points = self.points_px[self.known]
        return np.concatenate([points.min(axis=0), points.max(axis=0)])


def read_folder(folder: str | Path, *, skip: bool = False) -> tuple[list[Sample], list[str]]:
    """Read an annotated folder: ``landmarks*.npz`` beside the folder(s) of images it names.

    The npz holds ``names`` (n,), ``size_wh`` (n, 2) and ``ibug68`` (n, 68, 2) [px]. ``landmarks.npz`` and
    ``landmarks_machine.npz`` belong to ``images/``, ``landmarks_<x>.npz`` and ``landmarks_<x>_machine.npz`` to
    ``<x>/``. What a machine placed is taken from its face mesh, ``mp468`` (n, 468, 2) [px], which ``mesh.landmarks``
    brings to within 2.0 % of the outer-eye distance of where people put the landmarks (jaw 4.2 %); without a mesh the
    jaw is dropped (set to NaN). A face whose ``score`` (n,), if there is one, is below ``SURE`` is always left out.

    Args:
        folder: what to read, or the very npz when there are several in it (else ``landmarks.npz`` or the only one);
            a folder of images will do when exactly one npz beside it belongs to it.
        skip: leave bad entries out and name them, instead of refusing the folder.

    Returns:
        The samples, sorted by name, and one line for each entry left out.

    Raises:
        BadInput: no labels, labels of another form, or (unless ``skip``) a missing image, a wrong size, no landmark.
    """
    file = _labels(Path(folder))
    images, machine = _images(file), file.stem.endswith("_machine")
    samples: list[Sample] = []
    left_out: list[str] = []
    for name, size, face, score in sorted(zip(*_arrays(file), strict=True), key=lambda entry: str(entry[0])):
        try:
            if not score >= SURE:
                left_out.append(f"{images / str(name)}: the machine is not sure of its landmarks (score {score:.4f})")
            else:
                samples.append(_sample(images / str(name), size, face, machine))
        except BadInput as error:
            if not skip:
                raise
            left_out.append(str(error))
    if not samples:
        raise BadInput(f"{file}: no usable face in it; expected images with landmarks")
    return samples, left_out


def _labels(folder: Path) -> Path:
    if folder.suffix == ".npz":
        return folder
    found = sorted(folder.glob("landmarks*.npz"))
    found = found or [file for file in sorted(folder.parent.glob("landmarks*.npz")) if _images(file) == folder]
    chosen = [file for file in found if file.name == "landmarks.npz"] or found
    if len(chosen) != 1:
        has = ", ".join(file.name for file in found) or "none"
        raise BadInput(f"{folder}: expected landmarks.npz in it, found {has}; name one file, or another folder")
    return chosen[0]


def _images(file: Path) -> Path:
    middle = file.stem.removeprefix("landmarks").removesuffix("_machine").strip("_")
    return file.parent / (middle or "images")


def _arrays(file: Path) -> tuple[Any, Any, Any, Any]:
    """Names, sizes, landmarks and scores."""
    arrays = unpack_npz(read_bytes(file), str(file))
    missing = [key for key in ("names", "size_wh", "ibug68") if key not in arrays]
    if missing:
        raise BadInput(f"{file}: has no {' and no '.join(missing)}; expected names, size_wh and ibug68")
    names = arrays["names"]
    n = len(np.atleast_1d(names))
    check_table(file, arrays, "names", "texts", (n,))
    check_table(file, arrays, "size_wh", "whole numbers", (n, 2))
    check_table(file, arrays, "ibug68", "numbers", (n, 68, 2))
    check_table(file, arrays, "mp468", "numbers", (n, mesh.POINTS, 2))
    check_table(file, arrays, "score", "numbers", (n,))
    if len(set(names.tolist())) != n:
        raise BadInput(f"{file}: an image is named twice; expected one face for each image")
    machine = file.stem.endswith("_machine")
    return names, arrays["size_wh"], _machines(arrays) if machine else arrays["ibug68"], arrays.get("score", np.ones(n))


def check_table(file: Path, arrays: dict[str, Any], key: str, what: str, shape: tuple[int, ...]) -> None:
    """Let an array of an npz pass, or its absence.

    Raises:
        BadInput: it holds something else than ``what``, or is of another shape.
    """
    if key not in arrays:
        return
    if arrays[key].shape != shape:
        raise BadInput(f"{file}: {key} of shape {arrays[key].shape}; expected {shape}")
    if arrays[key].dtype.kind not in _KINDS[what]:
        raise BadInput(f"{file}: {key} of type {arrays[key].dtype}; expected {what}")


_KINDS = {"texts": "U", "whole numbers": "iu", "numbers": "iuf"}


def _machines(arrays: dict[str, Any]) -> Floats:
    """(n, 68, 2) landmarks that a machine placed."""
    if "mp468" in arrays:
        return np.array([mesh.landmarks(points.astype(np.float64)) for points in arrays["mp468"]])
    points = np.array(arrays["ibug68"], np.float64)
    points[:, JAW] = np.nan
    return points


def _sample(path: Path, size: Any, points: Any, machine: bool) -> Sample:
    if not path.is_file():
        raise BadInput(f"{path}: named by the landmarks, but missing; add it or leave such images out")
    width, height = photo_size(path)
    if (width, height) != tuple(int(side) for side in size):
        raise BadInput(f"{path}: {width} x {height} px, but its landmarks are for {size[0]} x {size[1]}")
    points = np.array(points, dtype=np.float64)
    if np.isnan(points).any(axis=1).all():
        raise BadInput(f"{path}: none of its landmarks is known")
    if (np.nan_to_num(points) < -width).any() or (np.nan_to_num(points) > 2 * max(width, height)).any():
        raise BadInput(f"{path}: a landmark far outside the image; are they in pixels of this image?")
    folder = path.parent.parent.name
    return Sample(path, f"{folder}/{path.stem.partition('_')[0]}", points, (width, height), machine)


def folds(samples: Sequence[Sample], count: int, seed: int = 0) -> list[frozenset[str]]:
    """Share the persons out evenly: each of ``count`` sets of persons is held out once.

    Raises:
        BadInput: fewer persons than folds.
    """
    persons = sorted({sample.person for sample in samples})
    if not 2 <= count <= len(persons):
        raise BadInput(f"folds: {count} of {len(persons)} persons, expected 2 to {len(persons)}")
    shuffled = np.random.default_rng(seed).permutation(len(persons))
    return [frozenset(persons[i] for i in shuffled[k::count]) for k in range(count)]


def similarity(source: Floats, target: Floats) -> Floats:
    """The (2, 3) rotation, scale and shift that lays ``source`` (n, 2) best over ``target`` (least squares).

    Umeyama 1991 (doi:10.1109/34.88573), in the plane and without reflection.
    """
    a, b = source - source.mean(axis=0), target - target.mean(axis=0)
    squared = (a * a).sum()
    cos, sin = (a * b).sum() / squared, (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum() / squared
    turn = np.array([[cos, -sin], [sin, cos]])
    return np.column_stack([turn, target.mean(axis=0) - turn @ source.mean(axis=0)])


def transform(matrix: Floats, points: Floats) -> Floats:
    """Points (n, 2) after a (2, 3) matrix."""
    return points @ matrix[:, :2].T + matrix[:, 2]
