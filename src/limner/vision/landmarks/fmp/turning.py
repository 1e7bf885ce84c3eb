"""Landmarks of a face in; where each point of the picture goes when the head turns a little to the side, out."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from limner.types import Floats

_JAW = [-0.45, -0.45, -0.42, -0.36, -0.28, -0.15, 0.0, 0.1, 0.15]
_BROW = [-0.02, 0.08, 0.14, 0.18, 0.2]
_NOSE = [0.18, 0.28, 0.38, 0.5, 0.24, 0.29, 0.34, 0.29, 0.24]
_EYE = [0.0, 0.08, 0.1, 0.08, 0.1, 0.08]
_OTHER_EYE = [_EYE[k] for k in (3, 2, 1, 0, 5, 4)]
_OUTER_LIPS = [0.15, 0.24, 0.31, 0.34, 0.31, 0.24, 0.15, 0.24, 0.3, 0.32, 0.3, 0.24]
_INNER_LIPS = [0.16, 0.27, 0.31, 0.27, 0.16, 0.27, 0.31, 0.27]
DEPTH = np.array([*_JAW, *_JAW[-2::-1], *_BROW, *_BROW[::-1], *_NOSE, *_EYE, *_OTHER_EYE, *_OUTER_LIPS, *_INNER_LIPS])
"""(68,) how far each iBUG landmark of an average head stands before the outer eye corners, in outer-eye distances."""

_FOREHEAD = np.array([[-0.5, -0.75], [0.0, -0.85], [0.5, -0.75]])
_FOREHEAD_DEPTH = np.array([-0.15, 0.05, -0.15])
_BEHIND = 1.9
"""Radius of the ring around the face that turns as what lies behind it [outer-eye distances]."""
_BEHIND_DEPTH = -0.5
_RING = 12
_SMOOTHING = 1e-5
_GRID_PX = 4
"""The warp is computed on such a grid and interpolated between."""


@dataclass(frozen=True, eq=False)
class Turn:
    """A head turned by so many degrees.

    Attributes:
        points: (68, 2) the landmarks after turning.
        back_x, back_y: (H, W) where each pixel of the turned picture comes from.
    """

    points: Floats
    back_x: Floats
    back_y: Floats


def turn(points: Floats, yaw_deg: float, size: tuple[int, int]) -> Turn:
    """Turn a face by moving its landmarks as those of an average head, and all between by a thin-plate spline.

    What was hidden stays hidden: good for some 25 degrees, to learn from, not to look at.

    Args:
        points: (68, 2) landmarks in the picture, x right, y down [px].
        yaw_deg: positive = the nose goes to image right.
        size: width and height of the picture [px].
    """
    left, right = points[36], points[45]
    eye_px = float(np.hypot(*(right - left)))
    along = (right - left) / eye_px
    frame = np.array([along, [-along[1], along[0]]])
    centre = (left + right) / 2
    angles = np.arange(_RING) * 2 * np.pi / _RING
    ring = np.stack([np.cos(angles), np.sin(angles)], axis=1) * _BEHIND + [0, 0.4]
    face = (points - centre) @ frame.T / eye_px
    control = np.vstack([face, _FOREHEAD, ring])
    depth = np.concatenate([DEPTH, _FOREHEAD_DEPTH, np.full(_RING, _BEHIND_DEPTH)])
    angle = np.radians(yaw_deg)
    turned = control.copy()
    turned[:, 0] = control[:, 0] * np.cos(angle) + depth * np.sin(angle)
    to_px = frame * eye_px
    after, before = turned @ to_px + centre, control @ to_px + centre
    back_x, back_y = _warp(after, before - after, size, eye_px)
    return Turn(after[:68], back_x, back_y)


def _warp(at: Floats, shift: Floats, size: tuple[int, int], unit_px: float) -> tuple[Floats, Floats]:
    """For every pixel its place plus a thin-plate spline (Bookstein 1989, doi:10.1109/34.24792) of the shifts.

    The spline is smoothed a little, since landmarks may coincide (the inner lips of a closed mouth).
    """
    width, height = size
    cols, rows = max(2, width // _GRID_PX), max(2, height // _GRID_PX)
    grid_x, grid_y = np.meshgrid(np.linspace(0, width - 1, cols), np.linspace(0, height - 1, rows))
    grid = np.stack([grid_x.ravel(), grid_y.ravel()], axis=1)
    at, grid, n = at / unit_px, grid / unit_px, len(at)
    system = np.zeros((n + 3, n + 3))
    system[:n, :n] = _kernel(at, at) + _SMOOTHING * np.eye(n)
    system[:n, n:] = np.column_stack([np.ones(n), at])
    system[n:, :n] = system[:n, n:].T
    weights = np.linalg.solve(system, np.vstack([shift, np.zeros((3, 2))]))
    moved = grid * unit_px + np.column_stack([_kernel(grid, at), np.ones(len(grid)), grid]) @ weights
    fields = moved.reshape(rows, cols, 2).astype(np.float32)
    return _enlarged(fields[..., 0], size), _enlarged(fields[..., 1], size)


def _kernel(a: Floats, b: Floats) -> Floats:
    squared = ((a[:, None] - b[None]) ** 2).sum(axis=-1)
    kernel: Floats = squared * np.log(np.maximum(squared, 1e-12))
    return kernel


def _enlarged(field: Floats, size: tuple[int, int]) -> Floats:
    """The field between its grid points, whose first and last lie on the first and last pixel."""
    rows, cols = field.shape
    x = np.linspace(0, cols - 1, size[0], dtype=np.float32)
    y = np.linspace(0, rows - 1, size[1], dtype=np.float32)
    return np.asarray(cv2.remap(field, *np.meshgrid(x, y), interpolation=cv2.INTER_LINEAR), np.float64)
