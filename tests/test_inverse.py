import numpy as np
import pytest

from limner import transforms
from limner.motion.arm.elbow import ElbowSettings
from limner.motion.arm.ik import InverseSettings, inverse
from limner.motion.arm.numeric_ik import NumericSettings, PinocchioArm
from limner.motion.arm.paper import Placement
from limner.motion.arm.robots import load_robot
from limner.motion.arm.srs import SphericalArm

pytest.importorskip("urdf_parser_py", reason="pip install 'limner[robot]'")
pinocchio = pytest.importorskip("pinocchio", reason="pip install 'limner[robot]'")


def sheet_path(n, size=(148.0, 210.0)):
    """A winding path over a sheet [mm]."""
    s = np.linspace(0, 1, n)
    x = size[0] / 2 * (1 + 0.85 * np.sin(2 * np.pi * 5 * s))
    return np.stack([x, size[1] / 2 * (1 + 0.85 * np.cos(2 * np.pi * 2 * s)), 5 * (np.sin(40 * s) > 0.9)], axis=1)


@pytest.mark.parametrize("name", ["dumbo", "lwa4d"])
def test_every_branch_of_the_closed_form_reaches_the_pose_as_pinocchio_sees_it(name):
    robot = load_robot(name)
    rng = np.random.default_rng(1)
    tips = robot.forward(rng.uniform(robot.lower, robot.upper, (10_000, 7)))
    q, reached = SphericalArm.of(robot).solve(tips, rng.uniform(-3, 3, 10_000))
    assert reached.all()
    assert np.abs(robot.forward(q) - tips[:, None]).max() < 1e-9
    arm = PinocchioArm(robot, NumericSettings())
    for solutions, tip in zip(q[:200], tips[:200], strict=True):
        for joints in solutions:
            pinocchio.forwardKinematics(arm.model, arm.data, joints)
            assert np.abs((arm.data.oMi[arm.last] * arm.tip).homogeneous - tip).max() < 1e-9


def test_one_elbow_angle_brings_back_the_joints_that_made_the_pose():
    robot = load_robot("dumbo")
    joints = np.random.default_rng(2).uniform(-1, 1, (20, 7))
    angles = np.linspace(-np.pi, np.pi, 2000)
    q, _ = SphericalArm.of(robot).solve(robot.forward(joints)[:, None], angles)
    nearest = np.abs(q - joints[:, None, None]).max(-1).min((1, 2))
    assert (nearest < 0.02).all()


def test_what_is_out_of_reach_is_told():
    arm = SphericalArm.of(load_robot("dumbo"))
    far = transforms.transform(translation=(0, 3, 0))
    assert not arm.solve(far, 0.0)[1]
    assert "from the shoulder" in inverse(load_robot("dumbo")).why(far)


def test_other_arms_have_no_closed_form():
    assert SphericalArm.of(load_robot("ur5e")) is None


@pytest.mark.parametrize(
    ("name", "centre"), [("dumbo", (-0.25, 0.4, -0.3)), ("lwa4d", (0.5, 0.0, 0.05)), ("ur5e", (0.4, -0.1, 0.0))]
)
def test_a_path_is_followed_exactly_within_limits_and_without_jumps(name, centre):
    robot = load_robot(name)
    tips = Placement.flat(centre, (148, 210), spin_rad=0.5).tips(sheet_path(400))
    settings = InverseSettings(numeric=NumericSettings(starts=6))
    q, reached = inverse(robot, settings).follow(tips)
    assert reached.all()
    assert np.abs(robot.forward(q) - tips).max() < 1e-6
    assert (robot.margin(q) >= 0).all()
    step = np.linalg.norm(np.diff(tips[:, :3, 3], axis=0), axis=1)
    assert (np.abs(np.diff(q, axis=0)).max(1) <= 25 * step + 1e-3).all()


def test_the_elbow_moves_away_from_a_limit_where_it_can():
    robot = load_robot("dumbo")
    tips = Placement.flat((-0.3, 0.37, -0.25), (148, 210)).tips(sheet_path(400))
    careful, _ = inverse(robot, InverseSettings(elbow=ElbowSettings(margin_deg=20.0))).follow(tips)
    careless, _ = inverse(robot, InverseSettings(elbow=ElbowSettings(margin_weight=0.0, singular_weight=0.0))).follow(
        tips
    )
    assert robot.margin(careful).min() >= robot.margin(careless).min()


def test_a_path_that_leaves_the_reach_is_not_followed():
    robot = load_robot("dumbo")
    tips = Placement.flat((-0.25, 0.4, -0.3), (500, 700)).tips(sheet_path(400, (500.0, 700.0)))
    q, reached = inverse(robot).follow(tips)
    assert q is None
    assert 0 < reached.mean() < 1
