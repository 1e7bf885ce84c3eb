"""A photo and how likely each part is by place go in; how likely it is by colour and texture too comes out.

Each part learns its colours, here and there, and its texture from the pixels that are likely to belong to it, then each
pixel is judged again by what was learned and by its neighbours: expectation and maximisation with histograms.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from limner.types import Floats, Photo
from limner.vision.raster import Image, Mask, blurred
from limner.vision.segment.texture import LEVELS, Levels

Index = NDArray[np.int64]

ROUNDS = 3

COLOUR_BINS = (14, 11, 11)
"""Cells of lightness and of the two opponent colours."""

PLACE_BINS = (2, 2)
"""Cells down and across the picture."""

CHROMA_SPAN = 0.28
"""From neutral to the last cell of an opponent colour, as a share of the photo's range of lightness."""

DOUBTFUL, SURE = 0.85, 0.97
"""The first colours are learned from where a part is likelier than this, in full from where it is sure."""

FAR = 400.0
"""How many pixels' worth the colours of the part all over the photo count against those nearby."""

UNSEEN = 2e-4
"""Likelihood of a colour that a part has never shown."""

TEXTURE = 0.7
"""How much texture tells beside colour."""

DARK, BRIGHT = 0.05, 0.2
"""Texture tells nothing in what is darker than the first, all in what is lighter than the second."""

COMPANY, COMPANY_PX = 3.0, 2.5
"""Log odds of a part for a pixel all of whose neighbours are of it, and how far those are: so hair may go on."""

LATER = 0.3
"""What the background learns below the eyes, beside long hair and shoulders, counts so much."""


def likely_parts(seen: Image, texture: Levels, places: Image, face: Mask, features: Mask, above: Image) -> Image:
    """How likely each part is (4, H, W) at each pixel by place, colour and texture.

    Args:
        seen: (H, W, 3) lightness and opponent colours, ``normalized``.
        texture: (H, W) its levels.
        places: (4, H, W) how likely by place alone.
        face: (H, W) what is certainly no background.
        features: (H, W) what no part learns from.
        above: (H, W) how much the background first learns where, from 0 to 1: beside the neck may hang hair.
    """
    cell, colour, where = _cells(seen)
    prior = places.reshape(4, -1).copy()
    prior[0, face.ravel()] = 0
    likely = np.clip((prior - DOUBTFUL) / (SURE - DOUBTFUL), 0, 1)
    likely[0] *= above.ravel()
    learn = np.repeat(~features.ravel()[None], 4, axis=0).astype(np.float64)
    tells = np.clip((seen[..., 0].ravel() - DARK) / (BRIGHT - DARK), 0, 1) * TEXTURE
    odds = np.zeros_like(prior)
    for _ in range(ROUNDS):
        weights = likely * learn
        odds += _by_texture(texture.ravel(), tells, weights)
        by_colour = np.stack([_likelihood(cell, colour, where, part) for part in weights])
        likely = prior * by_colour * np.exp(odds)
        likely /= likely.sum(axis=0)
        near = [blurred(part, COMPANY_PX) for part in likely.astype(np.float32).reshape(places.shape)]
        odds = COMPANY * np.stack(near).reshape(4, -1)
        learn[0] = learn[1] * (LATER + (1 - LATER) * above.ravel())
    result: Image = likely.reshape(places.shape).astype(np.float32)
    return result


def lab_of(photo: Photo) -> Image:
    """CIELAB (H, W, 3) of a photo, finer than whole numbers."""
    return np.asarray(cv2.cvtColor(photo.rgb.astype(np.float32) / np.float32(255), cv2.COLOR_RGB2LAB), np.float32)


def normalized(lab: Image) -> Image:
    """Lightness and opponent colours (H, W, 3), as shares of the photo's own range of lightness, from 0 to 1."""
    low, high = np.percentile(lab[..., 0], [1, 99])
    span = max(float(high - low), 10.0)
    light = (lab[..., 0] - low) / span
    chroma = lab[..., 1:] / (2 * CHROMA_SPAN * span) + 0.5
    result: Image = np.clip(np.concatenate([light[..., None], chroma], axis=-1), 0, 1).astype(np.float32)
    return result


def _cells(colours: Image) -> tuple[Index, Index, Index]:
    """The cell of each pixel (n,) in colour and place, in colour, and in place."""
    height, width = colours.shape[:2]
    colour = np.zeros((height, width), np.int64)
    for channel, bins in enumerate(COLOUR_BINS):
        colour = colour * bins + np.minimum((colours[..., channel] * bins).astype(np.int64), bins - 1)
    rows = np.arange(height)[:, None] * PLACE_BINS[0] // height
    columns = np.arange(width) * PLACE_BINS[1] // width
    where = rows * PLACE_BINS[1] + columns
    return (where * int(np.prod(COLOUR_BINS)) + colour).ravel(), colour.ravel(), where.ravel()


def _likelihood(cell: Index, colour: Index, where: Index, weight: Image) -> Floats:
    """How often a part shows the colour of each pixel (n,), near it first, all over the photo else."""
    count = np.bincount(cell, weight, int(np.prod(PLACE_BINS) * np.prod(COLOUR_BINS)))
    table = count.reshape(PLACE_BINS + COLOUR_BINS)
    for axis in range(5):
        table = _spread(table, axis)
    near = table.reshape(-1)
    colours = table.sum(axis=(0, 1)).ravel() / max(table.sum(), 1e-9)
    mass = table.sum(axis=(2, 3, 4)).ravel()
    seen: Floats = (near[cell] + FAR * colours[colour]) / (mass[where] + FAR) + UNSEEN
    return seen


def _by_texture(level: Levels, tells: Floats, weights: Floats) -> Floats:
    """Log of how often each part shows the texture of each pixel (4, n), times what it ``tells`` (n,) there."""
    count = np.stack([np.bincount(level, part * tells, LEVELS) for part in weights])
    table = _spread(np.asarray(count + 1, np.float64), 1)
    often = np.log(table / table.sum(axis=1, keepdims=True) + 0.01)
    result: Floats = often[:, level] * tells
    return result


def _spread(table: Floats, axis: int) -> Floats:
    """A quarter of each cell goes to each neighbour; at the ends it stays."""
    padded = np.take(table, np.clip(np.arange(-1, table.shape[axis] + 1), 0, table.shape[axis] - 1), axis=axis)
    n = table.shape[axis]
    parts = [np.take(padded, np.arange(k, k + n), axis=axis) for k in range(3)]
    spread: Floats = parts[1] / 2 + (parts[0] + parts[2]) / 4
    return spread
