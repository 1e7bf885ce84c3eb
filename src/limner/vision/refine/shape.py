"""Faces by hand in, a model of their shapes out; and with it a face in, the nearest likely shape out (thesis 3.3.6)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib import resources
from pathlib import Path

import numpy as np

from limner.errors import BadInput
from limner.settings import SettingsGroup, setting
from limner.storage import pack_npz, read_bytes, unpack_npz, write_whole
from limner.types import Face, Floats, Photo, Value, frozen_array
from limner.vision.landmarks.mirror import MIRROR
from limner.vision.refine.ground import with_points

_ROUNDS = 10


@dataclass(frozen=True)
class ShapeSettings(SettingsGroup):
    """How much of a face's own shape is kept."""

    components: int = setting(
        35, "principal components kept (thesis: 35 and 50); 0 = as many as the variance asks for", low=0, high=136
    )
    variance: float = setting(0.99, "share of the variance kept where components = 0", low=0, high=1)
    model: str = setting(
        "", "file of the shape model (.npz of `limner train shape`); empty for the one that is shipped"
    )


@dataclass(frozen=True, eq=False)
class ShapeModel(Value):
    """How faces differ in shape: a mean, and principal components of what differs from it.

    Attributes:
        mean: (68, 2) upright, outer eye corners one apart on average, around (0, 0).
        sigma: (68, 2) standard deviation of each coordinate over the aligned faces.
        components: (136, n) orthonormal columns, the one with the most variance first, of the normalised shapes.
        deviations: (n,) standard deviation of the faces along each.
    """

    mean: Floats
    sigma: Floats
    components: Floats
    deviations: Floats

    def __post_init__(self) -> None:
        self._freeze("mean", frozen_array(self.mean, np.float64, (68, 2), "shape model: mean"))
        self._freeze("sigma", frozen_array(self.sigma, np.float64, (68, 2), "shape model: sigma"))
        self._freeze("components", frozen_array(self.components, np.float64, (136, None), "shape model: components"))
        count = self.components.shape[1]
        self._freeze("deviations", frozen_array(self.deviations, np.float64, (count,), "shape model: deviations"))
        if not (self.sigma > 0).all() or count < 1:
            raise BadInput("shape model: expected one component or more, and a positive sigma of every coordinate")

    def variance_kept(self, count: int) -> float:
        """Share of the variance that the first ``count`` components hold, 0 to 1."""
        squared = self.deviations**2
        return float(squared[:count].sum() / squared.sum())

    def components_for(self, variance: float) -> int:
        """The least number of components that hold this share of the variance."""
        shares = np.cumsum(self.deviations**2) / (self.deviations**2).sum()
        return min(1 + int((shares < variance - 1e-12).sum()), len(shares))

    def project(self, points: Floats, count: int) -> Floats:
        """Points (68, 2), made of the first ``count`` components alone; the five steps of the thesis.

        Raises:
            BadInput: all points are one.
        """
        to_mean = similarity(points, self.mean)
        normalised = (moved(points, to_mean) - self.mean) / self.sigma
        basis = self.components[:, :count]
        kept = (basis @ (basis.T @ normalised.ravel())).reshape(68, 2)
        return moved(self.mean + self.sigma * kept, inverse(to_mean))

    def mode(self, number: int, deviations: float) -> Floats:
        """The mean face (68, 2) moved along one component, by so many of its standard deviations."""
        along = (deviations * self.deviations[number] * self.components[:, number]).reshape(68, 2)
        face: Floats = self.mean + self.sigma * along
        return face


def shape(photo: Photo, face: Face, settings: ShapeSettings) -> Face:
    """Replace the landmarks by the nearest combination of principal components.

    Raises:
        BadInput: all landmarks are one point, or there is no usable model.
    """
    model = load_shape(settings.model) if settings.model else shipped_shape()
    count = settings.components or model.components_for(settings.variance)
    return with_points(photo, face, model.project(face.points_px, count))


