"""A robot, its pen and a sheet go in; the MJCF text of the model that MuJoCo simulates comes out."""

from __future__ import annotations

import math
from xml.sax.saxutils import quoteattr

import numpy as np

from limner import transforms
from limner.motion.arm.robot import Capsule, Mass, Robot
from limner.simulation.settings import SimulationSettings
from limner.simulation.sheet import Sheet
from limner.types import Floats

STEP_S = 0.001
"""Of the simulation."""

TIP_RADIUS_M = 0.0005
PEN_KG = 0.02

_DENSITY = 1500.0
"""kg/m^3 of a link whose mass is not known (assumed)."""

_PEN_DAMPING = 2.0
"""N s/m of the slide (assumed)."""


_CONTACT = 'condim="1" solref="0.004 1" solimp="0.95 0.99 0.0002"'
"""Hard, and without friction: that is a force of its own, since MuJoCo's pushes what slides off the paper."""


def to_mjcf(robot: Robot, sheet: Sheet, settings: SimulationSettings) -> str:
    """The model: the chain of joints, two servo inputs for each, the pen on its slide, and the paper as a plane.

    Only the pen's tip and the paper touch: that the arm hits nothing is checked when it is planned. The servos
    make up for gravity. Bodies, joints and the pen are called as in ``body_name``, the robot's joints and ``pen``.
    """
    bodies = "".join(_link_start(robot, i, settings) for i in range(robot.dof))
    pen = _pen(robot, settings)
    servos = "".join(
        f'<general name="{kind}{i}" joint={quoteattr(name)} gaintype="fixed" biastype="affine"/>'
        for kind in ("p", "v")
        for i, name in enumerate(robot.joints)
    )
    return (
        f"<mujoco model={quoteattr(robot.name)}>"
        '<compiler angle="radian" autolimits="true" balanceinertia="true" boundmass="0.001" boundinertia="0.000001"/>'
        f'<option timestep="{STEP_S}" integrator="implicitfast"/>'
        '<default><geom contype="0" conaffinity="0" mass="0"/></default>'
        f"<worldbody>{_paper(sheet)}{bodies}{pen}{'</body>' * robot.dof}</worldbody>"
        f"<actuator>{servos}</actuator></mujoco>"
    )


def _paper(sheet: Sheet) -> str:
    return (
        f'<geom name="paper" type="plane" size="1 1 0.1" {_pose(sheet.base_from_paper)} contype="1" conaffinity="1"'
        f" {_CONTACT}/>"
    )


def _link_start(robot: Robot, i: int, settings: SimulationSettings) -> str:
    """The body that moves with joint i, not yet closed: the rest of the chain hangs in it."""
    kind = "slide" if robot.prismatic[i] else "hinge"
    masses = [mass for mass in robot.masses if mass.link == i + 1] or [_assumed(robot, i + 1)]
    return (
        f'<body name="{body_name(i)}" {_pose(robot.before[i])} gravcomp="1">'
        f'<joint name={quoteattr(robot.joints[i])} type="{kind}" axis="{_numbers(robot.axes[i])}" limited="false"'
        f' armature="{settings.armature_kg_m2}"/>{"".join(map(_mass, masses))}'
    )


def body_name(i: int) -> str:
    """Of the body that moves with joint i."""
    return f"link{i + 1}"


def _mass(mass: Mass) -> str:
    matrix = mass.inertia
    full = [matrix[0, 0], matrix[1, 1], matrix[2, 2], matrix[0, 1], matrix[0, 2], matrix[1, 2]]
    return (
        f'<body pos="{_numbers(mass.centre_m)}" gravcomp="1">'
        f'<inertial pos="0 0 0" mass="{mass.kg}" fullinertia="{_numbers(full)}"/></body>'
    )


def _assumed(robot: Robot, link: int) -> Mass:
    """The mass of a link from its shapes; a little where it has none."""
    shapes = [capsule for capsule in robot.capsules if capsule.link == link]
    kilograms = [max(0.01, _DENSITY * _volume(capsule)) for capsule in shapes] or [0.01]
    centres = [(capsule.start_m + capsule.end_m) / 2 for capsule in shapes] or [np.zeros(3)]
    size = max([capsule.radius_m + _length(capsule) / 2 for capsule in shapes], default=0.01)
    total = sum(kilograms)
    return Mass(link, total, np.average(centres, axis=0, weights=kilograms), 0.4 * total * size**2 * np.eye(3))


def _length(capsule: Capsule) -> float:
    return float(np.linalg.norm(capsule.end_m - capsule.start_m))


def _volume(capsule: Capsule) -> float:
    return math.pi * capsule.radius_m**2 * (_length(capsule) + 4 / 3 * capsule.radius_m)


def _pen(robot: Robot, settings: SimulationSettings) -> str:
    """The pen at the tip: its slide points back into the arm, so that a pushed pen has a positive position."""
    spring = settings.spring_n_per_m
    slide = (
        ""
        if settings.stiff
        else f'<joint name="pen" type="slide" axis="0 0 -1" range="0 {settings.slide_mm / 1000}" stiffness="{spring}"'
        f' springref="{-settings.preload_mm / 1000}" damping="{_PEN_DAMPING}" solreflimit="0.004 1"'
        ' solimplimit="0.95 0.99 0.0002"/>'
    )
    return (
        f'<body name="pen" {_pose(robot.before[-1])} gravcomp="1">{slide}'
        f'<inertial pos="0 0 -0.03" mass="{PEN_KG}" diaginertia="0.00001 0.00001 0.000001"/>'
        f'<geom name="tip" type="sphere" size="{TIP_RADIUS_M}" pos="0 0 {-TIP_RADIUS_M}" contype="1" conaffinity="1"'
        f" {_CONTACT}/></body>"
    )


def _pose(frame: Floats) -> str:
    return f'pos="{_numbers(frame[:3, 3])}" quat="{_numbers(transforms.to_quaternion(frame[:3, :3]))}"'


def _numbers(values: object) -> str:
    return " ".join(f"{value:.12g}" for value in np.asarray(values, dtype=np.float64).tolist())
