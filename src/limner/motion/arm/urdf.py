"""A URDF goes in; the chain of joints from its base to a pen's tip comes out as a Robot."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from limner import transforms
from limner.errors import BadInput
from limner.motion.arm.robot import Capsule, Mass, Robot
from limner.motion.arm.urdf_file import read_urdf
from limner.types import Floats, frozen_array

ASSUMED_ACCELERATION = 1.0
"""rad/s^2 (or m/s^2), where nothing says more: URDF has no field for it."""

ASSUMED_JERK = 15.0
"""rad/s^3 (or m/s^3), likewise."""

CONTINUOUS_RAD = 2 * math.pi
"""What a joint without limits may turn, both ways: cables do not turn for ever."""

LARGEST = 1e4
"""No length [m], angle [rad] or moment of inertia of an arm is larger."""

MOVING = ("revolute", "continuous", "prismatic")


@dataclass(frozen=True)
class ChainRequest:
    """What a URDF does not say about the arm in it.

    Attributes:
        base: link that the chain starts from; empty for the root.
        tip: link at the tip of the pen; empty for the only or deepest leaf.
        frozen: joints held at a position, such as the slide of a sprung pen.
        acceleration, jerk: limits of each moving joint [rad/s^2, rad/s^3]; empty for the assumed ones.
        poses: named joint positions.
        sheet_box_m: lower and upper corner of where the centre of a sheet may lie, in the base frame.
        controller: name of the trajectory controller.
    """

    base: str = ""
    tip: str = ""
    frozen: Mapping[str, float] | None = None
    acceleration: tuple[float, ...] = ()
    jerk: tuple[float, ...] = ()
    poses: Mapping[str, Any] | None = None
    sheet_box_m: tuple[tuple[float, ...], ...] = ((-10.0, -10.0, -10.0), (10.0, 10.0, 10.0))
    controller: str = ""


def parse_urdf(data: bytes, name: str, request: ChainRequest | None = None) -> Robot:
    """Read a robot.

    Args:
        data: the file.
        name: for messages.
        request: which chain, and what URDF cannot say.

    Raises:
        BadInput: no URDF, entities or nesting that could exhaust the reader, no such link, a joint without limits, or
            one that mimics another between base and tip.
        MissingExtra: the URDF reader is not installed.
    """
    return _Tree(read_urdf(data, name), name, request or ChainRequest()).robot()


def _origin(thing: Any) -> Floats:
    if thing.origin is None:
        return np.eye(4)
    turn = transforms.from_rpy(_numbers(thing.origin.rpy or (0, 0, 0), "rpy"))
    return transforms.transform(turn, _numbers(thing.origin.xyz or (0, 0, 0), "xyz"))


def _numbers(values: Any, what: str, shape: tuple[int, ...] = (3,)) -> Floats:
    """Finite, and no larger than anything on an arm is."""
    numbers = frozen_array(values, np.float64, shape, f"robot: {what}")
    if np.abs(numbers).max() > LARGEST:
        raise BadInput(f"robot: {what} has {np.abs(numbers).max():g}, expected up to {LARGEST:g}")
    return numbers


class _Tree:
    """The links of a URDF and how they hang together."""

    def __init__(self, urdf: Any, name: str, request: ChainRequest) -> None:
        self.name, self.request = name, request
        self.frozen = dict(request.frozen or {})
        self.links = {link.name: link for link in urdf.links}
        self.above = {joint.child: joint for joint in urdf.joints}
        self.below: dict[str, list[Any]] = {link: [] for link in self.links}
        for joint in urdf.joints:
            for link in (joint.parent, joint.child):
                if link not in self.links:
                    raise BadInput(f"{name}: joint {joint.name} names the link '{link}', which does not exist")
            self.below[joint.parent].append(joint)
        self._check_acyclic()

    def _check_acyclic(self) -> None:
        roots = [link for link in self.links if link not in self.above]
        if len(roots) != 1:
            raise BadInput(f"{self.name}: has {len(roots)} links without a parent, expected one")
        self.root = roots[0]
        todo, reached = [self.root], {self.root}
        while todo:
            found = {joint.child for joint in self.below[todo.pop()]} - reached
            reached |= found
            todo += found
        # Who has one parent and hangs on the root is in no ring.
        joints = sum(map(len, self.below.values()))
        if len(reached) < len(self.links) or joints > len(self.above):
            raise BadInput(f"{self.name}: its links are no tree: some hang on each other or on two others")

    def robot(self) -> Robot:
        chain = self._chain()
        moving = [joint for joint in chain if self._moves(joint)]
        if not moving:
            raise BadInput(f"{self.name}: no joint moves between '{self.base}' and '{self.tip}'; name another tip")
        for joint in moving:
            self._check(joint)
        lower, upper = zip(*map(self._limits, moving), strict=True)
        return Robot(
            name=self.name,
            joints=tuple(joint.name for joint in moving),
            before=self._before(chain),
            axes=np.array([_axis(joint, self.name) for joint in moving]),
            prismatic=np.array([joint.type == "prismatic" for joint in moving]),
            lower=np.array(lower),
            upper=np.array(upper),
            velocity=np.array([joint.limit.velocity for joint in moving]),
            acceleration=self._per_joint("acceleration", ASSUMED_ACCELERATION, len(moving)),
            jerk=self._per_joint("jerk", ASSUMED_JERK, len(moving)),
            capsules=tuple(self._capsules(moving)),
            masses=tuple(self._masses(moving)),
            poses=dict(self.request.poses or {}),
            sheet_box_m=_numbers(self.request.sheet_box_m, "sheet_box_m", (2, 3)),
            base=self.base,
            tip=self.tip,
            root=self.root,
            root_from_base=self._mount(),
            controller=self.request.controller,
        )

    def _moves(self, joint: Any) -> bool:
        return joint.type in MOVING and joint.name not in self.frozen

    def _chain(self) -> list[Any]:
        self.base = self._link(self.request.base or self.root, "base")
        self.tip = self._link(self.request.tip or self._leaf(), "tip")
        chain, link = [], self.tip
        while link != self.base:
            if link not in self.above:
                raise BadInput(
                    f"{self.name}: link '{self.tip}' does not hang on '{self.base}'; name another base or tip"
                )
            chain.append(self.above[link])
            link = self.above[link].parent
        return chain[::-1]

    def _link(self, link: str, what: str) -> str:
        if link not in self.links:
            raise BadInput(f"{self.name}: {what} '{link}' is no link; choose from {', '.join(self.links)}")
        return link

    def _leaf(self) -> str:
        leaves = [link for link in self.links if not self.below[link]]
        if len(leaves) > 1:
            raise BadInput(f"{self.name}: several links could be the pen's tip; name one: {', '.join(leaves)}")
        return str(leaves[0])

    def _check(self, joint: Any) -> None:
        if joint.mimic is not None:
            raise BadInput(
                f"{self.name}: joint {joint.name} mimics {joint.mimic.joint}; an arm with such a joint between base and"
                " tip cannot be planned; name a tip before it"
            )
        if joint.limit is None or (joint.type != "continuous" and joint.limit.lower == joint.limit.upper):
            raise BadInput(f"{self.name}: joint {joint.name} has no limits; add <limit lower upper velocity effort>")

    def _limits(self, joint: Any) -> tuple[float, float]:
        if joint.type == "continuous":
            return -CONTINUOUS_RAD, CONTINUOUS_RAD
        lower, upper = _numbers((joint.limit.lower, joint.limit.upper), f"limits of {joint.name}", (2,)).tolist()
        return lower, upper

    def _per_joint(self, what: str, assumed: float, dof: int) -> Floats:
        given = getattr(self.request, what) or (assumed,)
        if len(given) not in (1, dof):
            raise BadInput(f"{self.name}: {len(given)} values of {what} for {dof} joints; give one or {dof}")
        return np.broadcast_to(frozen_array(given, np.float64, (None,), f"{self.name}: {what}"), (dof,))

    def _held(self, joint: Any) -> Floats:
        """From a joint's parent to its child while it does not move."""
        position = float(_numbers(self.frozen.get(joint.name, 0.0), f"the place of {joint.name}", ()))
        if joint.type not in MOVING or not position:
            return _origin(joint)
        axis = _axis(joint, self.name)
        if joint.type == "prismatic":
            return _origin(joint) @ transforms.transform(translation=position * axis)
        return _origin(joint) @ transforms.transform(transforms.rotation(axis, position))

    def _mount(self) -> Floats:
        """Where the base is on the root; what moves between them is held."""
        frame, link = np.eye(4), self.base
        while link in self.above:
            frame, link = self._held(self.above[link]) @ frame, self.above[link].parent
        return frame

    def _before(self, chain: list[Any]) -> Floats:
        before, fixed = [], np.eye(4)
        for joint in chain:
            fixed = fixed @ self._held(joint)
            if self._moves(joint):
                before.append(fixed)
                fixed = np.eye(4)
        return np.array([*before, fixed])

    def _capsules(self, moving: list[Any]) -> list[Capsule]:
        """Shapes of all links."""
        return [
            capsule
            for link, number, frame in self._parts(moving)
            for shape in _shapes(self.links[link])
            if (capsule := _capsule(shape, number, frame))
        ]

    def _masses(self, moving: list[Any]) -> list[Mass]:
        """Masses of the links that move and have any."""
        return [
            mass
            for link, number, frame in self._parts(moving)
            if number and (mass := self._mass(self.links[link], number, frame))
        ]

    def _mass(self, link: Any, number: int, frame: Floats) -> Mass | None:
        inertial = link.inertial
        if inertial is None or inertial.inertia is None or not inertial.mass:
            return None
        placed = frame @ _origin(inertial)
        turn = placed[:3, :3]
        try:
            inertia = turn @ _numbers(inertial.inertia.to_matrix(), "inertia", (3, 3)) @ turn.T
            return Mass(number, float(inertial.mass), placed[:3, 3], inertia)
        except BadInput as error:
            raise BadInput(f"{self.name}: link {link.name}: {error}") from error

    def _parts(self, moving: list[Any]) -> Iterator[tuple[str, int, Floats]]:
        """Every link, the number of the joint that moves it, its frame there; what is beside the chain is held."""
        index = {joint.name: i + 1 for i, joint in enumerate(moving)}
        todo, seen = [(self.base, 0, np.eye(4))], {self.base}
        while todo:
            link, number, frame = todo.pop()
            yield link, number, frame
            steps = [(joint.child, joint, False) for joint in self.below[link]]
            if link in self.above:
                steps.append((self.above[link].parent, self.above[link], True))
            for other, joint, upwards in steps:
                if other in seen:
                    continue
                seen.add(other)
                if joint.name in index and not upwards:
                    todo.append((other, index[joint.name], np.eye(4)))
                else:
                    step = self._held(joint)
                    todo.append((other, number, frame @ (transforms.inverse(step) if upwards else step)))


