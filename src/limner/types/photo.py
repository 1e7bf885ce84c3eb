"""A picture that is looked at: pixels, upright."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from limner.errors import BadInput
from limner.types.values import Value, frozen_array


@dataclass(frozen=True, eq=False)
class Photo(Value):
    """A picture, already upright.

    Attributes:
        rgb: (H, W, 3) uint8, sRGB.
    """

    rgb: NDArray[np.uint8]

    def __post_init__(self) -> None:
        self._freeze("rgb", frozen_array(self.rgb, np.uint8, (None, None, 3), "Photo.rgb"))
        if 0 in self.rgb.shape:
            raise BadInput(f"Photo.rgb: expected at least one pixel, got {self.rgb.shape[1]} x {self.rgb.shape[0]}")

    @property
    def size_px(self) -> tuple[int, int]:
        """Width and height."""
        return self.rgb.shape[1], self.rgb.shape[0]
