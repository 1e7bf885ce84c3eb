"""Photo and face in; the face with its brows moved to the darkest or to their upper edge, out (thesis 3.3.2)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from limner.settings import SettingsGroup, setting
from limner.types import Face, Floats, Photo
from limner.vision.raster import Image, blurred
from limner.vision.refine.ground import UNIT_PX, grey_face, put_back, read

BROWS = np.arange(17, 27)
_STEP_PX = 0.5


@dataclass(frozen=True)
class BrowsSettings(SettingsGroup):
    """How far below its landmarks the brow is looked for; lengths in outer-eye distances."""

    reach: float = setting(0.09, "how far down the darkest is looked for", unit="outer-eye distances", low=0, high=1)
    blur: float = setting(0.015, "blur before the darkest is taken", unit="outer-eye distances", low=0, high=0.2)
    edge: str = setting(
        "darkest",
        "where the landmarks go: the brow's darkest line, as in the thesis, or its upper edge, where iBUG's lie",
        choices=("darkest", "upper"),
    )
    thickness: float = setting(
        0.08, "how far above the darkest the upper edge is looked for", unit="outer-eye distances", low=0, high=1
    )


def brows(photo: Photo, face: Face, settings: BrowsSettings) -> Face:
    """Move each landmark of the brows to the darkest place below it, the forehead being brighter than the brow.

    The upper edge is where, from there upward, half of the way to the forehead's brightness is reached.

    Raises:
        BadInput: a profile, a face of a few pixels, or one that lies outside the photo.
    """
    grey = grey_face(photo, face)
    smooth = blurred(grey.image, settings.blur * UNIT_PX) if settings.blur > 0 else grey.image
    values, grid = _along(smooth, grey.points[BROWS], grey.down, settings.reach)
    darkest = grid[np.arange(len(BROWS)), values.argmin(axis=1)]
    if settings.edge == "darkest":
        return put_back(photo, face, grey, BROWS, darkest)
    values, grid = _along(smooth, darkest, -grey.down, settings.thickness)
    half = (values[:, 0] + values.max(axis=1)) / 2
    upper = grid[np.arange(len(BROWS)), (values >= half[:, None]).argmax(axis=1)]
    return put_back(photo, face, grey, BROWS, upper)


def _along(image: Image, points: Floats, way: Floats, reach: float) -> tuple[Floats, Floats]:
    """What the picture holds from points on in a direction (n, steps), and at which places (n, steps, 2)."""
    steps = _STEP_PX * np.arange(int(reach * UNIT_PX / _STEP_PX) + 1)
    grid = points[:, None] + steps[:, None] * way
    return np.round(read(image, grid), 6), grid
