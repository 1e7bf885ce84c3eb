"""What can be chosen about the painting: its manner, and how a pen draws brush strokes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from limner.settings import SettingsGroup, setting


class Manner(NamedTuple):
    """How somebody paints (Hertzmann 1998, section 3).

    Attributes:
        threshold: how far a place may be off [RGB, 0 to 255] before it is painted again with a smaller brush.
        brushes: radii, the largest first [outer-eye distances].
        bend: 1 to follow the picture's direction at once, less to keep on as the stroke came.
        blur: of the picture that a brush paints, against its radius.
        opacity: of a layer.
        grid: distance of strokes, against the radius.
        shortest, longest: steps of a stroke, each as long as its radius; 0 for a dab.
        hue, saturation, value: chance in the colours, 0 to 1.
        rgb: chance in red, green and blue, 0 to 1.
    """

    threshold: float
    brushes: tuple[float, ...]
    bend: float
    blur: float
    opacity: float
    grid: float
    shortest: int
    longest: int
    hue: float = 0.0
    saturation: float = 0.0
    value: float = 0.0
    rgb: float = 0.0


_BRUSHES = (0.14, 0.07, 0.035, 0.018, 0.011)

MANNERS = {
    "impressionist": Manner(60, _BRUSHES, 1.0, 0.5, 1.0, 1.0, 3, 14, value=0.06),
    "expressionist": Manner(45, _BRUSHES, 0.25, 0.5, 0.75, 1.0, 8, 18, saturation=0.25, value=0.3),
    "wash": Manner(110, _BRUSHES, 1.0, 0.5, 0.55, 1.0, 4, 16, rgb=0.15),
    "pointillist": Manner(55, (0.06, 0.035, 0.022), 1.0, 0.5, 1.0, 0.75, 0, 0, hue=0.1, saturation=0.35, value=0.25),
}
"""Impressionist, expressionist, colorist wash and pointillist."""


@dataclass(frozen=True)
class PainterlySettings(SettingsGroup):
    """Brush strokes from coarse to fine, finest where the face has its features."""

    manner: str = setting("impressionist", "How it is painted", choices=tuple(MANNERS))
    detail: float = setting(
        2.5, "how much more a fault counts on the features than elsewhere on the face", low=0.1, high=20
    )
    background: float = setting(0.45, "and how much on the background", low=0, high=20)
    pens: int = setting(4, "Inks of the drawing, the first of them black; with 1 all is drawn in black", low=1, high=12)
    closest: float = setting(
        0.024, "lines of the drawing are never closer than this", unit="outer-eye distances", low=0.005, high=1
    )
    seed: int = setting(0, "of the chance in colours and in the order of strokes", low=0, high=1_000_000)
