"""A skeleton goes in; ordered lines through its pixels come out, smooth and with few points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from limner import geometry
from limner.settings import SettingsGroup, setting
from limner.types import Floats
from limner.vision.chains import join_gaps
from limner.vision.graph import branches_of, cross_bridges, merge_junctions, prune_spurs, through_nodes
from limner.vision.raster import Mask

_LEAST_SHRINKING = 1 / 30
_ONE_JUNCTION_PX = 3.0


@dataclass(frozen=True)
class TraceSettings(SettingsGroup):
    """How a skeleton becomes lines; pixels are those of the working scale."""

    spur_px: float = setting(
        8.0, "side branches shorter than this are dropped; 0 keeps all", unit="px", low=0, high=100
    )
    bend_deg: float = setting(
        60.0, "largest bend over which a line goes on through a junction", unit="deg", low=0, high=180
    )
    bridge_px: float = setting(
        20.0, "lines that cross may run together for this long and still cross", unit="px", low=0, high=100
    )
    bridge_bend_deg: float = setting(25.0, "largest bend of a line over such a bridge", unit="deg", low=0, high=90)
    gap_px: float = setting(6.0, "ends nearer than this that face each other are joined", unit="px", low=0, high=50)
    gap_bend_deg: float = setting(35.0, "largest bend at either side of such a gap", unit="deg", low=0, high=90)
    shortest_px: float = setting(10.0, "lines shorter than this are dropped", unit="px", low=0, high=500)
    smooth_px: float = setting(
        2.5, "smoothing of the pixel staircase, standard deviation along the line", unit="px", low=0, high=20
    )
    step_px: float = setting(
        2.0, "points nearer than this to the one before are skipped (thesis 4.3.1)", unit="px", low=0, high=50
    )
    tolerance_px: float = setting(
        0.1, "how far a line may move when points on nearly straight parts are dropped", unit="px", low=0, high=10
    )


def trace(skeleton: Mask, settings: TraceSettings, mask: Mask | None = None) -> list[Floats]:
    """Ordered lines along a skeleton.

    Args:
        skeleton: (H, W) bool, one pixel wide.
        settings: lengths in pixels of the skeleton.
        mask: (H, W) what the skeleton was made of, for lines in its middle rather than on its pixels.

    Returns:
        Polylines (n, 2) x, y; closed when first = last.
    """
    branches = prune_spurs(branches_of(skeleton), settings.spur_px)
    branches = cross_bridges(merge_junctions(branches, _ONE_JUNCTION_PX), settings.bridge_px, settings.bridge_bend_deg)
    paths = [branch.path for branch in through_nodes(branches, settings.bend_deg)]
    paths = join_gaps(paths, settings.gap_px, np.deg2rad(settings.gap_bend_deg))
    paths = [path for path in paths if geometry.length(path) >= settings.shortest_px]
    if mask is not None and paths:
        ends = np.cumsum([len(path) for path in paths])
        paths = np.split(centre(np.concatenate(paths), mask), ends[:-1])
    spaced = [skip_near(smooth(path, settings.smooth_px), settings.step_px) for path in paths]
    return geometry.simplify_all(spaced, settings.tolerance_px)


def centre(path: Floats, mask: Mask) -> Floats:
    """Move each pixel to the middle of the mask's pixels next to it: an even width has no middle pixel.

    Args:
        path: (n, 2) whole pixels x, y of the mask, of one path or of many.
        mask: (H, W) bool.
    """
    columns, rows = path.astype(np.int64).T + 1
    framed = np.pad(mask, 1)
    near = np.array([[framed[rows + dy, columns + dx] for dx in (-1, 0, 1)] for dy in (-1, 0, 1)], np.float64)
    count = np.maximum(near.sum(axis=(0, 1)), 1)
    shift = np.stack([near[:, 2] - near[:, 0], near[2] - near[0]]).sum(axis=1) / count
    centred: Floats = path + shift.T
    return centred


def smooth(line: Floats, sigma: float) -> Floats:
    """A line without the stairs of the pixel grid: its points averaged with a Gaussian along it.

    The ends of an open line stay where they are; a closed line stays closed, and a short one is smoothed less, so that
    small rings do not shrink.

    Args:
        line: (n, 2) about evenly spaced.
        sigma: standard deviation along the line, in its unit; 0 leaves it as it is.
    """
    if sigma == 0 or len(line) < 3:
        return line.copy()
    closed = geometry.is_closed(line)
    points = line[:-1] if closed else line
    length = geometry.length(line)
    sigma, spacing = min(sigma, length * _LEAST_SHRINKING), length / (len(line) - 1)
    reach = max(1, int(np.ceil(3 * sigma / spacing)))
    padded = _beyond(points, min(reach, len(points) - 1), closed)
    reach = (len(padded) - len(points)) // 2
    kernel = np.exp(-0.5 * (np.arange(-reach, reach + 1) * spacing / sigma) ** 2)
    kernel /= kernel.sum()
    x, y = (np.convolve(padded[:, axis], kernel, mode="valid") for axis in (0, 1))
    result = np.stack([x, y], axis=1)
    return np.concatenate([result, result[:1]]) if closed else result


def _beyond(points: Floats, reach: int, closed: bool) -> Floats:
    """The points with ``reach`` more at either side: around a ring, or turned about an end, which holds it in place."""
    if closed:
        return np.concatenate([points[-reach:], points, points[:reach]])
    before = 2 * points[0] - points[reach:0:-1]
    after = 2 * points[-1] - points[-2 : -reach - 2 : -1]
    return np.concatenate([before, points, after])


def skip_near(line: Floats, step: float) -> Floats:
    """Skip each point that is nearer than ``step`` to the last one kept (thesis 4.3.1); both ends stay."""
    if step == 0 or len(line) < 3:
        return line.copy()
    points = line.tolist()
    kept = [0]
    for i, (x, y) in enumerate(points[1:-1], 1):
        x0, y0 = points[kept[-1]]
        if (x - x0) ** 2 + (y - y0) ** 2 >= step * step:
            kept.append(i)
    return line[[*kept, len(line) - 1]]
