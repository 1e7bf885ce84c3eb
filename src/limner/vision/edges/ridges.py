"""Luminance goes in; how strongly a dark line runs through each pixel, and in which direction, come out.

A bank of Gabor filters (thesis 2.2, 3.1.1): Gaussians modulated by a plane wave, one for each orientation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from limner.types import Photo
from limner.vision.edges.bank import correlated
from limner.vision.raster import Image, Mask, pieces

Index = NDArray[np.uint8]

HALF_TURN = np.float32(np.pi)


@dataclass(frozen=True, eq=False)
class Ridges:
    """What the bank saw.

    Attributes:
        strength: (H, W) float32 >= 0, response in the unit of the luminance.
        angle_rad: (H, W) float32 in [0, pi), direction of the line, from x towards y (down).
    """

    strength: Image
    angle_rad: Image


@dataclass(frozen=True)
class Wave:
    """The shape of a Gabor filter.

    Attributes:
        wavelength_px: lambda, from one dark line to the next.
        sigma_px: standard deviation of the Gaussian across the line.
        aspect: gamma, width over length of the Gaussian.
        phase_rad: phi, 0 answers to light lines, pi to dark ones, the odd pi / 2 to edges.
    """

    wavelength_px: float
    sigma_px: float
    aspect: float
    phase_rad: float


def luminance(photo: Photo) -> Image:
    """Lightness L* of CIELab (H, W) in [0, 1]: equal steps look equal, so dark skin counts as much as light."""
    lab = np.asarray(cv2.cvtColor(photo.rgb.astype(np.float32) / 255, cv2.COLOR_RGB2LAB), np.float32)
    return np.ascontiguousarray(lab[:, :, 0]) / np.float32(100)


def gabor_kernel(wave: Wave, normal_rad: float) -> Image:
    """One filter (n, n), n odd: exp(-(x'^2 + gamma^2 y'^2) / (2 sigma^2)) cos(2 pi x' / lambda + phi).

    x' = x cos theta + y sin theta runs across the line, y' = -x sin theta + y cos theta along it. What it answers to
    an even grey is taken off, and it is scaled so that its parts above and below zero each sum to one.

    Args:
        wave: the shape.
        normal_rad: theta, the direction across the line.
    """
    reach = int(np.ceil(2.5 * wave.sigma_px / min(wave.aspect, 1)))
    y, x = np.mgrid[-reach : reach + 1, -reach : reach + 1].astype(np.float64)
    across = x * np.cos(normal_rad) + y * np.sin(normal_rad)
    along = -x * np.sin(normal_rad) + y * np.cos(normal_rad)
    envelope = np.exp(-(across**2 + (wave.aspect * along) ** 2) / (2 * wave.sigma_px**2))
    kernel = envelope * np.cos(2 * np.pi * across / wave.wavelength_px + wave.phase_rad)
    kernel -= envelope * kernel.sum() / envelope.sum()
    scaled: Image = (2 * kernel / np.abs(kernel).sum()).astype(np.float32)
    return scaled


def find_ridges(grey: Image, wave: Wave, orientations: int, crossing: float) -> Ridges:
    """The strongest answer of the bank at each pixel, and the direction of the line between the filters' own.

    Each pixel belongs to one orientation only: thinning every orientation by itself and adding them up, as the
    thesis does, leaves short cross-spurs wherever two of them see the same line.

    Args:
        grey: (H, W) luminance.
        wave: the shape of the filters.
        orientations: how many, evenly over half a turn.
        crossing: how much of the answer at right angles is taken off; blobs answer in all directions, lines in one.
    """
    turns = np.pi * np.arange(orientations) / orientations
    answers = correlated(grey, [gabor_kernel(wave, turn) for turn in turns])
    here, best = _strongest(answers)
    before, after, right_angle = _picked(answers, best, (-1, 1, orientations // 2))
    fall = before - after
    curve = np.minimum(before - 2 * here + after, np.float32(-1e-9))
    offset = np.clip(fall / (2 * curve), -0.5, 0.5)
    peak = here - fall * offset / 4
    strength = np.maximum(peak - np.float32(crossing) * np.maximum(right_angle, 0), 0)
    turned = (best + offset) * np.float32(np.pi / orientations) + np.float32(np.pi / 2)
    return Ridges(strength, np.where(turned >= HALF_TURN, turned - HALF_TURN, turned))


def below_pi(angle_rad: NDArray[np.floating]) -> Image:
    """Angles in [0, pi) as float32, of which rounding may have made pi itself."""
    angle: Image = angle_rad.astype(np.float32)
    return np.where(angle >= np.float32(np.pi), np.float32(0), angle)


def _strongest(answers: Image) -> tuple[Image, Index]:
    """The strongest of several answers (n, H, W) at each pixel, and its number: the first of those that are equal."""
    strongest, number = answers[0].copy(), np.zeros(answers.shape[1:], np.uint8)
    for k, answer in enumerate(answers[1:], 1):
        np.maximum(number, (answer > strongest) * np.uint8(k), out=number)
        np.maximum(strongest, answer, out=strongest)
    return strongest, number


def _picked(answers: Image, number: Index, steps: Sequence[int]) -> list[Image]:
    """At each pixel the answers (n, H, W) so many steps after the one of a number, counted round: (H, W) each."""
    picked = [np.empty(number.shape, np.float32) for _ in steps]
    for k in range(len(answers)):
        here = (number == k).view(np.uint8)
        for step, image in zip(steps, picked, strict=True):
            cv2.copyTo(answers[(k + step) % len(answers)], here, image)
    return picked


def crests(strength: Image, angle_rad: Image) -> Mask:
    """Pixels (H, W) that are no weaker than their neighbours across the line: lines one or two pixels wide."""
    y, x = np.indices(strength.shape, dtype=np.float32)
    across_x, across_y = -np.sin(angle_rad), np.cos(angle_rad)
    one, other = (_sample(strength, x + side * across_x, y + side * across_y) for side in (1, -1))
    return (strength > 0) & (strength >= one) & (strength >= other)


def _sample(image: Image, x: Image, y: Image) -> Image:
    return np.asarray(cv2.remap(image, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE), np.float32)


def hysteresis(strength: Image, candidates: Mask, low: float, high: float) -> Mask:
    """8-connected pieces (H, W) of the candidates above ``low`` that rise above ``high`` somewhere."""
    above = candidates & (strength > low)
    count, labels = pieces(above)
    kept = np.zeros(count, bool)
    kept[labels[above & (strength > high)]] = True
    return above & kept[labels]
