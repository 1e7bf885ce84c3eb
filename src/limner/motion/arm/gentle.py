"""A time-optimal motion along a path goes in; a slower one that holds the joints' limits of jerk too comes out."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from limner.types import Floats

_STEP_S = 0.001
_WIDTHS_S = (0.03, 0.06, 0.1, 0.15, 0.22, 0.32, 0.45)

Law = Callable[[Floats], Floats]
"""Times (n,) to place, speed and acceleration along a path (3, n), all 0 or at rest outside the motion."""

Way = Callable[[Floats, int], Floats]
"""Places along a path (n,) and an order of derivative to values (n, k)."""


def gentle(law: Law, seconds: float, way: Way, limits: tuple[Floats, Floats, Floats]) -> tuple[Floats, Floats]:
    """The motion along the same path, its place averaged over a while, then slowed until all limits hold.

    An acceleration that jumps becomes one that rises evenly when the place is averaged over time; the path stays what
    it is. Of some widths of the average the one that is quickest in the end is taken.

    Args:
        law: of the motion along the path.
        seconds: that it takes.
        way: the path.
        limits: of velocity, acceleration and jerk (k,), k = columns of ``way``.

    Returns:
        Times (n,) in steps of about a millisecond; position, velocity and acceleration there (3, n, k).
    """
    tried = [_slowed(*_averaged(law, seconds, width), way, limits) for width in _WIDTHS_S]
    return min(tried, key=lambda one: float(one[0][-1]))


def _averaged(law: Law, seconds: float, width: float) -> tuple[Floats, Floats]:
    """Times (n,) and place, speed, acceleration (3, n), each the mean of the last ``width`` seconds."""
    count = int(np.ceil((seconds + width) / _STEP_S)) + 1
    t = np.linspace(0, seconds + width, count)
    back = max(1, round(width / (t[1] - t[0])))
    values = law(np.concatenate([t[0] - (t[1] - t[0]) * np.arange(back, 0, -1), t]))
    sums = np.cumsum(values, axis=1)
    mean: Floats = (sums[:, back:] - sums[:, :-back]) / back
    return t, mean


def _slowed(t: Floats, along: Floats, way: Way, limits: tuple[Floats, Floats, Floats]) -> tuple[Floats, Floats]:
    s, rate, change = along[0], along[1][:, None], along[2][:, None]
    slope, bend = way(s, 1), way(s, 2)
    moved = np.stack([way(s, 0), slope * rate, bend * rate**2 + slope * change])
    jerk = np.diff(moved[2], axis=0) / (t[1] - t[0])
    used = (np.abs(values).max(0) / limit for values, limit in zip((moved[1], moved[2], jerk), limits, strict=True))
    stretch = max(1.0, *(float(part.max()) ** (1 / order) for order, part in enumerate(used, 1)))
    scale = stretch ** -np.arange(3.0)
    return stretch * t, moved * scale[:, None, None]
