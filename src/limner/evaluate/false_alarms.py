"""A detector goes in; what it takes for a face in pictures that hold none comes out."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from limner.errors import MissingExtra
from limner.evaluate.made_pictures import Picture, Random, made_picture
from limner.types import Face, Photo
from limner.vision.landmarks.fmp.scenes import SAMPLE_PICTURES, Scene
from limner.vision.landmarks.fmp.textures import texture
from limner.vision.photo import load_photo

Watch = Callable[[str, int, int, str], None]

WHOLE = (
    *SAMPLE_PICTURES,
    *("chessboard_GRAY.png", "clock_motion.png", "logo.png", "motorcycle_right.png", "phantom.png"),
)
"""Sample pictures of scikit-image in which nobody is to be seen."""

EMPTY_PARTS = {
    "astronaut.png": (slice(230, 512), slice(0, 512)),
    "camera.png": (slice(150, 512), slice(300, 512)),
}
"""Part (rows, columns) without a face of those in which there is somebody."""

_PARTS_EACH = 6
_MADE = 48
_TEXTURES = 36
_SIDE = 480
"""Longer side of a picture, at most [px]."""


@dataclass(frozen=True)
class FalseAlarms:
    """What a detector found where nothing is.

    Attributes:
        pictures: how many it looked at.
        found: each face that is none, with the name of its picture.
    """

    pictures: int
    found: tuple[tuple[str, Face], ...]

    def row(self) -> dict[str, Any]:
        """The figures by name: pictures, false alarms, and which pictures they are in with the scores."""
        named = [{"picture": name, "score": face.score} for name, face in self.found]
        return {"pictures": self.pictures, "false_alarms": len(self.found), "in": named}


def count_false_alarms(
    detect: Callable[[Photo], Sequence[Face]], pictures: Sequence[Scene], name: str, watch: Watch
) -> FalseAlarms:
    """Run a detector over pictures without a face.

    Args:
        detect: photo -> faces.
        pictures: such as ``pictures_without_face`` gives.
        name: of the detector, for ``watch``.
        watch: told of progress.
    """
    found: list[tuple[str, Face]] = []
    for k, picture in enumerate(pictures):
        watch(name, k, len(pictures), picture.name)
        found += [(picture.name, face) for face in detect(Photo(picture.read()))]
    watch(name, len(pictures), len(pictures), "")
    return FalseAlarms(len(pictures), tuple(found))


def pictures_without_face(seed: int = 0) -> list[Scene]:
    """More than 200 pictures: scikit-image's, seeded parts of them changed in many ways, and made-up ones.

    What a training with the same sample pictures saw of them are other parts; the made-up ones are of other kinds, or
    of other seeds.

    Raises:
        MissingExtra: scikit-image is not installed.
    """
    folder = sample_folder()
    samples = [(name, partial(_sample, folder / name)) for name in (*WHOLE, *EMPTY_PARTS) if (folder / name).is_file()]
    pictures = samples.copy()
    for number, (name, read) in enumerate(samples):
        for k in range(_PARTS_EACH):
            pictures.append((f"{name} part {k}", partial(_part, read, [seed, number, k], k)))
    for k in range(_MADE):
        pictures.append((f"made {k}", partial(_made, made_picture, [seed, 1000, k], k)))
    for k in range(_TEXTURES):
        pictures.append((f"texture {k}", partial(_made, texture, [seed, 2000, k], k)))
    return [Scene(name, read, np.zeros((0, 4))) for name, read in pictures]


def sample_folder() -> Path:
    """Where scikit-image keeps its sample pictures.

    Raises:
        MissingExtra: it is not installed.
    """
    found = importlib.util.find_spec("skimage")
    if found is None or found.origin is None:
        raise MissingExtra("looking at scikit-image's sample pictures", "demo")
    return Path(found.origin).parent / "data"


@lru_cache(maxsize=1)  # the parts of a picture come one after another
def _sample(path: Path) -> Picture:
    return _fitted(load_photo(path).rgb[EMPTY_PARTS.get(path.name, (slice(None), slice(None)))])


def _made(make: Callable[[int, Random, int], Picture], seed: Sequence[int], kind: int) -> Picture:
    return make(kind, np.random.default_rng(seed), _SIDE)


def _part(read: Callable[[], Picture], seed: Sequence[int], kind: int) -> Picture:
    """A random part of a picture, enlarged, turned, and changed in one of several ways."""
    rng, whole = np.random.default_rng(seed), read()
    height, width = whole.shape[:2]
    side = int(rng.uniform(0.3, 0.8) * min(height, width))
    top, left = int(rng.integers(0, height - side + 1)), int(rng.integers(0, width - side + 1))
    part = np.rot90(whole[top : top + side, left : left + side], int(rng.integers(0, 4)))
    part = part[:, ::-1] if rng.random() < 0.5 else part
    changed = CHANGES[kind % len(CHANGES)](part, rng)
    return cv2.resize(changed, (_SIDE, _SIDE), interpolation=cv2.INTER_CUBIC)


def _fitted(picture: Picture) -> Picture:
    """No larger than ``_SIDE``."""
    scale = min(1.0, _SIDE / max(picture.shape[:2]))
    size = (max(1, round(picture.shape[1] * scale)), max(1, round(picture.shape[0] * scale)))
    return cv2.resize(picture, size, interpolation=cv2.INTER_AREA)


def _as_it_is(picture: Picture, rng: Random) -> Picture:
    return picture


def _negative(picture: Picture, rng: Random) -> Picture:
    return 255 - picture


def _harsh(picture: Picture, rng: Random) -> Picture:
    """More contrast, around another middle."""
    return np.clip((picture - rng.uniform(60, 190)) * rng.uniform(1.5, 4) + 128, 0, 255).astype(np.uint8)


def _mirrored_half(picture: Picture, rng: Random) -> Picture:
    """As symmetric as a face."""
    half = picture[:, : picture.shape[1] // 2]
    return np.concatenate([half, half[:, ::-1]], axis=1)


def _shuffled(picture: Picture, rng: Random) -> Picture:
    """Its tiles in another order."""
    count = int(rng.integers(3, 7))
    side = max(1, len(picture) // count)
    tiles = [
        picture[y : y + side, x : x + side] for y in range(0, side * count, side) for x in range(0, side * count, side)
    ]
    order = rng.permutation(len(tiles))
    rows = [np.concatenate([tiles[k] for k in order[row::count]], axis=1) for row in range(count)]
    return np.concatenate(rows, axis=0)


def _noisy(picture: Picture, rng: Random) -> Picture:
    noise = cv2.GaussianBlur(rng.normal(0, rng.uniform(20, 90), picture.shape), (0, 0), rng.uniform(0.5, 3))
    return np.clip(picture + noise, 0, 255).astype(np.uint8)


CHANGES: tuple[Callable[[Picture, Random], Picture], ...] = (
    _as_it_is,
    _negative,
    _harsh,
    _mirrored_half,
    _shuffled,
    _noisy,
)
"""What is done to a part."""
