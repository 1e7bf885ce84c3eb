"""A picture and a small model whose right answer is known: each filter is cut out of the picture's own HOG map."""

import cv2
import numpy as np

from limner.vision.landmarks.fmp.hog import hog
from limner.vision.landmarks.fmp.model import Component, FmpModel
from limner.vision.landmarks.fmp.pyramid import PAD, padded

CELLS = np.array([[12, 10], [17, 11], [9, 16], [18, 18]])
"""x, y of the parts' windows in the padded map of ``texture()``; the root first, then a child and two below it."""

PARENTS = [-1, 0, 0, 1]


def texture(height=120, width=120, seed=3):
    """Smooth noise: no two places look alike."""
    rng = np.random.default_rng(seed)
    coarse = rng.uniform(0, 255, (height // 6 + 2, width // 6 + 2, 3))
    grid = np.kron(coarse, np.ones((6, 6, 1)))[:height, :width]
    return np.round(0.7 * grid + rng.uniform(0, 60, (height, width, 3))).clip(0, 255)


def on_grey(picture, top, left, height, width):
    """The picture somewhere on an empty ground."""
    canvas = np.full((height, width, 3), 127.0)
    canvas[top : top + picture.shape[0], left : left + picture.shape[1]] = picture
    return canvas


def model_of(picture, cells=CELLS, parents=PARENTS, spring=(0.05, 0.0, 0.05, 0.0), gain=1.0, **changes):
    """A model that scores ``gain`` for each part that looks as in the picture, with anchors where they are there."""
    features = padded(hog(picture))
    typical = features[PAD:-PAD, PAD:-PAD].mean(axis=(0, 1))
    windows = np.stack([features[y : y + 5, x : x + 5] - typical for x, y in cells])
    filters = gain * windows / (windows**2).sum(axis=(1, 2, 3), keepdims=True)
    offset = -(filters * typical).sum(axis=(1, 2, 3)).sum()
    anchors = np.array([[0, 0], *(cells[i] - cells[parents[i]] for i in range(1, len(cells)))])
    component = Component(
        yaw_deg=0.0,
        bias=offset,
        parents=parents,
        filters=np.arange(len(cells)),
        springs=[[0] * 4, *[spring] * (len(cells) - 1)],
        anchors=anchors,
        landmarks=np.arange(len(cells)),
    )
    settings = {"threshold": 0.8 * gain * len(cells), "interval": 2, "name": "toy"} | changes
    return FmpModel(filters, (component,), **settings)


def face_picture():
    """A face of sorts, 160 x 160 px: noise in which 68 places are told apart."""
    rng = np.random.default_rng(5)
    coarse = rng.uniform(0, 255, (16, 16, 3)).astype(np.float32)
    return cv2.resize(coarse, (160, 160), interpolation=cv2.INTER_CUBIC).clip(0, 255).round().astype(np.float64)


def face_model(**changes):
    """A model of 68 parts of ``face_picture()``."""
    rng = np.random.default_rng(8)
    cells = rng.permutation(np.stack(np.meshgrid(np.arange(6, 36), np.arange(6, 36)), axis=-1).reshape(-1, 2))[:68]
    parents = [-1, *(int(rng.integers(max(0, i - 4), i)) for i in range(1, 68))]
    return model_of(face_picture(), cells, parents, gain=0.05, **({"threshold": 1.5, "interval": 5} | changes)), cells
