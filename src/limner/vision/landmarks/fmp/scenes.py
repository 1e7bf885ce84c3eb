"""Photos, folders of pictures and a seed in; scenes in which everything but the marked faces is no face, out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from limner.errors import BadInput
from limner.types import Floats
from limner.vision.landmarks.fmp.dataset import Sample
from limner.vision.landmarks.fmp.textures import texture
from limner.vision.photo import load_photo

IMAGE_SUFFIXES = (".jpg", ".jpeg", ".png", ".webp")

SAMPLE_PICTURES = (
    *("brick.png", "cell.png", "chelsea.png", "chessboard_RGB.png", "coffee.png", "coins.png", "color.png"),
    *("grass.png", "gravel.png", "horse.png", "hubble_deep_field.jpg", "ihc.png", "microaneurysms.png", "moon.png"),
    *("motorcycle_left.png", "page.png", "retina.jpg", "rocket.jpg", "text.png"),
)
"""Pictures without a human face that ship in the wheel of scikit-image."""

Picture = NDArray[Any]


@dataclass(frozen=True, eq=False)
class Scene:
    """A picture to look for false faces in.

    Attributes:
        name: for messages.
        read: gives the picture, (H, W, 3) uint8 RGB.
        faces_px: (k, 4) x0, y0, x1, y1 of the faces in it, where finding one is right.
    """

    name: str
    read: Callable[[], Picture]
    faces_px: Floats


def read_image(path: str | Path) -> Picture:
    """An image file as upright RGB.

    Raises:
        BadInput: it cannot be read.
    """
    return load_photo(path).rgb


def _reader(path: Path) -> Callable[[], Picture]:
    return partial(read_image, path)


def of_samples(samples: Sequence[Sample]) -> list[Scene]:
    """The annotated photos: hair, clothes and walls around the face."""
    return [Scene(sample.path.name, _reader(sample.path), sample.box_px[None]) for sample in samples]


def of_folder(folder: str | Path) -> list[Scene]:
    """All pictures of a folder, which hold no face.

    Raises:
        BadInput: no picture in it.
    """
    files = sorted(path for path in Path(folder).iterdir() if path.suffix.lower() in IMAGE_SUFFIXES)
    if not files:
        raise BadInput(f"{folder}: no picture in it; expected {', '.join(IMAGE_SUFFIXES)}")
    return [Scene(path.name, _reader(path), np.zeros((0, 4))) for path in files]


def sample_pictures() -> list[Scene]:
    """The face-free pictures of scikit-image; none where it is not installed."""
    try:
        import skimage
    except ImportError:
        return []
    folder = Path(skimage.__file__).parent / "data"
    files = [folder / name for name in SAMPLE_PICTURES if (folder / name).is_file()]
    return [Scene(path.name, _reader(path), np.zeros((0, 4))) for path in files]


def textures(count: int, seed: int, size: int = 400) -> list[Scene]:
    """``count`` made-up pictures: clouds, stripes, blobs, walls of panes, rings, signs and so on."""
    return [Scene(f"texture-{k}", partial(_texture, k, seed, size), np.zeros((0, 4))) for k in range(count)]


def _texture(k: int, seed: int, size: int) -> Picture:
    return texture(k, np.random.default_rng([seed, k]), size)
