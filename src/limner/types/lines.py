"""Lines, and what is said of each (region, pen), go in; the same, frozen and checked, come out."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from limner.errors import BadInput
from limner.types.page import Pen
from limner.types.values import Floats, frozen_array

REGIONS = ("eye", "brow", "nose", "mouth", "jaw", "ear", "hair", "face", "body", "background")
"""What a stroke belongs to; ``face`` is skin between the features."""


def checked_lines(lines: Sequence[ArrayLike], name: str) -> tuple[Floats, ...]:
    """Polylines as read-only (n, 2) arrays.

    Args:
        lines: each (n, 2), at least one point.
        name: of the field, for the message.

    Raises:
        BadInput: another shape, or a line without a point.
    """
    frozen = tuple(frozen_array(line, np.float64, (None, 2), f"{name}[{i}]") for i, line in enumerate(lines))
    for i, line in enumerate(frozen):
        if len(line) < 1:
            raise BadInput(f"{name}[{i}]: expected at least one point, got none")
    return frozen


def checked_regions(regions: Sequence[str], n: int, name: str) -> tuple[str, ...]:
    """The regions of ``n`` lines, each one of ``REGIONS``; ``BadInput`` names the field otherwise."""
    regions = tuple(regions)
    if len(regions) != n:
        raise BadInput(f"{name}: expected one for each of {n} lines, got {len(regions)}")
    for region in regions:
        if region not in REGIONS:
            raise BadInput(f"{name}: expected one of {', '.join(REGIONS)}, got '{region}'")
    return regions


def checked_pens(pens: object, name: str) -> tuple[Pen, ...]:
    """At least one pen; ``BadInput`` names the field otherwise."""
    found = tuple(pen for pen in pens if isinstance(pen, Pen)) if isinstance(pens, Sequence) else ()
    if not isinstance(pens, Sequence) or not found or len(found) < len(pens):
        raise BadInput(f"{name}: expected a tuple of at least one pen")
    return found


def checked_layers(layer: ArrayLike, n: int, pens: int, name: str) -> NDArray[np.int64]:
    """(n,) index of each line's pen, of ``pens``; none given: the first. ``BadInput`` names the field otherwise."""
    given = frozen_array(np.zeros(n) if np.size(layer) == 0 else layer, np.int64, (n,), name)
    if n and not (given.min() >= 0 and given.max() < pens):
        raise BadInput(f"{name}: expected indices of {pens} pens, got {given.min()} to {given.max()}")
    return given


def first_layer() -> NDArray[np.int64]:
    """No index: every line is the first pen's."""
    return np.zeros(0, np.int64)
