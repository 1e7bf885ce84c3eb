"""A photo and a face go in; the dark lines that a bank of Gabor filters sees come out (thesis 3.1.1, 3.1.3)."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from limner.settings import SettingsGroup, setting
from limner.types import EdgeMap, Face, Photo
from limner.vision.edges.attention import MOST_GAIN, Attention, above_the_eyes, attention_to
from limner.vision.edges.iris import Disc, find_irises, with_irises
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

    def seeing(self) -> GaborSettings:
        """The settings on which what is seen depends: one and the same whatever the thresholds."""
        return self.replace(low=0.0, high=0.0)


@dataclass(frozen=True, eq=False)
class Band:
    """What a bank sees of one width.

    Attributes:
        ridges: their strength in units of the strength around.
        crests: (H, W) where lines may be, one or two pixels wide.
        order: (H, W) how far neighbouring ridges run in one direction; None where no attention is paid.
    """

    ridges: Ridges
    crests: Mask
    order: Image | None


@dataclass(frozen=True, eq=False)
class Sight:
    """What the banks see in a photo, whatever the thresholds are.

    Attributes:
        fine: the lines.
        coarse: soft borders; None for no second bank.
        attention: where to look closer; None for everywhere alike.
        irises: that are seen.
        face: in the photo.
    """

    fine: Band
    coarse: Band | None
    attention: Attention | None
    irises: tuple[Disc | None, ...]
    face: Face


def gabor_edges(photo: Photo, face: Face, settings: GaborSettings) -> EdgeMap:
    """Thin dark lines, one for each line of the face.

    Args:
        photo: at the working scale.
        face: in that photo.
        settings: the filters and thresholds.

    Returns:
        Lines one or two pixels wide; ``strength`` is 1 from twice the high threshold on.
    """
    return gabor_lines(gabor_sight(photo, face, settings), settings)


def gabor_sight(photo: Photo, face: Face, settings: GaborSettings) -> Sight:
    """All of ``gabor_edges`` that takes long and does not depend on the thresholds."""
    grey = luminance(photo)
    if settings.blur_px:
        grey = blurred(grey, settings.blur_px)
    return Sight(
        fine=_band(_find(grey, settings), settings),
        coarse=_band(_find_coarse(grey, settings), settings) if settings.hairline > 1 else None,
        attention=attention_to(face, grey.shape) if settings.guided else None,
        irises=find_irises(grey, face) if settings.irises else (),
        face=face,
    )


def gabor_lines(sight: Sight, settings: GaborSettings) -> EdgeMap:
    """The lines of ``gabor_edges`` from what was seen with these settings, or with other thresholds."""
    lines = _lines(sight.fine, sight.attention, settings.low, settings.high)
    if sight.coarse:
        coarse = _lines(sight.coarse, sight.attention, HAIRLINE * settings.low, HAIRLINE * settings.high)
        lines = _fill_in(lines, coarse, above_the_eyes(sight.face, lines.mask.shape), settings.wavelength_px)
    return with_irises(lines, sight.irises, sight.face)


def _band(ridges: Ridges, settings: GaborSettings) -> Band:
    ridges = _evened(ridges, settings)
    return Band(ridges, crests(ridges.strength, ridges.angle_rad), _order(ridges) if settings.guided else None)


def _lines(band: Band, attention: Attention | None, low: float, high: float) -> EdgeMap:
    """The crests that stand out from their surroundings, more so where attention is paid to them."""
    strength, angle, candidates = band.ridges.strength, band.ridges.angle_rad, band.crests
    if attention is not None and band.order is not None:
        # What no attention lifts over the threshold needs none.
        candidates = candidates & (strength > low / MOST_GAIN)
        pixels = np.nonzero(candidates)
        gain = attention.gain(np.stack(pixels, axis=1), angle[pixels], band.order[pixels])
        strength = strength.copy()
        strength[pixels] *= gain.astype(np.float32)
    mask = hysteresis(strength, candidates, low, high)
    sure = np.clip(strength / (2 * max(high, 1e-9)), 0, 1)
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
