"""A film or a camera goes in; its pictures as a cartoon, one after the other and steady in time, come out."""

from __future__ import annotations

import os
from collections.abc import Iterator

import cv2
import numpy as np
from numpy.typing import NDArray

from limner.errors import BadInput
from limner.vision.cartoon.abstraction import UNIT_PX, AbstractionSettings, abstract
from limner.vision.raster import Image

CAMERA = "camera:"
"""What stands before the number of a camera."""

HEIGHT_PX = 480
"""A picture of this height is simplified as one whose face has the working scale."""

RATE = 25.0
"""Frames per second of a film that does not say."""

_MOVED = 28.0  # grey levels by which a pixel changes when something has moved there
_SLOWEST = 0.3


def frames(source: str, width_px: int | None = None) -> tuple[float, Iterator[NDArray[np.uint8]]]:
    """Open a film, or a camera by its number.

    Args:
        source: a file, or camera:0.
        width_px: pictures are scaled to it; not given: as they are.

    Returns:
        Frames per second, and the pictures (H, W, 3) sRGB.

    Raises:
        BadInput: no such camera, or no film that OpenCV reads.
    """
    number = source.removeprefix(CAMERA)
    if source.startswith(CAMERA) and not number.isdecimal():
        raise BadInput(f"{source}: no camera; expected camera:0, camera:1, ...")
    if not source.startswith(CAMERA) and not os.path.isfile(source):
        raise BadInput(f"{source}: no such file; expected a film, or camera:0")
    stream = cv2.VideoCapture(int(number)) if source.startswith(CAMERA) else cv2.VideoCapture(source)
    if not stream.isOpened():
        raise BadInput(f"{source}: cannot be opened as a film; expected MP4, AVI, ... or camera:0")
    rate = float(stream.get(cv2.CAP_PROP_FPS))
    return (rate if 1 <= rate <= 240 else RATE), _read(stream, width_px)


def _read(stream: cv2.VideoCapture, width_px: int | None) -> Iterator[NDArray[np.uint8]]:
    try:
        while True:
            more, picture = stream.read()
            if not more:
                return
            if width_px is not None:
                size = width_px, max(1, round(picture.shape[0] * width_px / picture.shape[1]))
                picture = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
            yield np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2RGB), np.uint8)
    finally:
        stream.release()


def cartoon_frames(pictures: Iterator[NDArray[np.uint8]], settings: AbstractionSettings) -> Iterator[NDArray[np.uint8]]:
    """Each picture (H, W, 3) made simple; where nothing moves the noise of the frames before averages out."""
    still: Image | None = None
    for picture in pictures:
        still = steadied(still, picture)
        seen = np.asarray(np.rint(still), np.uint8)
        yield abstract(seen, settings, UNIT_PX * picture.shape[0] / HEIGHT_PX).rgb()


def steadied(still: Image | None, picture: NDArray[np.uint8]) -> Image:
    """The picture before (H, W, 3) on its way to the next: at once where something moves, slowly where it is noise."""
    fresh = picture.astype(np.float32)
    if still is None or still.shape != fresh.shape:
        return fresh
    change = fresh - still
    moved = np.asarray(cv2.blur(np.abs(change).max(axis=2), (5, 5)), np.float32)
    pace = np.clip(moved / np.float32(_MOVED), np.float32(_SLOWEST), np.float32(1))
    return np.asarray(still + pace[..., None] * change, np.float32)
