"""Poses of the pen go in; all joint positions of a spherical-revolute-spherical arm that reach them come out.

Closed form, as in Shimizu, Kakuya, Yoon, Kitagaki & Kosuge 2008 (doi:10.1109/TRO.2008.2003266): seven joints whose axes
1 to 3 meet in a shoulder and 5 to 7 in a wrist leave the elbow free to turn about the line between them.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from limner import transforms
from limner.motion.arm.robot import Robot
from limner.types import Floats

BRANCHES = tuple(itertools.product((1, -1), repeat=3))
"""Signs of the elbow, of the shoulder's second joint and of the wrist's second joint."""

_Y, _Z = np.eye(3)[1], np.eye(3)[2]


@dataclass(frozen=True, eq=False)
class SphericalArm:
    """A robot as T = B Rz Ry Tz(upper) Rz Ry Tz(fore) Rz Ry Rz tool, its joints with signs.

    Attributes:
        shoulder: (4, 4) B, the frame in which the arm is straight along z when all joints are 0.
        upper_m, fore_m: shoulder to elbow, elbow to wrist.
        tool: (4, 4) from the wrist to the tip.
        signs: (7,) of each joint against the rotation above.
    """

    shoulder: Floats
    upper_m: float
    fore_m: float
    tool: Floats
    signs: Floats

    @classmethod
    def of(cls, robot: Robot, tolerance: float = 1e-9) -> SphericalArm | None:
        """The robot seen so, or None where its geometry is another."""
        if robot.dof != 7 or robot.prismatic.any():
            return None
        frames = robot.frames(np.zeros(7))
        axes = (frames[1:-1, :3, :3] @ robot.axes[..., None])[..., 0]
        origins = frames[1:-1, :3, 3]
        z, y = axes[0], axes[1]
        places = (origins[1::2] - origins[0]) @ z  # of shoulder, elbow and wrist along the straight arm
        if places[2] < places[0]:
            z, places = -z, -places
        signs = np.where(np.arange(7) % 2 == 0, axes @ z, axes @ y)
        off_axis = np.linalg.norm(np.cross(origins - origins[0], z), axis=1)
        straight = np.abs(np.abs(signs) - 1).max() < tolerance and off_axis.max() < tolerance and abs(z @ y) < tolerance
        upper, fore = places[1] - places[0], places[2] - places[1]
        if not straight or min(upper, fore) <= 0:
            return None
        turn = np.stack([np.cross(y, z), y, z], axis=1)
        wrist = transforms.transform(turn, origins[0] + places[2] * z)
        shoulder = transforms.transform(turn, origins[0] + places[0] * z)
        return cls(shoulder, upper, fore, transforms.inverse(wrist) @ frames[-1], np.sign(signs))

    def wrist_distance(self, tips: ArrayLike) -> Floats:
        """How far [m] the wrist is from the shoulder at poses (..., 4, 4) of the tip: (...)."""
        wrist = np.asarray(tips) @ transforms.inverse(self.tool)[:, 3]
        distance: Floats = np.linalg.norm(wrist[..., :3] - self.shoulder[:3, 3], axis=-1)
        return distance

    def within_reach(self, tips: ArrayLike) -> NDArray[np.bool_]:
        """Whether poses (..., 4, 4) of the tip are neither too far nor too near, limits aside: (...)."""
        distance = self.wrist_distance(tips)
        near: NDArray[np.bool_] = (distance <= self.upper_m + self.fore_m) & (
            distance >= abs(self.upper_m - self.fore_m)
        )
        return near

    def solve(self, tips: ArrayLike, elbow_rad: ArrayLike) -> tuple[Floats, NDArray[np.bool_]]:
        """All joint positions that bring the tip to some poses.

        Args:
            tips: (..., 4, 4) of the tip in the base frame.
            elbow_rad: (...) turn of the elbow about the line from shoulder to wrist, 0 where joint 3 is 0; broadcasts
                against the poses.

        Returns:
            (..., 8, 7) joint positions in (-pi, pi], whatever the limits, branches in the order of ``BRANCHES``;
            (...) whether the pose can be reached; positions are nearest to reaching where it cannot.
        """
        wrist = transforms.inverse(self.shoulder) @ np.asarray(tips) @ transforms.inverse(self.tool)
        elbow = np.asarray(elbow_rad, dtype=np.float64)
        shape = np.broadcast_shapes(wrist.shape[:-2], elbow.shape)
        wrist = np.broadcast_to(wrist, (*shape, 4, 4))
        place, turn = wrist[..., :3, 3], wrist[..., :3, :3]
        distance = np.linalg.norm(place, axis=-1)
        cosine = (distance**2 - self.upper_m**2 - self.fore_m**2) / (2 * self.upper_m * self.fore_m)
        reached = np.abs(cosine) <= 1
        bend = np.arccos(np.clip(cosine, -1, 1))
        towards = place / np.maximum(distance, 1e-12)[..., None]
        about = transforms.rotation(towards, elbow)
        q = np.empty((*shape, 8, 7))
        for number, (elbow_sign, shoulder_sign, wrist_sign) in enumerate(BRANCHES):
            q4 = elbow_sign * bend
            upper = about @ self._upper_arm(towards, q4)
            q[..., number, 0], q[..., number, 1], q[..., number, 2] = _euler(upper, shoulder_sign)
            q[..., number, 3] = q4
            hand = np.swapaxes(upper @ transforms.rotation(_Y, q4), -1, -2) @ turn
            q[..., number, 4], q[..., number, 5], q[..., number, 6] = _euler(hand, wrist_sign)
        return q * self.signs, reached

    def _upper_arm(self, towards: Floats, q4: Floats) -> Floats:
        """Rotation of the upper arm while joint 3 is 0 and the wrist lies in a direction."""
        lean = np.arctan2(self.fore_m * np.sin(q4), self.upper_m + self.fore_m * np.cos(q4))
        polar = np.arctan2(np.hypot(towards[..., 0], towards[..., 1]), towards[..., 2])
        azimuth = np.arctan2(towards[..., 1], towards[..., 0])
        result: Floats = transforms.rotation(_Z, azimuth) @ transforms.rotation(_Y, polar - lean)
        return result


def _euler(r: Floats, sign: int) -> tuple[Floats, Floats, Floats]:
    """Angles a, b, c with r = Rz(a) Ry(b) Rz(c) and b of the given sign; c = 0 where b leaves it open."""
    sine = sign * np.hypot(r[..., 0, 2], r[..., 1, 2])
    b = np.arctan2(sine, r[..., 2, 2])
    a = np.arctan2(sign * r[..., 1, 2], sign * r[..., 0, 2])
    # c from what is left after a, which is well defined even where b is 0.
    cosine_a, sine_a = np.cos(a), np.sin(a)
    c = np.arctan2(
        -sine_a * r[..., 0, 0] + cosine_a * r[..., 1, 0],
        -sine_a * r[..., 0, 1] + cosine_a * r[..., 1, 1],
    )
    return a, b, c
