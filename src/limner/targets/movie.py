"""A drawing and the pen's motion in time go in; a film of the drawing as it is drawn comes out, as GIF or MP4."""

from __future__ import annotations

import io
import itertools
import math
import os
import tempfile
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from limner import storage
from limner.errors import BadInput
from limner.targets.animation import check_length
from limner.types import Drawing, Floats, PenPath

if TYPE_CHECKING:
    from PIL.Image import Image as Picture

LONGEST_PX = 640
"""Longer side of the picture."""

FRAMES_PER_S = {".gif": 20, ".mp4": 30}

HOLD_S = 1.5
"""How long the finished drawing stays at the end."""


_PEN_DOWN, _PEN_UP = (200, 30, 30), (150, 170, 200)
_MOST_INKS = 20
_FINE = 2  # sub-pixels to a pixel each way
_SHIFT = 4


def to_gif(drawing: Drawing, path: PenPath, seconds: float) -> bytes:
    """The film as an animated GIF that plays for ever.

    Args:
        drawing: what is drawn.
        path: when, as planned; its times are scaled to the film.
        seconds: length of the film, without the hold at its end.

    Raises:
        BadInput: as ``check_length``.
    """
    from PIL import Image

    rate = FRAMES_PER_S[".gif"]
    palette, none = _palette(drawing), Image.Dither.NONE
    pictures = frames(drawing, path, seconds, rate)
    indexed = [Image.fromarray(picture).quantize(palette=palette, dither=none) for picture in pictures]
    durations = [1000 // rate] * len(indexed)
    durations[-1] = int(HOLD_S * 1000)
    out = io.BytesIO()
    indexed[0].save(out, "GIF", save_all=True, append_images=indexed[1:], duration=durations, loop=0, optimize=False)
    return out.getvalue()


def to_mp4(drawing: Drawing, path: PenPath, seconds: float) -> bytes:
    """The film as MP4 (MPEG-4 video).

    Raises:
        BadInput: as ``to_gif``, or this OpenCV cannot write MP4.
    """
    rate = FRAMES_PER_S[".mp4"]
    return encode_mp4(frames(drawing, path, seconds, rate), rate)


def encode_mp4(pictures: Iterator[NDArray[np.uint8]], rate: float, hold_s: float = HOLD_S) -> bytes:
    """Pictures (H, W, 3) RGB, at least one, as MP4; the last one stays for ``hold_s``.

    Raises:
        BadInput: this OpenCV cannot write MP4.
    """
    import cv2

    with tempfile.TemporaryDirectory(prefix="limner-") as folder:
        file = os.path.join(folder, "film.mp4")
        picture = next(pictures)
        height, width = (side // 2 * 2 for side in picture.shape[:2])  # the format knows only even sides
        writer = cv2.VideoWriter(file, cv2.VideoWriter.fourcc(*"mp4v"), rate, (width, height))
        if not writer.isOpened():
            raise BadInput("movie: this OpenCV cannot write MP4; choose a GIF")
        last = picture
        for last in itertools.chain([picture], pictures):
            writer.write(np.ascontiguousarray(last[:height, :width, ::-1]))
        for _ in range(round(hold_s * rate)):
            writer.write(np.ascontiguousarray(last[:height, :width, ::-1]))
        writer.release()
        return storage.read_bytes(file)


def frames(drawing: Drawing, path: PenPath, seconds: float, rate: int) -> Iterator[NDArray[np.uint8]]:
    """Pictures (H, W, 3) RGB of the drawing, the last one finished; the pen as a dot, red on paper, pale above it."""
    import cv2

    check_length(seconds)
    scale = LONGEST_PX / max(drawing.page.width_mm, drawing.page.height_mm)
    width, height = (max(2, round(side * scale)) for side in (drawing.page.width_mm, drawing.page.height_mm))
    sheet = np.full((height * _FINE, width * _FINE, 3), 255, np.uint8)
    place = _to_px(path.position_mm, drawing, scale)
    times = np.linspace(path.t_s[0], path.t_s[-1], max(2, math.ceil(seconds * rate)))
    done = 0
    for t in times:
        ready = int(np.searchsorted(path.t_s, t, side="right"))
        _ink(sheet, place, path, (done, ready), drawing, scale)
        done = ready
        picture = np.asarray(cv2.resize(sheet, (width, height), interpolation=cv2.INTER_AREA), np.uint8)
        if t < times[-1]:
            _mark(picture, _to_px(path.at(t)[None], drawing, scale)[0], bool(path.down[min(ready, len(path.down) - 1)]))
        yield picture


def _to_px(position_mm: Floats, drawing: Drawing, scale: float) -> Floats:
    return np.stack([position_mm[:, 0], drawing.page.height_mm - position_mm[:, 1]], axis=1) * scale


def _ink(
    sheet: NDArray[np.uint8], place: Floats, path: PenPath, part: tuple[int, int], drawing: Drawing, scale: float
) -> None:
    """Draw the moves that end at the samples from ``part[0]`` up to ``part[1]``."""
    import cv2

    fixed = np.rint((place * _FINE - 0.5) * 2**_SHIFT).astype(np.int32)
    for k in range(max(part[0], 1), part[1]):
        if path.down[k]:
            pen = drawing.pens[drawing.layer[path.stroke[k]]]
            width = max(1, round(pen.width_mm * scale * _FINE))
            cv2.line(sheet, fixed[k - 1].tolist(), fixed[k].tolist(), pen.rgb, width, cv2.LINE_AA, _SHIFT)


def _mark(picture: NDArray[np.uint8], place: Floats, down: bool) -> None:
    import cv2

    centre = np.rint((place - 0.5) * 2**_SHIFT).astype(int).tolist()
    cv2.circle(picture, centre, 5 << _SHIFT, _PEN_DOWN if down else _PEN_UP, cv2.FILLED, cv2.LINE_AA, _SHIFT)


def _palette(drawing: Drawing) -> Picture:
    """Greys, and each colour of the pen on its way to white and black, and of the inks to white."""
    from PIL import Image

    greys = [(v, v, v) for v in np.linspace(0, 255, 32).astype(int).tolist()]
    mixed = [
        tuple(int(a + (b - a) * part) for a, b in zip(colour, ground, strict=True))
        for colour in (_PEN_DOWN, _PEN_UP)
        for ground in ((255, 255, 255), (0, 0, 0))
        for part in np.linspace(0, 0.9, 10)
    ]
    inks = [pen.rgb for pen in drawing.pens if pen.rgb != (0, 0, 0)][:_MOST_INKS]
    mixed += [tuple(255 - (255 - v) * k // 8 for v in ink) for ink in inks for k in range(1, 9)]
    picture = Image.new("P", (1, 1))
    picture.putpalette([value for colour in (greys + mixed + [greys[0]] * 256)[:256] for value in colour])
    return picture
