"""How likely each pixel is figure and the photo go in; one mask whose border follows edges comes out."""

from __future__ import annotations

import cv2
import numpy as np

from limner.types import Floats
from limner.vision.raster import Image, Mask

CERTAIN = 5.0
"""Log odds beyond which a pixel is no surer."""

STEP = 8.0
"""Levels of the coded picture for one unit of log odds."""


def cut(likely: Image, colours: Image, certain: Mask, trust: float) -> Mask:
    """The mask (H, W) that agrees with the likelihood and has a short border that runs along edges.

    The minimum cut of Boykov & Jolly 2001 (doi:10.1109/ICCV.2001.937505), by the solver inside OpenCV's GrabCut: the
    log odds are coded as one channel of its picture and two fixed Gaussians are chosen whose log ratio gives them back.

    Args:
        likely: (H, W) probability of figure.
        colours: (H, W, 3) in [0, 1]; edges are seen in them.
        certain: (H, W) figure in any case.
        trust: what one unit of log odds weighs; the border weighs 50 for each pixel where nothing changes.
    """
    odds = np.clip(np.log(likely + 1e-6) - np.log(1 - likely + 1e-6), -CERTAIN, CERTAIN)
    if odds.size < 2:
        single: Mask = certain | (odds > 0)  # one pixel has no border to cut
        return single
    coded = np.stack([127.5 + STEP * odds, 255 * colours[..., 0], 255 * colours[..., 1:].mean(axis=-1)], axis=-1)
    mask = np.where(certain, cv2.GC_FGD, np.where(odds > 0, cv2.GC_PR_FGD, cv2.GC_PR_BGD)).astype(np.uint8)
    variance = 255 * STEP / trust
    models = [_model(mean, variance) for mean in (0.0, 255.0)]
    picture = np.rint(coded).astype(np.uint8)
    cv2.grabCut(picture, mask, (0, 0, 1, 1), models[0], models[1], 1, cv2.GC_EVAL_FREEZE_MODEL)
    chosen: Mask = (mask == cv2.GC_FGD) | (mask == cv2.GC_PR_FGD)
    return chosen


def _model(mean: float, variance: float) -> Floats:
    """One Gaussian in OpenCV's form: five weights, five means, five covariances; only the first channel tells."""
    model = np.zeros((1, 65))
    model[0, 0] = 1
    model[0, 5:8] = mean, 127.5, 127.5
    model[0, 20:29] = np.diag([variance, 1e9, 1e9]).ravel()
    return model
