"""Joint positions go in; where an arm's links and pen tip are, how they move, and which limits hold come out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from limner import transforms
from limner.errors import BadInput
from limner.types import Floats, Value, frozen_array

SAFE = "safe"
"""The pose that drawing starts from and returns to, where a robot has one of that name."""


@dataclass(frozen=True, eq=False)
class Capsule(Value):
    """What a link may touch with: all points within ``radius_m`` of a segment.

    Attributes:
        link: 0 = what does not move, i = what moves with joint i (counted from 1).
        start_m, end_m: (3,) of the segment, in the frame of that joint (of the base for 0).
        radius_m: > 0.
    """

    link: int
    start_m: Floats
    end_m: Floats
    radius_m: float

    def __post_init__(self) -> None:
        self._freeze("start_m", frozen_array(self.start_m, np.float64, (3,), "Capsule.start_m"))
        self._freeze("end_m", frozen_array(self.end_m, np.float64, (3,), "Capsule.end_m"))


@dataclass(frozen=True, eq=False)
class Mass(Value):
    """What a part of a link weighs.

    Attributes:
        link: as in ``Capsule``.
        kg: > 0.
        centre_m: (3,) centre of mass, in the frame of that joint.
        inertia: (3, 3) about the centre, axes of that frame [kg m^2].
    """

    link: int
    kg: float
    centre_m: Floats
    inertia: Floats

    def __post_init__(self) -> None:
        self._freeze("centre_m", frozen_array(self.centre_m, np.float64, (3,), "Mass.centre_m"))
        self._freeze("inertia", frozen_array(self.inertia, np.float64, (3, 3), "Mass.inertia"))
        if not 0 < self.kg < np.inf:
            raise BadInput(f"Mass.kg: {self.kg:g} kg, expected more than 0")


@dataclass(frozen=True, eq=False)
class Robot(Value):
    """A chain of joints from a base to the tip of a pen. Frames right-handed, lengths in metres, angles in radians.

    The tip's z axis points out of the pen, away from the arm.

    Attributes:
        name: of the robot.
        joints: names, from the base on (dof).
        before: (dof + 1, 4, 4) fixed transforms from the joint before (the base for the first) to each joint, and
            from the last joint to the tip.
        axes: (dof, 3) unit axis of each joint in its own frame.
        prismatic: (dof,) whether a joint slides instead of turning.
        lower, upper: (dof,) limits of position.
        velocity, acceleration, jerk: (dof,) limits, both ways.
        capsules: shapes for collision checks.
        masses: of the parts that move, as far as they are known; only a simulation needs them.
        poses: named joint positions; ``safe`` is where drawing starts and ends.
        sheet_box_m: (2, 3) lower and upper corner of the box in which the centre of a sheet may lie, base frame.
        base, tip: names of the links the chain goes between.
        root: name of the link that all of the robot hangs from; empty: the base.
        root_from_base: (4, 4) where the base is on it.
        controller: name of the robot's own trajectory controller, empty for none.
    """

    name: str
    joints: tuple[str, ...]
    before: Floats
    axes: Floats
    prismatic: NDArray[np.bool_]
    lower: Floats
    upper: Floats
    velocity: Floats
    acceleration: Floats
    jerk: Floats
    capsules: tuple[Capsule, ...] = ()
    masses: tuple[Mass, ...] = ()
    poses: Mapping[str, Floats] = field(default_factory=dict)
    sheet_box_m: Floats = field(default_factory=lambda: np.array([[-10.0] * 3, [10.0] * 3]))
    base: str = "base"
    tip: str = "tip"
    root: str = ""
    root_from_base: Floats = field(default_factory=lambda: np.eye(4))
    controller: str = ""

    def __post_init__(self) -> None:
        dof = len(self.joints)
        self._freeze("before", frozen_array(self.before, np.float64, (dof + 1, 4, 4), "Robot.before"))
        self._freeze("axes", frozen_array(self.axes, np.float64, (dof, 3), "Robot.axes"))
        self._freeze("prismatic", frozen_array(self.prismatic, np.bool_, (dof,), "Robot.prismatic"))
        for name in ("lower", "upper", "velocity", "acceleration", "jerk"):
            self._freeze(name, frozen_array(getattr(self, name), np.float64, (dof,), f"Robot.{name}"))
        self._freeze("sheet_box_m", frozen_array(self.sheet_box_m, np.float64, (2, 3), "Robot.sheet_box_m"))
        self._freeze("root_from_base", frozen_array(self.root_from_base, np.float64, (4, 4), "Robot.root_from_base"))
        self._check_limits()
        poses = {k: frozen_array(v, np.float64, (dof,), f"Robot.poses.{k}") for k, v in self.poses.items()}
        self._freeze("poses", poses)

    def _check_limits(self) -> None:
        for i, joint in enumerate(self.joints):
            if self.lower[i] >= self.upper[i]:
                limits = f"{self.lower[i]:g} to {self.upper[i]:g}"
                raise BadInput(f"robot {self.name}: joint {joint} may go from {limits}; expected lower < upper")
            for name in ("velocity", "acceleration", "jerk"):
                if (value := getattr(self, name)[i]) <= 0:
                    raise BadInput(f"robot {self.name}: joint {joint} has a {name} limit of {value:g}, expected > 0")

    @property
    def dof(self) -> int:
        """How many joints move."""
        return len(self.joints)

    def pose(self, name: str) -> Floats:
        """Joint positions (dof,) of a named pose.

        Raises:
            BadInput: the robot has no such pose.
        """
        if name not in self.poses:
            raise BadInput(f"robot {self.name}: no pose '{name}'; choose from {', '.join(self.poses) or 'none'}")
        return self.poses[name]

    def frames(self, q: ArrayLike) -> Floats:
        """Every joint's frame after it has moved, and the tip's, in the base frame.

        Args:
            q: (..., dof) [rad or m].

        Returns:
            (..., dof + 2, 4, 4): the base, each joint, the tip.
        """
        positions = np.asarray(q, dtype=np.float64)
        frames = np.empty((*positions.shape[:-1], self.dof + 2, 4, 4))
        frames[..., 0, :, :] = np.eye(4)
        for i in range(self.dof):
            frames[..., i + 1, :, :] = frames[..., i, :, :] @ self.before[i] @ self._moved(i, positions[..., i])
        frames[..., -1, :, :] = frames[..., -2, :, :] @ self.before[-1]
        return frames

    def _moved(self, i: int, position: Floats) -> Floats:
        if self.prismatic[i]:
            return transforms.transform(translation=position[..., None] * self.axes[i])
        return transforms.transform(transforms.rotation(self.axes[i], position))

    def forward(self, q: ArrayLike) -> Floats:
        """The tip's frame in the base frame: (..., dof) -> (..., 4, 4)."""
        return self.frames(q)[..., -1, :, :]

    def jacobian(self, q: ArrayLike) -> Floats:
        """How the tip moves with the joints, in the base frame.

        Args:
            q: (..., dof).

        Returns:
            (..., 6, dof): velocity of the tip [m], then angular velocity [rad], per unit of each joint's velocity.
        """
        frames = self.frames(q)
        axes = (frames[..., 1:-1, :3, :3] @ self.axes[..., None])[..., 0]
        arm = frames[..., -1:, :3, 3] - frames[..., 1:-1, :3, 3]
        slides = self.prismatic[:, None]
        linear = np.where(slides, axes, np.cross(axes, arm))
        angular = np.where(slides, 0.0, axes)
        return np.swapaxes(np.concatenate([linear, angular], axis=-1), -1, -2)

    def margin(self, q: ArrayLike) -> Floats:
        """Distance to the nearest limit of each joint, negative beyond it: (..., dof)."""
        positions = np.asarray(q, dtype=np.float64)
        return np.minimum(positions - self.lower, self.upper - positions)
