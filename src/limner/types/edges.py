"""Pixels of a photo that may be line: where, how sure, in which direction."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from limner.errors import BadInput
from limner.types.values import Floats, Value, frozen_array


@dataclass(frozen=True, eq=False)
class EdgeMap(Value):
    """Pixels that may be line.

    Attributes:
        mask: (H, W) bool.
        strength: (H, W) in [0, 1], how sure.
        angle_rad: (H, W) in [0, pi), the direction of the line (the tangent), from x towards y (down).
    """

    mask: NDArray[np.bool_]
    strength: Floats
    angle_rad: Floats

    def __post_init__(self) -> None:
        self._freeze("mask", frozen_array(self.mask, np.bool_, (None, None), "EdgeMap.mask"))
        height, width = self.mask.shape
        for name in ("strength", "angle_rad"):
            array = frozen_array(getattr(self, name), np.float64, (height, width), f"EdgeMap.{name}")
            self._freeze(name, array)
        if self.strength.size and not (self.strength.min() >= 0 and self.strength.max() <= 1):
            raise BadInput("EdgeMap.strength: expected values in [0, 1]")
        if self.angle_rad.size and not (self.angle_rad.min() >= 0 and self.angle_rad.max() < np.pi):
            raise BadInput("EdgeMap.angle_rad: expected values in [0, pi)")
