"""A line through something dark goes in; how wide the dark is, and strokes side by side that fill it, come out."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from limner import geometry
from limner.types import Floats
from limner.vision.portrait.follow import STEP_PX, normals
from limner.vision.portrait.marks import runs
from limner.vision.portrait.seen import Seen

PEN_PX = 1.5
"""Distance of strokes that leave no paper between them."""

FINE_PX = 0.5
"""From sample to sample across the band."""


@dataclass(frozen=True, eq=False)
class Band:
    """Something dark along a line.

    Attributes:
        axis: (n, 2) the line [px].
        across: (n, 2) unit vectors to its side.
        low, high: (n,) from where to where the dark reaches, along ``across`` [px].
        contrast: (n,) how much darker it is than its brighter surroundings, in the unit of ``Seen.light``.
    """

    axis: Floats
    across: Floats
    low: Floats
    high: Floats
    contrast: Floats

    @property
    def width(self) -> Floats:
        """(n,) [px]."""
        return self.high - self.low

    def part(self, where: NDArray[np.int64]) -> Band:
        """Some stations of it."""
        return Band(*(getattr(self, field.name)[where] for field in dataclasses.fields(self)))

    def at(self, share: float) -> Floats:
        """The line (n, 2) that runs at a share of the width, 0 at the low side and 1 at the high one."""
        line: Floats = self.axis + (self.low + share * self.width)[:, None] * self.across
        return line


def measure(seen: Seen, line: Floats, reach: float) -> Band:
    """How far to both sides of a line it is darker than half-way to the light, up to ``reach`` [px]."""
    axis = geometry.resample(line, STEP_PX)
    across = normals(axis, 3)
    offsets = np.arange(0, reach + FINE_PX, FINE_PX)
    sides = [seen.at(seen.light, axis[:, None] + sign * offsets[:, None] * across[:, None]) for sign in (-1, 1)]
    dark = np.minimum(*(side[:, :4].min(axis=1) for side in sides))
    bright = [np.quantile(side, 0.9, axis=1) for side in sides]
    extents = [_first_above(side, (dark + light) / 2) * FINE_PX for side, light in zip(sides, bright, strict=True)]
    low, high = (_calm(extent) for extent in extents)
    return Band(axis, across, -low, high, _calm(np.minimum(*bright) - dark))


def _first_above(side: Floats, level: Floats) -> Floats:
    above = side > level[:, None]
    above[:, -1] = True
    first: Floats = above.argmax(axis=1).astype(np.float64)
    return first


def _calm(values: Floats, over: int = 5) -> Floats:
    """Without jumps: the median of some neighbours, then their mean."""
    windows = np.lib.stride_tricks.sliding_window_view(np.pad(values, over, mode="edge"), 2 * over + 1)
    middle = np.median(windows, axis=1)
    calm: Floats = np.convolve(np.pad(middle, 2, mode="edge"), np.ones(5) / 5, mode="valid")
    return calm


def fill(band: Band, pitch: float, most: int) -> list[Floats]:
    """Strokes along the band, side by side about ``pitch`` [px] apart, at most ``most``; one where it is narrow."""
    width = float(np.quantile(band.width, 0.7))
    count = int(np.clip(round(width / pitch), 1, most))
    if count == 1:
        return [band.at(0.5)]
    strokes = []
    for i, share in enumerate(np.linspace(0.1, 0.9, count)):
        # Outer strokes end where the band gets narrow, and every other begins a little later, as hairs do.
        wide = np.flatnonzero(band.width >= min(0.9, 2 * abs(share - 0.5)) * 0.8 * width)
        part = band.at(share)[wide[0] + 2 * (i % 2) : wide[-1] + 1]
        if len(part) > 3:
            strokes.append(part)
    return strokes


def tapered(band: Band, start: float, end: float) -> Band:
    """The band running to a point over these shares of its length at either end, as brows and lenses do."""
    share = np.linspace(0, 1, len(band.axis))
    rise = np.sqrt(np.clip(share / max(start, 1e-9), 0, 1)) * np.sqrt(np.clip((1 - share) / max(end, 1e-9), 0, 1))
    return dataclasses.replace(band, low=band.low * rise, high=band.high * rise)


def lenses(seen: Seen, line: Floats, unit: float) -> list[Floats]:
    """Lenses that fill the dark places of a line, wider than the line itself: nostrils, the corners of the mouth."""
    band = measure(seen, line, 0.05 * unit)
    dark = (band.width > 2 * PEN_PX) & (band.contrast > 1.2)
    strokes: list[Floats] = []
    for run in runs(dark):
        if len(run) * STEP_PX >= 0.07 * unit:
            lens = tapered(band.part(run), 0.5, 0.5)
            strokes.append(np.concatenate([lens.at(0.15), lens.at(0.85)[::-1]]))
    return strokes
