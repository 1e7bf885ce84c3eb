"""A photo and a face go in; the dark lines that a bank of Gabor filters sees come out (thesis 3.1.1, 3.1.3)."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from limner.settings import SettingsGroup, setting
from limner.types import EdgeMap, Face, Photo
from limner.vision.edges.attention import Attention, above_the_eyes, attention_to
from limner.vision.edges.iris import with_irises
from limner.vision.edges.ridges import Ridges, Wave, crests, find_ridges, hysteresis, luminance
from limner.vision.raster import Image, Mask, blurred, dilated, pieces, resized, widely_blurred

HAIRLINE = 0.7
"""Thresholds of the coarse bank over those of the fine one: a soft border is a weak line."""

ORDER_PX = 8.0
"""Over what neighbourhood ridges are compared: a few strands of hair, half a curl."""


@dataclass(frozen=True)
class GaborSettings(SettingsGroup):
    """Lines by Gabor filters; pixels are those of the working scale."""

    blur_px: float = setting(
        0.7, "blur before lines are looked for, which evens out how the photo was resampled", unit="px", low=0, high=10
    )
    orientations: int = setting(8, "filters over half a turn", low=4, high=32)
    wavelength_px: float = setting(6.0, "lambda: about twice the width of the lines found", unit="px", low=3, high=40)
    width: float = setting(0.33, "sigma: of the Gaussian across the line, in wavelengths", low=0.2, high=1.5)
    aspect: float = setting(
        0.3, "gamma: width over length of the Gaussian; smaller likes longer lines", low=0.1, high=1
    )
    phase_deg: float = setting(180.0, "phi: 180 finds dark lines, 0 light ones", unit="deg", low=0, high=360)
    hairline: float = setting(
        2.0,
        "a second bank above the brows, this many times as coarse, for the soft border of the hair; 1 for none",
        low=1,
        high=4,
    )
    crossing: float = setting(0.7, "how much an answer at right angles counts against a line", low=0, high=1)
    contrast_px: float = setting(
        32.0, "surroundings whose contrast is evened out, standard deviation", unit="px", low=4, high=500
    )
    floor: float = setting(0.004, "contrast below which nothing is amplified, of black to white", low=1e-5, high=1)
    low: float = setting(0.9, "a line goes on while it is this many times the contrast around it", low=0, high=100)
    high: float = setting(1.8, "and reaches this somewhere", low=0, high=100)
    guided: bool = setting(True, "look closer at the features, and less at skin, body and background")
    irises: bool = setting(True, "draw iris and pupil as circles where they are seen")


def gabor_edges(photo: Photo, face: Face, settings: GaborSettings) -> EdgeMap:
    """Thin dark lines, one for each line of the face.

    Args:
        photo: at the working scale.
        face: in that photo.
        settings: the filters and thresholds.

    Returns:
        Lines one or two pixels wide; ``strength`` is 1 from twice the high threshold on.
    """
    grey = luminance(photo)
    if settings.blur_px:
        grey = blurred(grey, settings.blur_px)
    attention = attention_to(face, grey.shape) if settings.guided else None
    lines = _lines(_find(grey, settings), attention, settings)
    if settings.hairline > 1:
        softer = settings.replace(low=HAIRLINE * settings.low, high=HAIRLINE * settings.high)
        coarse = _lines(_find_coarse(grey, settings), attention, softer)
        lines = _fill_in(lines, coarse, above_the_eyes(face, grey.shape), settings.wavelength_px)
    return with_irises(lines, grey, face) if settings.irises else lines


def _lines(ridges: Ridges, attention: Attention | None, settings: GaborSettings) -> EdgeMap:
    """The crests that stand out from their surroundings, more so where attention is paid to them."""
    ridges = _evened(ridges, settings)
    strength, angle = ridges.strength, ridges.angle_rad
    candidates = crests(strength, angle)
    if attention is not None:
        pixels = np.nonzero(candidates)
        gain = attention.gain(np.stack(pixels, axis=1), angle[pixels], _order(ridges)[pixels])
        strength = strength.copy()
        strength[pixels] *= gain.astype(np.float32)
    mask = hysteresis(strength, candidates, settings.low, settings.high)
    sure = np.clip(strength / (2 * max(settings.high, 1e-9)), 0, 1)
    return EdgeMap(mask, sure.astype(np.float64), angle.astype(np.float64))


def _find(grey: Image, settings: GaborSettings) -> Ridges:
    return find_ridges(grey, _wave(settings), settings.orientations, settings.crossing)


def _wave(settings: GaborSettings) -> Wave:
    sigma_px = settings.width * settings.wavelength_px
    return Wave(settings.wavelength_px, sigma_px, settings.aspect, float(np.deg2rad(settings.phase_deg)))


def _evened(ridges: Ridges, settings: GaborSettings) -> Ridges:
    """Strength in units of the strength around, so that a soft light and a dark skin draw as well.

    The mean of the square roots, squared: one strong outline does not silence what lies beside it.
    """
    around = widely_blurred(np.sqrt(ridges.strength), settings.contrast_px) ** 2
    return Ridges(ridges.strength / (around + np.float32(settings.floor)), ridges.angle_rad)


def _find_coarse(grey: Image, settings: GaborSettings) -> Ridges:
    """The ridges (H, W) of a coarser picture."""
    height, width = grey.shape
    size = max(1, round(width / settings.hairline)), max(1, round(height / settings.hairline))
    coarse = _find(resized(grey, size, cv2.INTER_AREA), settings)
    angle = resized(coarse.angle_rad, (width, height), cv2.INTER_NEAREST)
    return Ridges(resized(coarse.strength, (width, height)), angle)


def _fill_in(fine: EdgeMap, coarse: EdgeMap, where: Mask, wavelength_px: float) -> EdgeMap:
    """The fine lines, and those coarse ones ``where`` asked for beside which no fine line worth drawing runs."""
    count, labels = pieces(fine.mask)
    long_enough = np.bincount(labels.ravel(), minlength=count) >= 4 * wavelength_px
    beside = dilated(fine.mask & long_enough[labels], round(wavelength_px))
    added = coarse.mask & where & ~beside
    return EdgeMap(
        fine.mask | added,
        np.where(added, coarse.strength, fine.strength),
        np.where(added, coarse.angle_rad, fine.angle_rad),
    )


def _order(ridges: Ridges) -> Image:
    """How far neighbouring ridges (H, W) run in one direction: 1 all of them, 0 all ways."""
    cos, sin = (blurred(ridges.strength * part(2 * ridges.angle_rad), ORDER_PX) for part in (np.cos, np.sin))
    order: Image = np.hypot(cos, sin) / (blurred(ridges.strength, ORDER_PX) + np.float32(1e-3))
    return order
