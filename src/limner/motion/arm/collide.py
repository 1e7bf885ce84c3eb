"""Joint positions go in; where the arm touches the table or itself comes out, its links seen as capsules."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from limner import transforms
from limner.motion.arm.robot import Robot
from limner.types import Floats


@dataclass(frozen=True)
class Collision:
    """Two things that touch.

    Attributes:
        sample: which of the joint positions.
        link: number of the link, 0 = what does not move.
        other: of the other link, -1 = the table.
        depth_m: how deep.
    """

    sample: int
    link: int
    other: int
    depth_m: float

    def describe(self, robot: Robot) -> str:
        """In words."""
        names = ["the base", *(f"the link after {joint}" for joint in robot.joints)]
        with_what = "the table" if self.other < 0 else names[self.other]
        return f"{names[self.link]} touches {with_what} ({1000 * self.depth_m:.0f} mm deep)"


def deepest(robot: Robot, q: Floats, base_from_paper: Floats | None = None) -> Collision | None:
    """The deepest collision along a motion, if there is any.

    Links next to each other on the chain are let through, and so are pairs that touch in the robot's ``home`` pose
    already; the last link holds the pen and may reach down to the paper.

    Args:
        robot: with its capsules.
        q: (n, dof) joint positions, close together.
        base_from_paper: (4, 4) the table is its plane; None for no table.
    """
    starts, ends, radii, links = _placed(robot, q)
    found = [*_with_itself(robot, starts, ends, radii, links)]
    if base_from_paper is not None:
        found += _with_table(robot, starts, ends, radii, links, base_from_paper)
    return max(found, key=lambda collision: collision.depth_m, default=None)


def _placed(robot: Robot, q: Floats) -> tuple[Floats, Floats, Floats, NDArray[np.int64]]:
    """Both ends (n, capsules, 3) in the base frame, radii and links of the capsules."""
    links = np.array([capsule.link for capsule in robot.capsules], dtype=np.int64)
    frames = robot.frames(q)[:, links]
    starts = transforms.apply(frames, np.array([c.start_m for c in robot.capsules]).reshape(-1, 3))
    ends = transforms.apply(frames, np.array([c.end_m for c in robot.capsules]).reshape(-1, 3))
    return starts, ends, np.array([capsule.radius_m for capsule in robot.capsules]), links


def _with_table(
    robot: Robot, starts: Floats, ends: Floats, radii: Floats, links: NDArray[np.int64], base_from_paper: Floats
) -> list[Collision]:
    origin, normal = base_from_paper[:3, 3], base_from_paper[:3, 2]
    height = np.minimum((starts - origin) @ normal, (ends - origin) @ normal) - radii
    # The base may stand on or beside the table, and the pen is there to touch the paper.
    height[:, (links == 0) | (links == robot.dof)] = np.inf
    if not height.size or height.min() >= 0:
        return []
    sample, which = np.unravel_index(int(height.argmin()), height.shape)
    return [Collision(int(sample), int(links[which]), -1, float(-height[sample, which]))]


def _with_itself(
    robot: Robot, starts: Floats, ends: Floats, radii: Floats, links: NDArray[np.int64]
) -> list[Collision]:
    i, j = np.triu_indices(len(links), 1)
    apart = np.abs(links[i] - links[j]) > 1
    i, j = i[apart], j[apart]
    allowed = _touching_at_home(robot)
    keep = np.array([(links[a], links[b]) not in allowed for a, b in zip(i, j, strict=True)], dtype=bool)
    i, j = i[keep], j[keep]
    if not len(i):
        return []
    gap = segment_distance(starts[:, i], ends[:, i], starts[:, j], ends[:, j]) - radii[i] - radii[j]
    if gap.min() >= 0:
        return []
    sample, pair = np.unravel_index(int(gap.argmin()), gap.shape)
    return [Collision(int(sample), int(links[i[pair]]), int(links[j[pair]]), float(-gap[sample, pair]))]


def _touching_at_home(robot: Robot) -> set[tuple[int, int]]:
    if "home" not in robot.poses:
        return set()
    starts, ends, radii, links = _placed(robot, robot.poses["home"][None])
    i, j = np.triu_indices(len(links), 1)
    gap = segment_distance(starts[0, i], ends[0, i], starts[0, j], ends[0, j]) - radii[i] - radii[j]
    return {(int(links[a]), int(links[b])) for a, b, g in zip(i, j, gap, strict=True) if g < 0}


def segment_distance(p0: Floats, p1: Floats, q0: Floats, q1: Floats) -> Floats:
    """Distance between segments p0-p1 and q0-q1, all (..., 3): (...).

    Ericson 2005, Real-Time Collision Detection, section 5.1.9.
    """
    d1, d2, r = p1 - p0, q1 - q0, p0 - q0
    a, e, f = (d1 * d1).sum(-1), (d2 * d2).sum(-1), (d2 * r).sum(-1)
    b, c = (d1 * d2).sum(-1), (d1 * r).sum(-1)
    tiny = 1e-15
    denominator = a * e - b * b
    s = np.where(denominator > tiny, np.clip((b * f - c * e) / np.maximum(denominator, tiny), 0, 1), 0.0)
    t = np.where(e > tiny, (b * s + f) / np.maximum(e, tiny), 0.0)
    clipped = np.clip(t, 0, 1)
    s = np.where(t != clipped, np.clip((b * clipped - c) / np.maximum(a, tiny), 0, 1), s)
    s = np.where(e <= tiny, np.clip(-c / np.maximum(a, tiny), 0, 1), s)
    distance: Floats = np.linalg.norm(p0 + s[..., None] * d1 - q0 - clipped[..., None] * d2, axis=-1)
    return distance
