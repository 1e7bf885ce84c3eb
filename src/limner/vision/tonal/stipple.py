"""A photo and its face go in; dots as dense as the picture is dark, each a stroke of one point, come out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from limner.settings import SettingsGroup, setting
from limner.types import REGIONS, Face, Strokes
from limner.vision.raster import Image
from limner.vision.regions import RegionSettings, regions_at
from limner.vision.tonal.voronoi import stipple_dots


@dataclass(frozen=True)
class StippleSettings(SettingsGroup):
    """Dots, each in the middle of its Voronoi cell."""

    points: int = setting(
        3000, "how many dots where no budget says how many", unit="points", low=1, high=100_000
    )  # fmt: skip
    power: float = setting(1.3, "dots are as dense as the wanted ink to this power", low=0.1, high=5)
    rounds: int = setting(20, "how often each dot moves to the middle of its cell", low=0, high=1000)
    seed: int = setting(0, "of where the dots begin", low=0, high=1_000_000)


@dataclass(frozen=True)
class OneLineSettings(StippleSettings):
    """One line through dots, each in the middle of its Voronoi cell."""

    # A short tour has a length per area that grows as the square root of the density of its points (Beardwood, Halton
    # & Hammersley 1959, doi:10.1017/S0305004100034095).
    power: float = setting(2.0, "dots are as dense as the wanted ink to this power", low=0.1, high=5)


def stipple(ink: Image, face: Face, settings: StippleSettings, regions: RegionSettings) -> Strokes:
    """Dots for a picture of wanted ink, the heaviest first.

    Args:
        ink: (H, W) >= 0.
        face: in its pixels.
        settings: how many dots, and how they spread.
        regions: how much a dot of each region matters.
    """
    dots = stipple_dots(ink ** np.float32(settings.power), settings.points, settings.rounds, settings.seed)
    labels = regions_at(dots, face)
    weights = np.array([getattr(regions, name) for name in REGIONS])[labels]
    order = np.argsort(-weights, kind="stable")
    height, width = ink.shape
    names = tuple(REGIONS[k] for k in labels[order])
    return Strokes(tuple(dots[order][:, None]), names, weights[order], (width, height))
