"""A picture goes in; brush strokes that paint it, from coarse to fine, come out (thesis 2.3.3).

Hertzmann 1998 (doi:10.1145/280814.280951). Where his strokes are fine wherever the picture is, ours are where the
face has its features: DeCarlo & Santella 2002 (doi:10.1145/566654.566650) have a viewer's gaze for that.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from limner.types import Floats
from limner.vision.edges.flow import slopes
from limner.vision.painterly.settings import Manner
from limner.vision.raster import Image

LEAST_SLOPE = 0.4
"""Where the brightness changes less than this [of 255, per pixel], a stroke goes on as it came."""

SMALLEST_PX = 1.8
"""A smaller brush would paint single pixels."""

SAMPLES = 4
"""Points of the curve between two control points."""

_SHIFT = 4
# Down to the left, where the picture does not say how a stroke runs.
_RIGHT_HAND = (0.8, -0.6)


@dataclass(frozen=True, eq=False)
class Painting:
    """Brush strokes in the order in which they are painted.

    Attributes:
        lines: polylines (n, 2) [px] along the middle of each; one point is a dab.
        radius: (strokes,) of the brush [px].
        rgb: (strokes, 3) uint8.
        layer: (strokes,) how many layers are below it.
        canvas: (H, W, 3) uint8, what they paint.
    """

    lines: tuple[Floats, ...]
    radius: Floats
    rgb: NDArray[np.uint8]
    layer: NDArray[np.int64]
    canvas: NDArray[np.uint8]


def paint(rgb: NDArray[np.uint8], importance: Image, manner: Manner, unit_px: float, seed: int) -> Painting:
    """Paint a picture, layer by layer with smaller brushes, where it is not yet like it.

    Args:
        rgb: (H, W, 3).
        importance: (H, W) how much a fault counts.
        manner: of painting.
        unit_px: the size of the face in it.
        seed: of chance.
    """
    chance = np.random.default_rng(seed)
    canvas = rgb.copy()
    lines: list[Floats] = []
    radii, colours, layers = [np.zeros(0)], [np.zeros((0, 3), np.uint8)], [np.zeros(0, np.int64)]
    sizes = [brush * unit_px for brush in manner.brushes]
    for k, radius in enumerate([size for size in sizes if size >= SMALLEST_PX] or sizes[:1]):
        wanted = np.asarray(cv2.GaussianBlur(rgb, (0, 0), max(manner.blur * radius, 0.3)), np.float32)
        fault = np.sqrt(((canvas - wanted) ** 2).sum(axis=2)) * importance
        # Nothing is on the canvas yet: all of it is painted once, though the picture shows what is below a wash.
        places = _seeds(fault if k else importance + 1, radius, manner, 0 if k == 0 else manner.threshold)
        if not len(places):
            continue
        chance.shuffle(places)
        found = _strokes(places, wanted, canvas.astype(np.float32), radius, manner, first=k == 0)
        paints = _jittered(wanted[places[:, 1], places[:, 0]], manner, chance)
        canvas = _painted(canvas, found, paints, radius, manner.opacity if k else 1.0)
        lines += found
        radii.append(np.full(len(found), radius))
        colours.append(paints)
        layers.append(np.full(len(found), k))
    return Painting(tuple(lines), np.concatenate(radii), np.concatenate(colours), np.concatenate(layers), canvas)


def _seeds(fault: Image, radius: float, manner: Manner, threshold: float) -> NDArray[np.int64]:
    """In each cell of a grid that is off by the threshold on average, the place (n, 2) that is off most."""
    cell = max(1, round(manner.grid * radius))
    height, width = fault.shape
    rows, columns = -(-height // cell), -(-width // cell)
    padded = np.full((rows * cell, columns * cell), -1, np.float32)
    padded[:height, :width] = fault
    cells = padded.reshape(rows, cell, columns, cell).swapaxes(1, 2).reshape(rows, columns, cell * cell)
    mean = np.maximum(cells, 0).mean(axis=2)
    # On an even cell the middle, not its first corner.
    centred = cells + np.float32(1e-3) * _middle(cell)
    worst = centred.argmax(axis=2)
    row, column = np.nonzero(mean > threshold)
    at = worst[row, column]
    return np.stack([column * cell + at % cell, row * cell + at // cell], axis=1).astype(np.int64)


def _middle(cell: int) -> Floats:
    y, x = np.mgrid[:cell, :cell] - (cell - 1) / 2
    return np.asarray(-np.hypot(x, y).ravel() / cell, np.float64)


def _strokes(
    places: NDArray[np.int64], wanted: Image, canvas: Image, radius: float, manner: Manner, *, first: bool
) -> list[Floats]:
    """A stroke through each place (n, 2), all grown together: across the slope, as long as its colour is right."""
    points = places.astype(np.float64)
    if not manner.longest:
        return list(points[:, None])
    slope, colour = _slope(wanted), wanted[places[:, 1], places[:, 0]]
    last = np.array(wanted.shape[1::-1]) - 1
    grown, alive, length = [points], np.ones(len(points), bool), np.ones(len(points), np.int64)
    way: Floats | None = None
    for step in range(manner.longest):
        column, row = np.clip(np.rint(points), 0, last).astype(np.int64).T
        if step > manner.shortest:
            here = wanted[row, column]
            off, worse = (np.abs(here - other).sum(axis=1) for other in (canvas[row, column], colour))
            alive &= (off >= worse) | first & (worse < manner.threshold)
        way = _ways(slope[row, column].astype(np.float64), way, manner.bend)
        points = points + radius * way
        alive &= ((points >= 0) & (points <= last)).all(axis=1)
        if not alive.any():
            break
        grown.append(points)
        length[alive] += 1
    paths = np.stack(grown, axis=1)
    return [spline(path[:count]) for path, count in zip(paths, length.tolist(), strict=True)]


def _slope(picture: Image) -> Image:
    """How the brightness of a picture (H, W, 3) changes along x and y: (H, W, 2)."""
    grey = picture @ np.array([0.3, 0.59, 0.11], np.float32)
    return np.stack(slopes(np.ascontiguousarray(grey)), axis=2)


def _ways(slope: Floats, before: Floats | None, bend: float) -> Floats:
    """Directions (n, 2) across slopes (n, 2), bent from those before, if any; where it is flat, on as before."""
    steep = np.hypot(*slope.T)
    along = np.stack([-slope[:, 1], slope[:, 0]], axis=1) / np.maximum(steep, 1e-9)[:, None]
    flat = (steep < LEAST_SLOPE)[:, None]
    if before is None:
        way = np.where(flat, _RIGHT_HAND, along)
    else:
        along *= np.where((along * before).sum(axis=1) < 0, -1, 1)[:, None]
        way = bend * np.where(flat, before, along) + (1 - bend) * before
    unit: Floats = way / np.maximum(np.hypot(*way.T), 1e-9)[:, None]
    return unit


def spline(control: Floats) -> Floats:
    """The uniform cubic B-spline (n, 2) of control points, from the first to the last of them."""
    if len(control) < 3:
        return control
    ends = np.concatenate([control[:1], control[:1], control, control[-1:], control[-1:]])
    t = np.arange(SAMPLES)[:, None] / SAMPLES
    weights = (
        np.concatenate([(1 - t) ** 3, 3 * t**3 - 6 * t**2 + 4, -3 * t**3 + 3 * t**2 + 3 * t + 1, t**3], axis=1) / 6
    )
    windows = np.stack([ends[k : len(ends) - 3 + k] for k in range(4)], axis=1)
    curve = np.einsum("sk,wkd->wsd", weights, windows).reshape(-1, 2)
    return np.concatenate([curve, control[-1:]])


def _jittered(rgb: Image, manner: Manner, chance: np.random.Generator) -> NDArray[np.uint8]:
    """Colours (n, 3) with the manner's chance in them."""
    spread = chance.uniform(-0.5, 0.5, (len(rgb), 4)).astype(np.float32)
    mixed = np.clip(rgb + manner.rgb * 255 * spread[:, :3], 0, 255)
    hsv = np.asarray(cv2.cvtColor((mixed[None] / np.float32(255)).astype(np.float32), cv2.COLOR_RGB2HSV))[0]
    hsv[:, 0] = np.mod(hsv[:, 0] + 360 * manner.hue * spread[:, 3], 360)
    hsv[:, 1:] = np.clip(hsv[:, 1:] + np.array([manner.saturation, manner.value]) * spread[:, [1, 0]], 0, 1)
    back = np.asarray(cv2.cvtColor(hsv[None], cv2.COLOR_HSV2RGB))[0]
    return np.asarray(np.rint(back * 255), np.uint8)


def _painted(
    canvas: NDArray[np.uint8], lines: list[Floats], rgb: NDArray[np.uint8], radius: float, opacity: float
) -> NDArray[np.uint8]:
    """The canvas with a layer over it."""
    layer = canvas.copy()
    for line, colour in zip(lines, rgb.tolist(), strict=True):
        dab(layer, line, radius, colour)
    return np.asarray(cv2.addWeighted(layer, opacity, canvas, 1 - opacity, 0), np.uint8)


def dab(picture: NDArray[np.uint8] | NDArray[np.int32] | Image, line: Floats, radius: float, colour: list[int]) -> None:
    """A stroke of one colour, smooth at its border where the picture is 8-bit."""
    smooth = cv2.LINE_AA if picture.dtype == np.uint8 else cv2.LINE_8
    points = line if len(line) > 1 else np.repeat(line, 2, axis=0)
    fixed = np.rint(points * 2**_SHIFT).astype(np.int32)
    cv2.polylines(picture, [fixed], False, colour, max(1, round(2 * radius)), smooth, _SHIFT)
