"""What can be chosen about the cartoon, for its picture and for its strokes."""

from __future__ import annotations

from dataclasses import dataclass

from limner.settings import SettingsGroup, group, setting
from limner.vision.cartoon.abstraction import AbstractionSettings


@dataclass(frozen=True)
class CartoonSettings(SettingsGroup):
    """The abstracted picture, and its edges, tone borders and tones as strokes."""

    abstraction: AbstractionSettings = group(AbstractionSettings)
    pens: int = setting(4, "Inks, the first of them black; with 1 all is drawn in black", low=1, high=12)
    edge: float = setting(0.2, "ink of the picture's edges from which they are drawn", low=0.01, high=0.99)
    borders: int = setting(3, "Levels of darkness whose borders are drawn; 0 draws none", low=0, high=12)
    fill: bool = setting(True, "hatch what is dark or coloured, each ink in its own direction")
    closest: float = setting(0.027, "hatching is never closer than this", unit="outer-eye distances", low=0.005, high=1)
    widest: float = setting(0.08, "hatching ends where it would be wider", unit="outer-eye distances", low=0.01, high=1)
