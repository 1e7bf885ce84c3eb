"""Points, lines and outlines go in; masks and distances of a picture's size come out. And OpenCV's filters, typed."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from limner.types import Floats

Image = NDArray[np.float32]
Mask = NDArray[np.bool_]
Labels = NDArray[np.int32]
Shape = tuple[int, ...]

FARTHEST_PX = 1e4
"""OpenCV draws with 16 bits before the point and 16 behind; what lies farther out is drawn here."""


def whole(points_px: Floats) -> NDArray[np.int32]:
    """The nearest whole pixels, of any shape, within what OpenCV draws."""
    return np.rint(np.clip(points_px, -FARTHEST_PX, FARTHEST_PX)).astype(np.int32)


def filled(outline_px: Floats, shape: Shape) -> Mask:
    """Pixels (H, W) within an outline (n, 2), its border included."""
    mask = np.zeros(shape, np.uint8)
    cv2.fillPoly(mask, [whole(outline_px)], (1,))
    return mask.astype(bool)


def distance_to_lines(lines_px: Sequence[Floats], shape: Shape) -> Image:
    """Distance (H, W) [px] to the nearest of some polylines; thousands of pixels where none lies in the picture."""
    empty = np.ones(shape, np.uint8)
    cv2.polylines(empty, [whole(line) for line in lines_px], isClosed=False, color=(0,))
    return distance_to_zero(empty)


def depth(outline_px: Floats, shape: Shape, reach: float) -> Image:
    """How deep (H, W) [px] each pixel lies within an outline (n, 2); negative outside, down to -``reach``."""
    low = np.clip(whole(outline_px.min(axis=0) - reach), 0, shape[::-1])
    high = np.clip(whole(outline_px.max(axis=0) + reach) + 1, low, shape[::-1])
    mask = filled(outline_px - low + 1, (high[1] - low[1] + 2, high[0] - low[0] + 2)).astype(np.uint8)
    mask[[0, -1]], mask[:, [0, -1]] = 0, 0
    signed = (distance_to_zero(mask) - distance_to_zero(1 - mask))[1:-1, 1:-1]
    result = np.full(shape, -reach, np.float32)
    result[low[1] : high[1], low[0] : high[0]] = np.maximum(signed, np.float32(-reach))
    return result


def distance_to_zero(mask: NDArray[np.uint8]) -> Image:
    """Euclidean distance (H, W) [px] to the nearest zero of a picture of zeros and ones; thousands if it has none.

    OpenCV's last bit depends on how many threads took part, which is chance where another thread uses OpenCV too. The
    squares are whole numbers, so their roots are taken anew.
    """
    distance = np.asarray(cv2.distanceTransform(mask, cv2.DIST_L2, cv2.DIST_MASK_PRECISE), np.float64)
    # In place: large pictures come sooner from memory that is in use already.
    np.minimum(distance, FARTHEST_PX, out=distance)
    np.multiply(distance, distance, out=distance)
    np.rint(distance, out=distance)
    return np.sqrt(distance, out=distance).astype(np.float32)


def pieces(mask: Mask) -> tuple[int, Labels]:
    """The 8-connected pieces of a mask: how many labels, 0 (the rest) included, and the label (H, W) of each pixel."""
    count, labels = cv2.connectedComponents(mask.astype(np.uint8), connectivity=8)
    return count, np.asarray(labels, np.int32)


def keep_pieces(mask: Mask, worth: NDArray[np.generic], least: float) -> Mask:
    """The 8-connected pieces whose pixels are together worth so much."""
    count, labels = pieces(mask)
    pixels = np.nonzero(mask)
    of_pixel = labels[pixels]
    sums = np.bincount(of_pixel, weights=worth[pixels], minlength=count)
    kept = np.zeros_like(mask)
    kept[pixels] = sums[of_pixel] >= least
    return kept


def dilated(mask: Mask, reach: int) -> Mask:
    """The mask and what lies within ``reach`` pixels of it."""
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * reach + 1, 2 * reach + 1))
    return np.asarray(cv2.dilate(mask.astype(np.uint8), disc)) > 0


def closed(mask: Mask) -> Mask:
    """The mask with its gaps of a pixel or two filled."""
    return np.asarray(cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8))) > 0


def blurred(image: Image, sigma: float) -> Image:
    """A Gaussian blur, the border of the picture continued."""
    return np.asarray(cv2.GaussianBlur(image, (0, 0), sigma, borderType=cv2.BORDER_REPLICATE), np.float32)


def widely_blurred(image: Image, sigma: float) -> Image:
    """A Gaussian blur so wide that a quarter of the resolution shows it as well, at a tenth of the time."""
    height, width = image.shape
    small = resized(image, (-(-width // 4), -(-height // 4)), cv2.INTER_AREA)
    return resized(blurred(small, sigma / 4), (width, height))


def resized(image: Image, size: tuple[int, int], interpolation: int = cv2.INTER_LINEAR) -> Image:
    """A picture of another width and height."""
    return np.asarray(cv2.resize(image, size, interpolation=interpolation), np.float32)


def filtered(image: Image, kernel: Image) -> Image:
    """Correlation with a kernel, the border of the picture continued."""
    return np.asarray(cv2.filter2D(image, cv2.CV_32F, kernel, borderType=cv2.BORDER_REPLICATE), np.float32)
