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


def _ground(rng: Random, size: int) -> Picture:
    """A plain ground lit from one side, or clouds."""
    if rng.random() < 0.3:
        return _clouds(rng, size)
    y, x = np.mgrid[:size, :size][..., None] / size
    ground: Picture = rng.uniform(40, 220, 3) + rng.uniform(-50, 50) * x + rng.uniform(-50, 50) * y
    return ground


def _panes(rng: Random, size: int) -> Picture:
    """Rows of framed panes, some of them missing or of another size, as on walls, shelves and front plates."""
    picture, colours = _ground(rng, size), [_colour(rng) for _ in range(3)]
    counts, frame = rng.integers(2, 8, 2), int(rng.integers(1, 6))
    pitch, share = size / counts, rng.uniform(0.25, 0.85, 2)
    for place in np.ndindex(*counts):
        if rng.random() < 0.15:
            continue
        low = (np.array(place) + 0.5) * pitch
        half = pitch * share / 2 * (1 if rng.random() < 0.8 else rng.uniform(0.5, 1.5))
        box = (*(low - half).astype(int).tolist(), *(2 * half).astype(int).tolist())
        cv2.rectangle(picture, box, colours[0], -1)
        cv2.rectangle(picture, box, colours[1], frame)
        if share[0] > 0.5:
            middle = (int(low[0]), int(low[1] - half[1])), (int(low[0]), int(low[1] + half[1]))
            cv2.line(picture, *middle, colours[2], frame)
    return picture


def _rings(rng: Random, size: int) -> Picture:
    """Rings and discs in pairs, above bars: knobs, lamps, wheels."""
    picture = _ground(rng, size)
    for _ in range(int(rng.integers(2, 12))):
        radius, place, colour = rng.uniform(0.02, 0.15) * size, rng.uniform(0, size, 2), _colour(rng)
        apart = np.array([rng.uniform(2, 5) * radius, 0])
        for centre in (place, place + apart):
            for share in rng.uniform(0.1, 1, int(rng.integers(1, 4))):
                width = -1 if rng.random() < 0.3 else int(rng.integers(1, 6))
                cv2.circle(picture, centre.astype(int).tolist(), int(share * radius) + 1, colour, width, cv2.LINE_AA)
        drop = np.array([0, rng.uniform(1, 3) * radius])
        ends = (place + drop).astype(int).tolist(), (place + drop + apart).astype(int).tolist()
        cv2.line(picture, *ends, _colour(rng), int(rng.integers(1, 9)), cv2.LINE_AA)
    return picture


def _signs(rng: Random, size: int) -> Picture:
    """Lines of signs, each of a few short strokes: a kind of writing."""
    picture, ink, height = _ground(rng, size), _colour(rng), rng.uniform(0.03, 0.2) * size
    width = max(1, int(height * rng.uniform(0.05, 0.2)))
    for y in np.arange(0.3 * height, size, 1.5 * height):
        for x in np.arange(0.2 * height, size, rng.uniform(0.7, 1) * height):
            strokes = (rng.uniform(0, 1, (int(rng.integers(1, 4)), 3, 2)) * [0.6, 1] * height + (x, y)).astype(np.int32)
            cv2.polylines(picture, list(strokes), rng.random() < 0.3, ink, width, cv2.LINE_AA)
    return picture


def _colour(rng: Random) -> tuple[float, ...]:
    return tuple(rng.uniform(0, 255, 3).tolist())


KINDS: tuple[Callable[[Random, int], Picture], ...] = (
    _clouds,
    _stripes,
    _checks,
    _ellipses,
    _polygons,
    _scribbles,
    _panes,
    _rings,
    _signs,
)
"""The kinds of pictures."""
