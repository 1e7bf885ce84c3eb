"""What draws, and on what: a pen and a sheet of paper, in millimetres."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from limner.errors import BadInput

_PEN_NAME = re.compile(r"[\w][\w .-]{0,39}", re.ASCII)


@dataclass(frozen=True)
class Pen:
    """What draws: the width of its line [mm], its colour (sRGB, 0 to 255) and what people call it."""

    width_mm: float = 0.5
    rgb: tuple[int, int, int] = (0, 0, 0)
    name: str = "black"

    def __post_init__(self) -> None:
        object.__setattr__(self, "width_mm", float(self.width_mm))
        rgb = tuple(int(value) for value in self.rgb)
        object.__setattr__(self, "rgb", rgb)
        if not 0.01 <= self.width_mm <= 50:
            raise BadInput(f"pen: a line width of {self.width_mm:g} mm, expected 0.01 to 50 mm")
        if len(rgb) != 3 or not all(0 <= value <= 255 for value in rgb):
            raise BadInput(f"pen: a colour of {rgb}, expected red, green and blue from 0 to 255")
        if not _PEN_NAME.fullmatch(self.name):
            raise BadInput(f"pen: the name '{self.name}', expected up to 40 letters, digits, spaces, dots, - and _")

    @property
    def hex(self) -> str:
        """The colour as #rrggbb."""
        return "#" + bytes(self.rgb).hex()


@dataclass(frozen=True)
class Page:
    """A sheet of paper [mm], with the margin that stays white on each side."""

    width_mm: float = 148.0
    height_mm: float = 210.0
    margin_mm: float = 10.0

    def __post_init__(self) -> None:
        for name in ("width_mm", "height_mm", "margin_mm"):
            value = float(getattr(self, name))
            object.__setattr__(self, name, value)
            if not np.isfinite(value):
                raise BadInput(f"page: {name} is {value}, expected a finite length")
        if not (1 <= self.width_mm <= 10_000 and 1 <= self.height_mm <= 10_000):
            raise BadInput(f"page: {self.width_mm:g} x {self.height_mm:g} mm, expected sides between 1 and 10000 mm")
        if not 0 <= self.margin_mm < min(self.width_mm, self.height_mm) / 2:
            raise BadInput(
                f"page: a margin of {self.margin_mm:g} mm leaves nothing of {self.width_mm:g} x {self.height_mm:g} mm;"
                " choose a smaller one"
            )
