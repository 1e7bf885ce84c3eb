"""Strokes on a page, in millimetres, in the order in which they are drawn."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from limner.errors import BadInput
from limner.types.lines import checked_layers, checked_lines, checked_pens, checked_regions, first_layer
from limner.types.page import Page, Pen
from limner.types.values import Floats, Value, frozen_array


@dataclass(frozen=True, eq=False)
class Drawing(Value):
    """Strokes on a page, in the order in which they are drawn.

    Attributes:
        lines_mm: tuple of (n, 2), page frame; closed when first = last.
        region: of each line, one of ``REGIONS``.
        weight: (lines,) how much the drawing would miss it, >= 0.
        page: the sheet.
        pens: what draws, in the order in which they are used.
        layer: (lines,) index of each line's pen, never less than the line's before: a pen is put in once; none given:
            the first.
    """

    lines_mm: tuple[Floats, ...]
    region: tuple[str, ...]
    weight: Floats
    page: Page = field(default_factory=Page)
    pens: tuple[Pen, ...] = (Pen(),)
    layer: NDArray[np.int64] = field(default_factory=first_layer)

    def __post_init__(self) -> None:
        self._freeze("lines_mm", checked_lines(self.lines_mm, "Drawing.lines_mm"))
        self._freeze("region", checked_regions(self.region, len(self.lines_mm), "Drawing.region"))
        self._freeze("weight", frozen_array(self.weight, np.float64, (len(self.lines_mm),), "Drawing.weight"))
        self._freeze("pens", checked_pens(self.pens, "Drawing.pens"))
        self._freeze("layer", checked_layers(self.layer, len(self.lines_mm), len(self.pens), "Drawing.layer"))
        if (np.diff(self.layer) < 0).any():
            raise BadInput("Drawing.layer: expected the lines of each pen together, in the order of the pens")

    @property
    def points(self) -> int:
        """Vertices the machine must go to."""
        return sum(len(line) for line in self.lines_mm)

    @property
    def pen(self) -> Pen:
        """The widest of the pens, the first of those."""
        return max(self.pens, key=lambda pen: pen.width_mm)

    def pick(self, which: Sequence[int]) -> Drawing:
        """The drawing of some of its lines, in this order, which must keep each pen's together."""
        return dataclasses.replace(
            self,
            lines_mm=tuple(self.lines_mm[i] for i in which),
            region=tuple(self.region[i] for i in which),
            weight=self.weight[list(which)],
            layer=self.layer[list(which)],
        )

    def by_pen(self) -> list[Drawing]:
        """The drawing of each pen that draws something, one after the other."""
        return [self.pick(np.flatnonzero(self.layer == k).tolist()) for k in np.unique(self.layer).tolist()]

    def changes(self) -> NDArray[np.bool_]:
        """(lines,) whether another pen is put in before the line."""
        changed: NDArray[np.bool_] = np.diff(self.layer, prepend=self.layer[:1]) > 0
        return changed
