"""A number and a generator in, a made-up picture of things in which one might see a face, but that are none, out."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

Picture = NDArray[Any]
Random = np.random.Generator


def made_picture(kind: int, rng: Random, size: int) -> Picture:
    """A picture (size, size, 3) uint8 of the kind ``kind`` modulo ``len(KINDS)``, blurred and noisy as photos are."""
    picture = KINDS[kind % len(KINDS)](rng, size)
    blurred = cv2.GaussianBlur(picture, (0, 0), rng.uniform(0.4, 2))
    return np.clip(blurred + rng.normal(0, rng.uniform(0, 6), picture.shape), 0, 255).astype(np.uint8)


def _wall(rng: Random, size: int) -> Picture:
    """A wall lit from one side."""
    y, x = np.mgrid[:size, :size] / size
    light = rng.uniform(-60, 60) * x + rng.uniform(-60, 60) * y
    return np.asarray(np.clip(rng.uniform(60, 200, 3) + light[..., None], 0, 255), np.uint8)


def _colour(rng: Random) -> tuple[float, ...]:
    return tuple(rng.uniform(0, 255, 3).tolist())


def _facade(rng: Random, size: int) -> Picture:
    """A house: rows of windows, a door, a roof."""
    picture, columns, rows = _wall(rng, size), int(rng.integers(2, 7)), int(rng.integers(2, 6))
    pane, frame, width = _colour(rng), _colour(rng), int(rng.integers(1, 5))
    across, down = size / columns, size / (rows + 1)
    shape = (rng.uniform(0.3, 0.7) * across, rng.uniform(0.3, 0.7) * down)
    for row in range(rows):
        for column in range(columns):
            corner = ((column + 0.5) * across - shape[0] / 2, (row + 0.6) * down - shape[1] / 2)
            box = (*map(int, corner), *map(int, shape))
            cv2.rectangle(picture, box, pane, -1)
            cv2.rectangle(picture, box, frame, width)
    door = (int(rng.uniform(0.1, 0.7) * size), int(size - 0.8 * down), int(0.6 * across), int(0.8 * down))
    cv2.rectangle(picture, door, _colour(rng), -1)
    return picture


def _writing(rng: Random, size: int) -> Picture:
    """Lines of letters."""
    picture, scale = _wall(rng, size), rng.uniform(0.4, 3)
    ink, width, line = _colour(rng), int(rng.integers(1, 6)), int(40 * scale)
    for y in range(line, size + line, line):
        letters = "".join(chr(int(code)) for code in rng.integers(33, 126, 60))
        cv2.putText(picture, letters, (int(rng.integers(-40, 20)), y), int(rng.integers(0, 8)), scale, ink, width)
    return picture


def _wheels(rng: Random, size: int) -> Picture:
    """Pairs of rings with hubs and spokes over a bar, as on machines."""
    picture = _wall(rng, size)
    for _ in range(int(rng.integers(1, 7))):
        centre, radius = rng.uniform(0, size, 2), rng.uniform(0.04, 0.2) * size
        colour, axle = _colour(rng), np.array([rng.uniform(2.2, 4) * radius, 0])
        for hub in (centre, centre + axle):
            _wheel(picture, hub, radius, colour, rng)
        drop = np.array([0, 1.5 * radius])
        cv2.rectangle(picture, _point(centre + drop), _point(centre + 1.2 * drop + axle), colour, -1)
    return picture


def _wheel(picture: Picture, hub: NDArray[Any], radius: float, colour: tuple[float, ...], rng: Random) -> None:
    for share in rng.uniform(0.1, 1, 3):
        cv2.circle(picture, _point(hub), int(share * radius) + 1, colour, int(rng.integers(1, 6)), cv2.LINE_AA)
    for angle in np.arange(0, 2 * np.pi, rng.uniform(0.3, 1.6)):
        rim = hub + radius * np.array([np.cos(angle), np.sin(angle)])
        cv2.line(picture, _point(hub), _point(rim), colour, 2, cv2.LINE_AA)


def _leaves(rng: Random, size: int) -> Picture:
    """Leaves over each other, each with its vein and shadow."""
    picture, green = _wall(rng, size), rng.uniform(0, 1, 3)
    for _ in range(int(rng.integers(60, 300))):
        place, length = rng.uniform(0, size, 2), rng.uniform(0.03, 0.12) * size
        angle, colour = rng.uniform(0, 360), tuple((green * rng.uniform(30, 250)).tolist())
        axes = (int(length), int(length * rng.uniform(0.2, 0.5)) + 1)
        along = length * np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
        cv2.ellipse(picture, _point(place + 0.1 * length), axes, angle, 0, 360, (20.0, 20.0, 20.0), -1, cv2.LINE_AA)
        cv2.ellipse(picture, _point(place), axes, angle, 0, 360, colour, -1, cv2.LINE_AA)
        cv2.line(picture, _point(place - along), _point(place + along), (30.0, 30.0, 30.0), 1, cv2.LINE_AA)
    return picture


def _point(place: NDArray[Any]) -> tuple[int, int]:
    x, y = np.rint(place).astype(int).tolist()
    return x, y


KINDS: tuple[Callable[[Random, int], Picture], ...] = (_facade, _writing, _wheels, _leaves)
"""The kinds of pictures."""
