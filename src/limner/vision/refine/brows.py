"""Photo and face in; the face with its brows moved down to the darkest, out (thesis 3.3.2)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from limner.settings import SettingsGroup, setting
from limner.types import Face, Photo
from limner.vision.raster import blurred
from limner.vision.refine.ground import UNIT_PX, grey_face, put_back, read

BROWS = np.arange(17, 27)
_STEP_PX = 0.5


@dataclass(frozen=True)
class BrowsSettings(SettingsGroup):
    """How far below its landmarks the brow is looked for; lengths in outer-eye distances."""

    reach: float = setting(0.09, "how far down the darkest is looked for", unit="outer-eye distances", low=0, high=1)
    blur: float = setting(0.015, "blur before the darkest is taken", unit="outer-eye distances", low=0, high=0.2)


def brows(photo: Photo, face: Face, settings: BrowsSettings) -> Face:
    """Move each landmark of the brows to the darkest place below it, the forehead being brighter than the brow.

    Raises:
        BadInput: a profile, a face of a few pixels, or one that lies outside the photo.
    """
    grey = grey_face(photo, face)
    smooth = blurred(grey.image, settings.blur * UNIT_PX) if settings.blur > 0 else grey.image
    down = _STEP_PX * np.arange(int(settings.reach * UNIT_PX / _STEP_PX) + 1)
    grid = grey.points[BROWS][:, None] + down[:, None] * grey.down
    darkest = np.round(read(smooth, grid), 6).argmin(axis=1)
    return put_back(photo, face, grey, BROWS, grid[np.arange(len(BROWS)), darkest])
