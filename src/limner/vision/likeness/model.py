"""A photo, a face in it and the strokes drawn of it go in; how much of the person is in the drawing comes out.

The model knows what tells people apart (a discriminant) and a gallery of others, as descriptors only.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib import resources
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from limner.errors import BadInput
from limner.storage import pack_npz, read_bytes, unpack_npz, write_whole
from limner.types import Face, Floats, Photo, Value, frozen_array
from limner.vision.likeness.descriptor import describe
from limner.vision.likeness.discriminant import Descriptors, Discriminant
from limner.vision.likeness.picture import drawing_picture, photo_picture, upright_from_photo
from limner.vision.refine.shape import moved

_NEAR = 0.1
"""Cosines that differ by less than about this are hardly told apart."""

_FIELDS = ("photo_mean", "drawing_mean", "directions", "scale", "gallery")


@dataclass(frozen=True, eq=False)
class LikenessModel(Value):
    """What tells people apart, and others to be told apart from.

    Attributes:
        discriminant: of photos and drawings.
        gallery: (people, k) unit vectors of other people's photos.
    """

    discriminant: Discriminant
    gallery: Descriptors

    def __post_init__(self) -> None:
        width = self.discriminant.directions.shape[1]
        self._freeze("gallery", frozen_array(self.gallery, np.float32, (None, width), "likeness model: gallery"))

    def likeness(self, photo: Photo, face: Face, lines_px: Sequence[Floats], pen_px: float) -> float:
        """How much of the person is in the drawing, 0 to 1.

        Half of it goes with the cosine of the drawing and its own photo: 0.7 where all of a photo's edges are drawn,
        about 0.3 for splines through the landmarks or when half of the strokes are lost, 0 for another person. The
        gallery decides whether that is this person at all, or anybody.

        Args:
            photo: any size.
            face: the one drawn, all 68 landmarks; those of the jaw do not count.
            lines_px: the strokes as drawn, in the pixels of the photo.
            pen_px: width of their line.

        Returns:
            0 for nothing and for another face; about 0.9 for all edges of the photo; 1 for the photo itself.
        """
        upright = upright_from_photo(face.points_px)
        marks = moved(face.points_px, upright)
        drawn = describe(drawing_picture(lines_px, pen_px, upright), marks)
        seen = describe(photo_picture(photo, upright), marks)
        if np.abs(drawn).max() < 1e-3 or np.abs(seen).max() < 1e-3:
            return 0.0
        return self.score(self.discriminant.of_drawings(drawn), self.discriminant.of_photos(seen))

    def score(self, drawing: Descriptors, photo: Descriptors) -> float:
        """The likeness, 0 to 1, of a drawing and its own photo as unit vectors (k,)."""
        own, others = float(drawing @ photo), self.gallery @ drawing
        surpassed = float((1 / (1 + np.exp((others - own) / _NEAR))).mean())
        return max(0.0, 2 * surpassed - 1) * (1 - (1 - min(max(own, 0.0), 1.0)) ** 2)


def save_likeness(model: LikenessModel, path: str | Path) -> None:
    """Write a model as .npz: its directions as bytes, the rest in half precision."""
    learnt = model.discriminant
    scale = np.maximum(np.abs(learnt.directions).max(axis=0), 1e-12) / 127
    arrays = {
        "photo_mean": learnt.photo_mean.astype(np.float16),
        "drawing_mean": learnt.drawing_mean.astype(np.float16),
        "directions": np.rint(learnt.directions / scale).astype(np.int8),
        "scale": scale.astype(np.float32),
        "gallery": model.gallery.astype(np.float16),
    }
    write_whole(path, pack_npz(arrays))


def load_likeness(path: str | Path) -> LikenessModel:
    """Read a model.

    Raises:
        BadInput: no such file, or no likeness model.
    """
    return _unpacked(read_bytes(path), str(path))


@cache
def shipped_likeness() -> LikenessModel:
    """The model that limner ships."""
    data = (resources.files(__package__) / "likeness.npz").read_bytes()
    return _unpacked(data, "the shipped likeness model")


def _unpacked(data: bytes, name: str) -> LikenessModel:
    arrays = unpack_npz(data, name)
    if set(arrays) != set(_FIELDS):
        raise BadInput(f"{name}: no likeness model; expected {', '.join(_FIELDS)}; got {', '.join(arrays)}")
    coarse: NDArray[np.int8] = frozen_array(arrays["directions"], np.int8, (None, None), f"{name}: directions")
    scale = frozen_array(arrays["scale"], np.float32, (coarse.shape[1],), f"{name}: scale")
    learnt = Discriminant(arrays["photo_mean"], arrays["drawing_mean"], coarse * scale)
    return LikenessModel(learnt, arrays["gallery"])
