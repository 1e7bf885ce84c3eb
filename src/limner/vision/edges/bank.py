"""A picture and the kernels of a filter bank go in; what each of them answers comes out, by one transform for all."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from limner.vision.raster import Image

TILE_PX = 350
"""Largest side of the part of a picture that is transformed at once: its spectra stay in the processor's memory."""


def correlated(image: Image, kernels: Sequence[Image]) -> Image:
    """Correlation with each of several kernels, the border of the picture continued.

    As ``raster.filtered`` one by one, up to the rounding of float32. Large kernels are applied to spectra in any case,
    and what is filtered is transformed here once for all of them, tile by tile.

    Args:
        image: (H, W).
        kernels: each (m, m), m odd, all of one size.

    Returns:
        (kernels, H, W).
    """
    reach = len(kernels[0]) // 2
    framed = np.asarray(cv2.copyMakeBorder(image, reach, reach, reach, reach, cv2.BORDER_REPLICATE), np.float32)
    answers = np.empty((len(kernels), *image.shape), np.float32)
    high, wide = (-(-side // -(-side // max(TILE_PX, 2 * reach))) for side in image.shape)
    size = tuple(cv2.getOptimalDFTSize(side + 2 * reach) for side in (high, wide))
    spectra = [_spectrum(kernel, size) for kernel in kernels]
    for y in range(0, image.shape[0], high):
        for x in range(0, image.shape[1], wide):
            tile = answers[:, y : y + high, x : x + wide]
            seen = _spectrum(framed[y : y + high + 2 * reach, x : x + wide + 2 * reach], size)
            for spectrum, place in zip(spectra, tile, strict=True):
                product = cv2.mulSpectrums(seen, spectrum, 0, conjB=True)
                place[:] = cv2.idft(product, flags=cv2.DFT_SCALE | cv2.DFT_REAL_OUTPUT)[: len(place), : len(place[0])]
    return answers


def _spectrum(image: Image, size: tuple[int, ...]) -> Image:
    """Of a picture with zeros to the right and below it, packed as OpenCV does for real numbers."""
    padded = np.zeros(size, np.float32)
    padded[: len(image), : len(image[0])] = image
    return np.asarray(cv2.dft(padded), np.float32)
