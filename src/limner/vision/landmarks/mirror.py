"""Nothing in; which of the 68 landmarks each becomes when a picture is mirrored, out."""

from __future__ import annotations

import numpy as np

MIRROR = np.array(
    [
        *(*range(16, -1, -1), *range(26, 16, -1), *range(27, 31), *range(35, 30, -1)),
        *(45, 44, 43, 42, 47, 46, 39, 38, 37, 36, 41, 40),
        *(*range(54, 47, -1), *range(59, 54, -1), *range(64, 59, -1), 67, 66, 65),
    ]
)
"""(68,) iBUG landmarks: a face ``points`` (68, 2) mirrored is ``(points * [-1, 1])[MIRROR]``, shifted to the right."""
