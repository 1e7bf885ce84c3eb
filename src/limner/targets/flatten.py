"""A path of lines and curves goes in; polylines no farther from it than a tolerance come out."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from limner.errors import BadInput
from limner.types import Floats

if TYPE_CHECKING:
    from svgelements import Path

MAX_PIECES = 20_000
"""A single curve that would need more straight pieces is refused."""

_LARGEST = 1e100


def flatten(path: Path, tolerance: float) -> Iterator[Floats]:
    """The subpaths of an SVG path as polylines (n, 2), closed ones with the last point = the first.

    Between two points of parameters h apart a curve is at most h^2 / 8 times its largest second derivative away
    from its chord, which gives the number of pieces.

    Args:
        path: of ``svgelements``, transforms applied.
        tolerance: in the path's unit.

    Raises:
        BadInput: a coordinate is not finite, or a curve is absurdly large.
    """
    from svgelements import Close, Move

    line: list[Floats] = []
    for segment in path:
        if isinstance(segment, Move):
            yield from _drawn(line)
            line = [_xy([segment.end])]
        elif isinstance(segment, Close):
            yield from _drawn([*line, line[0][:1]] if line else [])
            line = []
        else:
            line = line or [_xy([segment.start])]
            line.append(_pieces(segment, tolerance))
    yield from _drawn(line)


def _drawn(line: list[Floats]) -> Iterator[Floats]:
    if len(line) > 1:
        yield np.concatenate(line)


def _xy(points: list[Any]) -> Floats:
    if any(point is None for point in points):
        raise BadInput("a path lacks a coordinate")
    xy = np.array([(point.x, point.y) for point in points], dtype=np.float64)
    if not (np.abs(xy) < _LARGEST).all():
        raise BadInput("a path has a coordinate that is no finite number, or absurdly large")
    return xy


def _pieces(segment: Any, tolerance: float) -> Floats:
    """Points along a segment, its start left out."""
    from svgelements import Arc, CubicBezier, QuadraticBezier

    if isinstance(segment, QuadraticBezier):
        return _bezier(_xy([segment.start, segment.control, segment.end]), tolerance)
    if isinstance(segment, CubicBezier):
        return _bezier(_xy([segment.start, segment.control1, segment.control2, segment.end]), tolerance)
    if isinstance(segment, Arc):
        return _arc(segment, tolerance)
    return _xy([segment.end])


def _bezier(control: Floats, tolerance: float) -> Floats:
    degree = len(control) - 1
    bend = degree * (degree - 1) * np.hypot(*np.diff(control, 2, axis=0).T).max()
    t = _parameters(float(bend), tolerance)[:, None]
    weights = [math.comb(degree, k) * (1 - t) ** (degree - k) * t**k for k in range(degree + 1)]
    points: Floats = np.sum([weight * point for weight, point in zip(weights, control, strict=True)], axis=0)
    return points


def _arc(arc: Any, tolerance: float) -> Floats:
    if not (arc.rx and arc.ry and arc.sweep):
        return _xy([arc.end])
    bend = max(arc.rx, arc.ry) * arc.sweep**2
    angle = arc.get_start_t() + arc.sweep * _parameters(float(bend), tolerance)[:-1]
    along, across = _xy([arc.prx - arc.center, arc.pry - arc.center])
    x, y = np.cos(angle)[:, None], np.sin(angle)[:, None]
    return np.concatenate([_xy([arc.center]) + x * along + y * across, _xy([arc.end])])


def _parameters(bend: float, tolerance: float) -> Floats:
    """Evenly from above 0 to 1, for a curve whose second derivative is at most ``bend``."""
    pieces = math.sqrt(bend / (8 * tolerance)) if math.isfinite(bend) else math.inf
    if pieces > MAX_PIECES:
        raise BadInput(f"a curve needs more than {MAX_PIECES} straight pieces; scale it down")
    count = max(1, math.ceil(pieces))
    return np.arange(1, count + 1) / count
