"""A photo, its face and figure go in; how dark each place is to be drawn, by the person's own skin, comes out."""

from __future__ import annotations

import cv2
import numpy as np

from limner.types import Face, Photo
from limner.vision.figure import Figure
from limner.vision.head import BROWS, EYES, LIPS, face_outline
from limner.vision.raster import Image, Mask, blurred, dilated, filled

LIT, MIDDLE = 90, 55
"""Percentiles of the skin's lightness that are drawn white, and as ``MIDDLE_TONE``."""

MIDDLE_TONE = 0.14
"""Darkness of the usual skin, whatever its colour."""

LEAST_SPAN = 20.0
"""From lit skin to black there are at least so many units of lightness; a flat photo is not made a contrasty one."""


def darkness(photo: Photo, face: Face, figure: Figure) -> Image:
    """How dark each pixel is (H, W): 0 as the lit skin or lighter, 1 as the darkest of the person.

    Lightness is measured on the person's own scale: from lit skin over the usual one to the darkest there is. So dark
    skin keeps its lights, and pale skin its shadows.

    Args:
        photo: at the working scale.
        face: in it.
        figure: in it.
    """
    lab = cv2.cvtColor(photo.rgb.astype(np.float32) / np.float32(255), cv2.COLOR_RGB2LAB)
    return darkness_of(np.asarray(lab[..., 0], np.float32), face, figure)


def darkness_of(light: Image, face: Face, figure: Figure) -> Image:
    """The same from the lightness (H, W) of CIELAB."""
    bare = light[bare_skin(face, figure)]
    if not bare.size:
        return np.zeros(light.shape, np.float32)
    lit, middle = np.percentile(bare, [LIT, MIDDLE])
    black = min(float(np.percentile(light[figure.figure], 2)), float(middle) - LEAST_SPAN)
    scale = np.array([black, middle, max(lit, middle + 1)])
    dark: Image = np.interp(light, scale, [1, MIDDLE_TONE, 0]).astype(np.float32)
    return dark


def bare_skin(face: Face, figure: Figure) -> Mask:
    """Skin (H, W) of the face without features and beard."""
    shape, unit = figure.skin.shape, face.outer_eye_px
    features = np.zeros(shape, bool)
    for landmarks in (*EYES, *BROWS, LIPS):
        features |= filled(face.points_px[landmarks], shape)
    return filled(face_outline(face), shape) & figure.skin & ~figure.beard & ~dilated(features, round(0.08 * unit))


def within(image: Image, mask: Mask, sigma: float) -> Image:
    """A Gaussian blur that takes nothing from outside a mask."""
    weight = mask.astype(np.float32)
    share = np.maximum(blurred(weight, sigma), np.float32(1e-3))
    return np.asarray(blurred(image * weight, sigma) / share, np.float32)