def train_shape(faces: Sequence[Floats], *, mirrored: bool = True) -> ShapeModel:
    """Principal components of faces, aligned to their common mean and normalised coordinate by coordinate.

    The thesis aligns to one of the faces; the mean of all (Gower 1975) takes that accident out.

    Args:
        faces: (68, 2) each, in any frame.
        mirrored: also learn the mirror image of each.

    Raises:
        BadInput: fewer than three faces, or one whose landmarks are one point.
    """
    if len(faces) < 3:
        raise BadInput(f"shape: {len(faces)} faces with all 68 landmarks; expected three or more")
    shapes = list(faces)
    if mirrored:
        shapes += [(points * [-1, 1])[MIRROR] for points in faces]
    mean = _upright(shapes[0])
    for _ in range(_ROUNDS):
        aligned = np.stack([moved(points, similarity(points, mean)) for points in shapes])
        mean = _upright(aligned.mean(axis=0))
    aligned = np.stack([moved(points, similarity(points, mean)) for points in shapes])
    mean = aligned.mean(axis=0)
    sigma = np.maximum(aligned.std(axis=0), 1e-9)
    normalised = ((aligned - mean) / sigma).reshape(len(shapes), 136)
    _, singular, rows = np.linalg.svd(normalised, full_matrices=False)
    real = singular > 1e-9 * singular[0]
    return ShapeModel(mean, sigma, rows[real].T, singular[real] / np.sqrt(len(shapes)))


def similarity(source: Floats, target: Floats) -> Floats:
    """The rotation, scaling and shift (2, 3) that lays ``source`` (n, 2) over ``target`` with the least squares.

    Raises:
        BadInput: all points of ``source`` are one.
    """
    a, b = source - source.mean(axis=0), target - target.mean(axis=0)
    size = float((a**2).sum())
    if size < 1e-12:
        raise BadInput("face: all landmarks are one point; expected 68 places")
    cosine, sine = (a * b).sum() / size, (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum() / size
    turn = np.array([[cosine, -sine], [sine, cosine]])
    return np.column_stack([turn, target.mean(axis=0) - turn @ source.mean(axis=0)])


def moved(points: Floats, affine: Floats) -> Floats:
    """Points (n, 2) through a (2, 3) map."""
    result: Floats = points @ affine[:, :2].T + affine[:, 2]
    return result


def inverse(affine: Floats) -> Floats:
    """The map (2, 3) that leads back."""
    back = np.linalg.inv(affine[:, :2])
    return np.column_stack([back, -back @ affine[:, 2]])


def _upright(points: Floats) -> Floats:
    """Around (0, 0), the line of the eyes level, outer eye corners one apart."""
    right, left = points[45], points[36]
    axis = (right - left) / ((right - left) @ (right - left))
    turn = np.array([[axis[0], axis[1]], [-axis[1], axis[0]]])
    upright: Floats = (points - points.mean(axis=0)) @ turn.T
    return upright


def save_shape(model: ShapeModel, path: str | Path) -> None:
    """Write a model as .npz, in single precision."""
    names = ("mean", "sigma", "components", "deviations")
    write_whole(path, pack_npz({name: getattr(model, name).astype(np.float32) for name in names}))


@cache
def load_shape(path: str | Path) -> ShapeModel:
    """Read a model.

    Raises:
        BadInput: no such file, or no shape model.
    """
    return _unpacked(read_bytes(path), str(path))


@cache
def shipped_shape() -> ShapeModel:
    """The model that limner ships."""
    return _unpacked((resources.files(__package__) / "shape.npz").read_bytes(), "the shipped shape model")


def _unpacked(data: bytes, name: str) -> ShapeModel:
    arrays = unpack_npz(data, name)
    names = ("mean", "sigma", "components", "deviations")
    if set(arrays) != set(names):
        raise BadInput(f"{name}: no shape model; expected {', '.join(names)}, got {', '.join(arrays) or 'nothing'}")
    return ShapeModel(**{key: arrays[key] for key in names})
