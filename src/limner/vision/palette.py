"""Colours of a picture go in; a few inks for them, and what people call those, come out."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from limner.types import Floats, Pen
from limner.vision.raster import Image

_SAMPLES = 4000
_ROUNDS = 25

_NAMES = {
    "black": (0, 0, 0),
    "grey": (128, 128, 128),
    "brown": (110, 65, 35),
    "dark brown": (60, 35, 20),
    "ochre": (190, 130, 60),
    "skin": (205, 150, 120),
    "red": (200, 40, 40),
    "dark red": (120, 25, 30),
    "orange": (230, 120, 40),
    "yellow": (230, 200, 60),
    "olive": (115, 115, 50),
    "green": (60, 140, 60),
    "turquoise": (50, 150, 150),
    "light blue": (120, 165, 210),
    "blue": (45, 80, 180),
    "dark blue": (25, 35, 80),
    "violet": (120, 70, 150),
    "pink": (220, 130, 150),
}


def to_lab(rgb: NDArray[np.uint8]) -> Image:
    """CIELab (H, W, 3) of sRGB: lightness 0 to 100, a* and b*."""
    return np.asarray(cv2.cvtColor(rgb.astype(np.float32) / np.float32(255), cv2.COLOR_RGB2LAB), np.float32)


def to_rgb(lab: Image) -> NDArray[np.uint8]:
    """Colours (H, W, 3) in sRGB of CIELab; what a screen cannot show is clipped."""
    rgb = np.asarray(cv2.cvtColor(lab.astype(np.float32), cv2.COLOR_LAB2RGB))
    return np.asarray(np.rint(np.clip(rgb, 0, 1) * 255), np.uint8)


def inks(lab: Floats, count: int, darkest: float, lightest: float) -> Floats:
    """The colours (count, 3) in CIELab of the inks with which some colours (n, 3) are best drawn, dark to light.

    Lloyd's clusters, begun with the colours farthest from those before, so that there is no chance in it. An ink is
    more lively and darker than what it stands for, since paper shows between its lines.

    Args:
        lab: colours to be drawn.
        count: of the inks, at least one.
        darkest: the least lightness of an ink, so that none is another black.
        lightest: the most, so that it is seen on paper.
    """
    some = lab[:: max(1, len(lab) // _SAMPLES)] * [0.6, 1, 1]
    centres = [some[np.argmin(some[:, 0])]] if len(some) else [np.zeros(3)]
    while len(centres) < count:
        far = np.min([((some - centre) ** 2).sum(axis=1) for centre in centres], axis=0) if len(some) else np.zeros(1)
        # Not the very farthest, which is an odd pixel.
        centres.append(some[np.argsort(far, kind="stable")[int(0.97 * (len(far) - 1))]] if len(some) else np.zeros(3))
    places = np.array(centres)
    for _ in range(_ROUNDS if len(some) else 0):
        label = nearest(some, places)
        places = np.array([some[label == k].mean(axis=0) if (label == k).any() else places[k] for k in range(count)])
    places = places[np.argsort(places[:, 0], kind="stable")] / [0.6, 1, 1]
    lightness = np.clip(places[:, :1] * 0.75, darkest, lightest)
    return np.concatenate([lightness, places[:, 1:] * 1.35], axis=1)


def nearest(lab: Floats, centres: Floats) -> NDArray[np.int64]:
    """Which of some colours (k, 3) is nearest to each of many (n, 3)."""
    found: NDArray[np.int64] = np.argmin([((lab - centre) ** 2).sum(axis=1) for centre in centres], axis=0)
    return found


def to_pens(lab: Floats) -> tuple[Pen, ...]:
    """Pens of some colours (n, 3), each named after the nearest colour that has a name, no two alike."""
    known = to_lab(np.array([list(_NAMES.values())], np.uint8))[0].astype(np.float64)
    pens: list[Pen] = []
    for colour, rgb in zip(lab, to_rgb(lab[None].astype(np.float32))[0].tolist(), strict=True):
        name = list(_NAMES)[int(nearest(colour[None], known)[0])]
        same = sum(pen.name.split(" no ")[0] == name for pen in pens)
        pens.append(Pen(rgb=tuple(rgb), name=f"{name} no {same + 1}" if same else name))
    return tuple(pens)
