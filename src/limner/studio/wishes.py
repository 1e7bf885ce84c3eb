"""What the page wishes for, as plain JSON, goes in; checked settings and faces come out, or a line that says why."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from limner.errors import BadInput
from limner.motion.machine import MACHINES
from limner.pipeline import Settings
from limner.types import Face, Floats
from limner.vision.refine.shape import shipped_shape

ABOUT = {path: about for path, about, _ in Settings.walk()}
"""Every setting of the tree by its path."""

FILES = tuple(path for path in ABOUT if path.endswith((".model", ".file", ".boxes", ".trust")))
"""Settings that name files of this computer: the page may not."""


def settings_of(base: Settings, values: Any) -> Settings:
    """Settings with some changed.

    Args:
        base: what is not changed.
        values: path -> value, as JSON has them; null for not set.

    Raises:
        BadInput: no such setting, a value outside its limits, or a file of this computer.
    """
    if not isinstance(values, Mapping):
        raise BadInput("settings: expected an object of path: value")
    tree = base.to_dict()
    for path, value in values.items():
        if path not in ABOUT:
            raise BadInput(f"settings: {str(path)[:80]} does not exist")
        if path in FILES or (path == "detect.detector" and value == "file"):
            raise BadInput(f"settings: {path} names a file of this computer; it is set with --settings alone")
        if path == "machine" and value != base.machine and value not in MACHINES:
            raise BadInput(f"settings: machine = {str(value)[:80]!r}, choose {', '.join(MACHINES)}")
        *groups, name = path.split(".")
        place = tree
        for group in groups:
            place = place[group]
        place[name] = value
    return Settings.from_dict(tree)


def face_of(points: Any, size_px: tuple[int, int]) -> Face:
    """A face of 68 landmarks placed by hand, [[x, y], ...] in pixels.

    Raises:
        BadInput: something else, or far outside the photo.
    """
    try:
        placed = np.array(points, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise BadInput("points_px: expected 68 places [x, y] in pixels") from error
    if placed.shape != (68, 2) or not np.isfinite(placed).all():
        raise BadInput("points_px: expected 68 places [x, y] in pixels")
    if (np.abs(placed) > 4 * max(size_px)).any():
        raise BadInput("points_px: places far outside the photo; bring them back onto it")
    low, high = placed.min(0), placed.max(0)
    return Face(placed, np.concatenate([low, np.maximum(high, low + 1)]), detector="hand")


def template(box: Any) -> Floats:
    """The mean of all faces, upright in a box x0, y0, x1, y1 [px]: (68, 2).

    Raises:
        BadInput: no such box.
    """
    try:
        x0, y0, x1, y1 = (float(value) for value in box)
    except (TypeError, ValueError, OverflowError) as error:
        raise BadInput("box_px: expected four numbers x0, y0, x1, y1 in pixels") from error
    if not (np.abs([x0, y0, x1, y1]).max() < 1e6 and x1 - x0 >= 8 and y1 - y0 >= 8):
        raise BadInput("box_px: expected x0 < x1 and y0 < y1, at least 8 px apart")
    mean = shipped_shape().mean
    low, high = mean.min(0), mean.max(0)
    # As large as fits without being stretched.
    scale = min((x1 - x0) / (high[0] - low[0]), (y1 - y0) / (high[1] - low[1]))
    placed: Floats = (mean - (low + high) / 2) * scale + [(x0 + x1) / 2, (y0 + y1) / 2]
    return placed
