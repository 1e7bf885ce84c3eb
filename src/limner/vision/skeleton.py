"""A mask goes in; lines one pixel wide that keep its pieces and holes come out.

Thinning by tables: whether a pixel may go depends on its eight neighbours alone, so every one of the 256 cases is
decided once, when the module is loaded.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Flat = NDArray[np.uint8]
Index = NDArray[np.int64]

_RING = ((-1, 0), (-1, 1), (0, 1), (1, 1), (1, 0), (1, -1), (0, -1), (-1, -1))
"""(row, column) steps to the neighbours N, NE, E, SE, S, SW, W, NW: bit 0 to bit 7 of a case."""


def skeletonize(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Thin a mask to lines one pixel wide.

    Guo & Hall 1989 (doi:10.1145/62065.62074, algorithm A1) in parallel, then, pixel by pixel, the corners of the
    stairs that it leaves. Both only take pixels whose loss changes neither the 8-connected pieces nor the holes. A
    2x2 block of which all four pixels carry lines is opened by moving one pixel aside; only where holes of one or two
    pixels leave no room for that is a connection given up.

    Args:
        mask: (H, W) bool.

    Returns:
        (H, W) bool without any 2x2 block.
    """
    padded = np.pad(mask.astype(np.uint8), 2)
    width = padded.shape[1]
    image = padded.ravel()
    steps = np.array([dy * width + dx for dy, dx in _RING])
    _thin(image, steps)
    _take_corners(image, steps)
    _open_blocks(image, steps, width)
    _take_corners(image, steps)
    return image.reshape(padded.shape)[2:-2, 2:-2].astype(bool)


def _cases(image: Flat, pixels: Index, steps: Index) -> NDArray[np.uint8]:
    """Which neighbours of each pixel are set, as bits."""
    case = np.zeros(len(pixels), np.uint8)
    for bit, step in enumerate(steps):
        case |= image[pixels + step] << np.uint8(bit)
    return case


def _thin(image: Flat, steps: Index) -> None:
    """Peel in place until nothing changes; only pixels beside a loss can be lost next."""
    pixels = np.flatnonzero(image)
    pixels = pixels[_cases(image, pixels, steps) != 255]
    while len(pixels):
        lost = []
        for table in (_PEEL_FIRST, _PEEL_SECOND):
            pixels = pixels[image[pixels] > 0]
            gone = pixels[table[_cases(image, pixels, steps)]]
            image[gone] = 0
            lost.append(gone)
            pixels = _beside(image, np.concatenate([pixels, gone]), steps)
        pixels = _beside(image, np.concatenate(lost), steps)


def _beside(image: Flat, pixels: Index, steps: Index) -> Index:
    """The set pixels among ``pixels`` and their neighbours, each once, in raster order."""
    near = np.zeros(len(image), bool)
    near[pixels] = True
    for step in steps:
        near[pixels + step] = True
    found = np.flatnonzero(near)
    return found[image[found] > 0]


def _take_corners(image: Flat, steps: Index) -> None:
    """Remove in place, one after another in raster order, what is neither an end nor needed as a link."""
    pixels = np.flatnonzero(image)
    pixels = pixels[_CORNER[_cases(image, pixels, steps)]]
    around = steps.tolist()
    while len(pixels):
        gone = [pixel for pixel in pixels.tolist() if _CORNER[_case(image, pixel, around)] and _clear(image, pixel)]
        pixels = _beside(image, np.array(gone, np.int64), steps)
        pixels = pixels[_CORNER[_cases(image, pixels, steps)]]


def _case(image: Flat, pixel: int, steps: list[int]) -> int:
    return sum(int(image[pixel + step]) << bit for bit, step in enumerate(steps))


def _clear(image: Flat, pixel: int) -> bool:
    image[pixel] = 0
    return True


def _open_blocks(image: Flat, steps: Index, width: int) -> None:
    """Break up in place the 2x2 blocks whose four pixels all carry lines."""
    around = steps.tolist()
    blocks = image[: -width - 1] & image[1:-width] & image[width:-1] & image[width + 1 :]
    for corner in np.flatnonzero(blocks).tolist():
        block = (corner, corner + 1, corner + width, corner + width + 1)
        if all(image[pixel] for pixel in block) and not any(_step_aside(image, pixel, around) for pixel in block):
            image[corner] = 0


def _step_aside(image: Flat, pixel: int, steps: list[int]) -> bool:
    """Set a neighbour and clear the pixel, if neither changes pieces or holes nor makes another block."""
    for step in steps[::2]:
        beside = pixel + step
        if image[beside] or not _SIMPLE[_case(image, beside, steps)]:
            continue
        image[beside], image[pixel] = 1, 0
        if _SIMPLE[_case(image, pixel, steps)] and not _BLOCK[_case(image, beside, steps)]:
            return True
        image[beside], image[pixel] = 0, 1
    return False


def _table(rule: Callable[[list[int]], bool]) -> NDArray[np.bool_]:
    return np.array([rule([case >> bit & 1 for bit in range(8)]) for case in range(256)])


def _pieces(ring: list[int]) -> int:
    """8-connected pieces of the neighbours that stay linked through a side of the pixel (its crossing number)."""
    return sum(not ring[side] and (ring[side + 1] or ring[(side + 2) % 8]) for side in (0, 2, 4, 6))


def _may_peel(ring: list[int]) -> bool:
    """Guo & Hall's G1 and G2: one piece beside the pixel, and it is not the end of a line."""
    n, ne, e, se, s, sw, w, nw = ring
    one = (n or ne) + (e or se) + (s or sw) + (w or nw)
    other = (ne or e) + (se or s) + (sw or w) + (nw or n)
    return _pieces(ring) == 1 and 2 <= min(one, other) <= 3


def _first(ring: list[int]) -> bool:
    n, ne, e, se, *_ = ring
    return _may_peel(ring) and not ((n or ne or not se) and e)


def _second(ring: list[int]) -> bool:
    *_, s, sw, w, nw = ring
    return _may_peel(ring) and not ((s or sw or not nw) and w)


_PEEL_FIRST, _PEEL_SECOND = _table(_first), _table(_second)
_SIMPLE = _table(lambda ring: _pieces(ring) == 1)
_CORNER = _table(lambda ring: _pieces(ring) == 1 and sum(ring) >= 2)
_BLOCK = _table(lambda ring: any(ring[i] and ring[i + 1] and ring[(i + 2) % 8] for i in (0, 2, 4, 6)))
