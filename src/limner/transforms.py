"""Rigid motions: rotations and 4x4 transforms of (..., 4, 4) arrays, quaternions w, x, y, z; angles in radians."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from limner.types import Floats


def rotation(axis: ArrayLike, angle_rad: ArrayLike) -> Floats:
    """Rotation matrices about unit axes (Rodrigues).

    Args:
        axis: (..., 3) of length 1.
        angle_rad: (...), right-handed about the axis.

    Returns:
        (..., 3, 3).
    """
    k = np.asarray(axis, dtype=np.float64)
    angle = np.asarray(angle_rad, dtype=np.float64)[..., None, None]
    cross = np.zeros((*k.shape[:-1], 3, 3))
    cross[..., 0, 1], cross[..., 0, 2], cross[..., 1, 2] = -k[..., 2], k[..., 1], -k[..., 0]
    cross[..., 1, 0], cross[..., 2, 0], cross[..., 2, 1] = k[..., 2], -k[..., 1], k[..., 0]
    result: Floats = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * (cross @ cross)
    return result


def transform(rotation_matrix: ArrayLike | None = None, translation: ArrayLike = (0.0, 0.0, 0.0)) -> Floats:
    """A 4x4 transform from a rotation (..., 3, 3) and a translation (..., 3); both broadcast."""
    turn = np.eye(3) if rotation_matrix is None else np.asarray(rotation_matrix, dtype=np.float64)
    move = np.asarray(translation, dtype=np.float64)
    shape = np.broadcast_shapes(turn.shape[:-2], move.shape[:-1])
    result = np.zeros((*shape, 4, 4))
    result[..., :3, :3] = turn
    result[..., :3, 3] = move
    result[..., 3, 3] = 1
    return result


def inverse(transforms: Floats) -> Floats:
    """Inverses of rigid transforms (..., 4, 4)."""
    back = np.swapaxes(transforms[..., :3, :3], -1, -2)
    return transform(back, -(back @ transforms[..., :3, 3:])[..., 0])


def apply(transforms: Floats, points: ArrayLike) -> Floats:
    """Points (..., 3) moved by transforms (..., 4, 4), which broadcast against each other."""
    moved: Floats = (transforms[..., :3, :3] @ np.asarray(points, dtype=np.float64)[..., None])[..., 0]
    return moved + transforms[..., :3, 3]


def from_rpy(rpy_rad: ArrayLike) -> Floats:
    """The rotation of URDF's roll, pitch, yaw: about fixed x, then y, then z; (3, 3)."""
    roll, pitch, yaw = np.asarray(rpy_rad, dtype=np.float64)
    x, y, z = np.eye(3)
    result: Floats = rotation(z, yaw) @ rotation(y, pitch) @ rotation(x, roll)
    return result


def to_quaternion(rotations: ArrayLike) -> Floats:
    """Unit quaternions (..., 4), w first and not negative, of rotations (..., 3, 3).

    Shepperd 1978 (doi:10.2514/3.55767b): from the largest of the four squared components, so that none is lost.
    """
    r = np.asarray(rotations, dtype=np.float64)
    xx, yy, zz = r[..., 0, 0], r[..., 1, 1], r[..., 2, 2]
    # Row i holds the quaternion times four times its own i-th component.
    rows = np.empty((*r.shape[:-2], 4, 4))
    rows[..., 0, 0], rows[..., 1, 1] = 1 + xx + yy + zz, 1 + xx - yy - zz
    rows[..., 2, 2], rows[..., 3, 3] = 1 - xx + yy - zz, 1 - xx - yy + zz
    for i, j, value in (
        (0, 1, r[..., 2, 1] - r[..., 1, 2]),
        (0, 2, r[..., 0, 2] - r[..., 2, 0]),
        (0, 3, r[..., 1, 0] - r[..., 0, 1]),
        (1, 2, r[..., 0, 1] + r[..., 1, 0]),
        (1, 3, r[..., 0, 2] + r[..., 2, 0]),
        (2, 3, r[..., 1, 2] + r[..., 2, 1]),
    ):
        rows[..., i, j] = rows[..., j, i] = value
    largest = np.diagonal(rows, axis1=-2, axis2=-1).argmax(-1)
    row = np.take_along_axis(rows, largest[..., None, None], -2)[..., 0, :]
    row = row / np.linalg.norm(row, axis=-1, keepdims=True)
    upper_half: Floats = np.where(row[..., :1] < 0, -row, row)
    return upper_half


def from_quaternion(wxyz: ArrayLike) -> Floats:
    """Rotations (..., 3, 3) of quaternions (..., 4), w first, of any length but zero."""
    q = np.asarray(wxyz, dtype=np.float64)
    q = q / np.linalg.norm(q, axis=-1, keepdims=True)
    w, v = q[..., :1, None], q[..., 1:]
    cross = np.cross(np.eye(3), v[..., None, :])
    result: Floats = np.eye(3) * (2 * w * w - 1) + 2 * v[..., :, None] * v[..., None, :] + 2 * w * cross
    return result