def _axis(joint: Any, name: str) -> Floats:
    axis = _numbers(joint.axis or (1, 0, 0), f"the axis of {joint.name}")
    if np.linalg.norm(axis) < 1e-6:
        raise BadInput(f"{name}: joint {joint.name} has the axis {axis.tolist()}, expected a direction")
    unit: Floats = axis / np.linalg.norm(axis)
    return unit


def _shapes(link: Any) -> list[Any]:
    return [shape for shape in (link.collisions or link.visuals) if shape.geometry is not None]


def _capsule(shape: Any, number: int, frame: Floats) -> Capsule | None:
    """The smallest capsule along a primitive that holds all of it; none for a mesh, whose file is not read."""
    geometry = shape.geometry
    if hasattr(geometry, "length"):
        length, radius = _numbers((geometry.length, geometry.radius), "a cylinder", (2,))
        half = length / 2 * np.eye(3)[2]
    elif hasattr(geometry, "radius"):
        half, radius = np.zeros(3), _numbers(geometry.radius, "a sphere", ())
    elif hasattr(geometry, "size"):
        sides = _numbers(geometry.size, "a box") / 2
        longest = int(sides.argmax())
        across = float(np.hypot(*np.delete(sides, longest)))
        # A tenth more radius lets the round caps end near the box's flat ones.
        radius = 1.1 * across
        half = np.eye(3)[longest] * max(0.0, sides[longest] - (radius**2 - across**2) ** 0.5)
    else:
        return None
    start, end = transforms.apply(frame @ _origin(shape), np.stack([-half, half]))
    return Capsule(number, start, end, float(radius))
