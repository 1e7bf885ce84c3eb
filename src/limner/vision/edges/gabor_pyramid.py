"""A photo goes in; the lines that Gabor filters see at several resolutions, added up, come out (thesis 3.1.1).

After Paul the robot (Tresset & Leymarie 2013, doi:10.1016/j.cag.2013.01.012): from a coarse picture up to the
original, each filter's answer is thresholded and thinned by itself, and all these pictures are added. That draws most
lines two or three times, with spurs where filters see one line in two places; so by default a filter counts where it is
among the strongest, a coarse line where no finer one runs, and lines a pixel apart are one. With ``share`` and
``apart`` 0 it is the bare sum.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from limner.settings import SettingsGroup, setting
from limner.types import EdgeMap, Face, Floats, Photo
from limner.vision.edges.bank import correlated
from limner.vision.edges.ridges import Wave, below_pi, gabor_kernel, hysteresis, luminance
from limner.vision.raster import (
    Image,
    Mask,
    Shape,
    blurred,
    closed,
    distance_to_zero,
    filtered,
    keep_pieces,
    resized,
    widely_blurred,
)


@dataclass(frozen=True)
class GaborPyramidSettings(SettingsGroup):
    """Lines by Gabor filters at several resolutions; pixels are those of the working scale."""

    levels: int = setting(4, "resolutions up to the original; 1 for that alone (thesis 3.1.3)", low=1, high=6)
    step: float = setting(1.5, "each resolution over the next coarser one", low=1.1, high=4)
    orientations: int = setting(8, "filters over half a turn", low=2, high=32)
    coarse_orientations: int = setting(4, "filters at the coarsest of several resolutions", low=2, high=32)
    blur_px: float = setting(0.7, "blur before lines are looked for", unit="px", low=0, high=10)
    wavelength_px: float = setting(
        6.0, "lambda: about twice the width of the finest lines found", unit="px", low=3, high=40
    )
    width: float = setting(0.33, "sigma: of the Gaussian across the line, in wavelengths", low=0.2, high=1.5)
    aspect: float = setting(
        0.5, "gamma: width over length of the Gaussian; smaller likes longer lines", low=0.1, high=1
    )
    phase_deg: float = setting(180.0, "phi: 180 finds dark lines, 0 light ones", unit="deg", low=0, high=360)
    share: float = setting(
        0.9,
        "a filter counts where it answers with this share of the strongest at its resolution; 0: each by itself",
        low=0,
        high=1,
    )
    apart: float = setting(
        0.5, "a coarser line within so many of its wavelengths of a finer one goes; 0: all are added", low=0, high=5
    )
    contrast_px: float = setting(
        32.0, "surroundings whose contrast is evened out, standard deviation", unit="px", low=4, high=500
    )
    floor: float = setting(0.01, "contrast below which nothing is amplified, of black to white", low=1e-5, high=1)
    low: float = setting(1.0, "a line goes on while it is this many times the contrast around it", low=0, high=100)
    high: float = setting(2.0, "and reaches this somewhere", low=0, high=100)


@dataclass(frozen=True, eq=False)
class Oriented:
    """What one filter saw at one resolution, in the pixels of the original.

    Attributes:
        level: 0 for the original resolution, 1 for half of it...
        angle_rad: direction of its lines in [0, pi), from x towards y (down).
        strength: (H, W) >= 0, its answer in units of the contrast around.
        thick: (H, W) where the answer passes the thresholds.
        thin: (H, W) the crests of that, one or two pixels wide.
    """

    level: int
    angle_rad: float
    strength: Image
    thick: Mask
    thin: Mask


def gabor_pyramid_edges(photo: Photo, face: Face, settings: GaborPyramidSettings) -> EdgeMap:
    """The thin lines of all filters at all resolutions, added up.

    Args:
        photo: at the working scale.
        face: in that photo; not looked at, what does not belong to it is trimmed later.
        settings: the filters and thresholds.

    Returns:
        The lines; where several filters see one, ``angle_rad`` is that of the surest, and ``strength`` is 1 from
        twice the high threshold on.
    """
    shape = photo.rgb.shape[:2]
    mask, best, angle = np.zeros(shape, bool), np.zeros(shape, np.float32), np.zeros(shape, np.float32)
    grey = prepared(photo, settings)
    for level in range(settings.levels):
        beside_px = settings.apart * settings.wavelength_px * settings.step**level
        added = np.zeros(shape, bool)
        for seen in at_level(grey, level, settings):
            surer = seen.strength > best
            best[surer], angle[surer] = seen.strength[surer], seen.angle_rad
            added |= seen.thin
        added &= distance_to_zero((~mask).astype(np.uint8)) >= beside_px
        # What is left of a line beside a finer one may be crumbs.
        mask |= keep_pieces(added, np.ones(shape), 2 * beside_px)
    if settings.share:
        mask = closed(mask)
    strength = np.clip(best / (2 * max(settings.high, 1e-9)), 0, 1)
    return EdgeMap(mask, strength.astype(np.float64), below_pi(angle).astype(np.float64))


def prepared(photo: Photo, settings: GaborPyramidSettings) -> Image:
    """The luminance (H, W) in which lines are looked for."""
    grey = luminance(photo)
    return blurred(grey, settings.blur_px) if settings.blur_px else grey


def at_level(grey: Image, level: int, settings: GaborPyramidSettings) -> list[Oriented]:
    """What each filter sees at one resolution: level 0 is the original, the last of several has fewer filters."""
    height, width = grey.shape
    size = [max(1, round(side / settings.step**level)) for side in (width, height)]
    picture = resized(grey, (size[0], size[1]), cv2.INTER_AREA) if level else grey
    coarsest = level == settings.levels - 1 > 0
    count = settings.coarse_orientations if coarsest else settings.orientations
    normals = np.pi * np.arange(count) / count
    answers = np.maximum(correlated(picture, _kernels(normals, settings)), 0)
    strongest = answers.max(axis=0)
    answers[answers < np.float32(settings.share) * strongest] = 0
    around = widely_blurred(np.sqrt(strongest), settings.contrast_px) ** 2 + np.float32(settings.floor)
    return [
        _seen(level, normal, _enlarged(answer / around, grey.shape), settings)
        for normal, answer in zip(normals.tolist(), answers, strict=True)
    ]


def _kernels(normals_rad: Floats, settings: GaborPyramidSettings) -> list[Image]:
    sigma_px = settings.width * settings.wavelength_px
    wave = Wave(settings.wavelength_px, sigma_px, settings.aspect, float(np.deg2rad(settings.phase_deg)))
    return [gabor_kernel(wave, normal) for normal in normals_rad]


def _seen(level: int, normal_rad: float, strength: Image, settings: GaborPyramidSettings) -> Oriented:
    thick = hysteresis(strength, strength > 0, settings.low, settings.high)
    thin = thick & _crest(strength, normal_rad)
    return Oriented(level, (normal_rad + np.pi / 2) % np.pi, strength, thick, thin)


def _enlarged(image: Image, shape: Shape) -> Image:
    """At the original's size: smoothly, so that thinning it gives smooth lines."""
    if image.shape == shape:
        return image
    return np.maximum(resized(image, (shape[1], shape[0]), cv2.INTER_CUBIC), 0)


def _crest(strength: Image, normal_rad: float) -> Mask:
    """Pixels (H, W) that are no weaker than their neighbours in one direction, read between the pixels."""
    one = filtered(strength, _neighbour(normal_rad))
    other = filtered(strength, _neighbour(normal_rad + np.pi))
    return (strength > 0) & (strength >= one) & (strength >= other)


def _neighbour(direction_rad: float) -> Image:
    """The filter (3, 3) that reads the place one pixel away, linearly between four pixels."""
    x, y = np.cos(direction_rad), np.sin(direction_rad)
    across = np.array([max(-x, 0), 1 - abs(x), max(x, 0)])
    down = np.array([max(-y, 0), 1 - abs(y), max(y, 0)])
    return np.outer(down, across).astype(np.float32)
