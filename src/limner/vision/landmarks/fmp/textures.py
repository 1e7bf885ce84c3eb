"""A number and a generator in, a made-up picture that holds no face out."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

Picture = NDArray[Any]
Random = np.random.Generator


def texture(kind: int, rng: Random, size: int) -> Picture:
    """A picture (size, size, 3) uint8 of the kind ``kind`` modulo ``len(KINDS)``, with a little noise."""
    picture = KINDS[kind % len(KINDS)](rng, size)
    noisy = picture + rng.normal(0, rng.uniform(0, 8), picture.shape)
    return np.clip(noisy, 0, 255).astype(np.uint8)


def _clouds(rng: Random, size: int) -> Picture:
    """Noise whose strength falls with frequency, as in photos."""
    frequency = np.hypot(*np.meshgrid(np.fft.fftfreq(size), np.fft.rfftfreq(size), indexing="ij"))
    strength = 1 / np.maximum(frequency, 1 / size) ** rng.uniform(0.8, 2)
    planes = [np.fft.irfft2(np.fft.rfft2(rng.normal(size=(size, size))) * strength, (size, size)) for _ in range(3)]
    picture = np.stack(planes, axis=-1)
    clouds: Picture = 128 + 45 * (picture - picture.mean()) / picture.std()
    return clouds


def _stripes(rng: Random, size: int) -> Picture:
    picture = np.full((size, size, 3), 128.0)
    y, x = np.mgrid[:size, :size]
    for _ in range(int(rng.integers(1, 4))):
        angle, period = rng.uniform(0, np.pi), rng.uniform(6, 90)
        bend = 3 * np.sin(y / rng.uniform(20, 90))
        wave = np.sin((x * np.cos(angle) + y * np.sin(angle)) * 2 * np.pi / period + bend)
        picture += rng.uniform(10, 60, 3) * (np.sign(wave) if rng.random() < 0.5 else wave)[..., None]
    return picture


def _checks(rng: Random, size: int) -> Picture:
    cells = int(rng.integers(4, 40))
    small = rng.uniform(0, 255, (cells, cells, 3)) if rng.random() < 0.5 else _chess(rng, cells)
    large = cv2.resize(small, (size, size), interpolation=cv2.INTER_NEAREST)
    turn = cv2.getRotationMatrix2D((size / 2, size / 2), rng.uniform(-30, 30), rng.uniform(1, 2))
    return cv2.warpAffine(large, turn, (size, size), borderMode=cv2.BORDER_REFLECT)


def _chess(rng: Random, cells: int) -> Picture:
    dark, light = rng.uniform(0, 255, (2, 3))
    board: Picture = np.where((np.indices((cells, cells)).sum(axis=0) % 2)[..., None] == 0, dark, light)
    return board


def _ellipses(rng: Random, size: int) -> Picture:
    picture = _clouds(rng, size)
    for _ in range(int(rng.integers(10, 80))):
        centre, axes = rng.integers(0, size, 2).tolist(), rng.integers(3, size // 4, 2).tolist()
        width = -1 if rng.random() < 0.5 else int(rng.integers(1, 8))
        cv2.ellipse(picture, centre, axes, float(rng.uniform(0, 180)), 0, 360, _colour(rng), width, cv2.LINE_AA)
    return picture


def _polygons(rng: Random, size: int) -> Picture:
    picture = _clouds(rng, size)
    for _ in range(int(rng.integers(5, 50))):
        corners = rng.integers(0, size, 2) + rng.integers(-size // 5, size // 5, (int(rng.integers(3, 7)), 2))
        cv2.fillPoly(picture, [corners.astype(np.int32)], _colour(rng), cv2.LINE_AA)
    return picture


def _scribbles(rng: Random, size: int) -> Picture:
    picture = _clouds(rng, size)
    for _ in range(int(rng.integers(5, 60))):
        path = np.cumsum(rng.normal(0, size / 25, (int(rng.integers(3, 40)), 2)), axis=0) + rng.uniform(0, size, 2)
        width = int(rng.integers(1, 9))
        cv2.polylines(picture, [path.astype(np.int32)], False, _colour(rng), width, cv2.LINE_AA)
    return picture


def _colour(rng: Random) -> tuple[float, ...]:
    return tuple(rng.uniform(0, 255, 3).tolist())


KINDS: tuple[Callable[[Random, int], Picture], ...] = (_clouds, _stripes, _checks, _ellipses, _polygons, _scribbles)
"""The kinds of pictures."""
