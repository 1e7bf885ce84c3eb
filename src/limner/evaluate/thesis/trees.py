"""A face model goes in; its trees of parts, one for each view, come out as a picture (figure 3.4)."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from limner.targets.sheet import Tile, to_sheet
from limner.types import Floats
from limner.vision.landmarks.fmp.model import Component, FmpModel

_SIZE_PX = 620
_SHIFT = 4
_BRANCH, _PART, _ROOT = (120, 126, 138), (30, 90, 160), (200, 60, 30)


def trees(model: FmpModel, most: int = 3) -> NDArray[np.uint8]:
    """Each part at rest, joined to its parent, the root in red; of many views the outer and the middle ones.

    Args:
        model: with one view or more.
        most: views that are shown.
    """
    chosen = np.unique(np.linspace(0, len(model.components) - 1, min(most, len(model.components))).round().astype(int))
    shown = [model.components[k] for k in chosen]
    tiles = [Tile(_tree(one), f"{model.name}, yaw {one.yaw_deg:g}\N{DEGREE SIGN}", _about(one)) for one in shown]
    return to_sheet(tiles, columns=len(tiles), tile_px=480)


def _about(component: Component) -> str:
    return f"{len(component.parents)} parts"


def _tree(component: Component) -> NDArray[np.uint8]:
    picture = np.full((_SIZE_PX, _SIZE_PX, 3), 255, np.uint8)
    places = _fitted(component.rest_cells)
    for part, parent in enumerate(component.parents.tolist()):
        if parent >= 0:
            cv2.line(picture, places[part], places[parent], _BRANCH, 2, cv2.LINE_AA, _SHIFT)
    for part, place in enumerate(places):
        cv2.circle(
            picture, place, (8 if part == 0 else 5) << _SHIFT, _ROOT if part == 0 else _PART, -1, cv2.LINE_AA, _SHIFT
        )
    return picture


def _fitted(cells: Floats) -> list[list[int]]:
    low, high = cells.min(axis=0), cells.max(axis=0)
    scale = 0.86 * _SIZE_PX / float((high - low).max())
    placed = (cells - (low + high) / 2) * scale + _SIZE_PX / 2
    fixed: list[list[int]] = np.rint(placed * 2**_SHIFT).astype(np.int64).tolist()
    return fixed
