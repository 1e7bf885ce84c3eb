import numpy as np
import pytest

from limner import transforms
from limner.errors import BadInput
from limner.motion.arm.robots import ROBOTS, load_robot
from limner.motion.arm.urdf import ChainRequest, parse_urdf

pytest.importorskip("urdf_parser_py", reason="pip install 'limner[robot]'")

Y, Z = np.eye(3)[1], np.eye(3)[2]


def turn(axis, angle):
    return transforms.transform(transforms.rotation(axis, angle))


def slide(x=0.0, y=0.0, z=0.0):
    return transforms.transform(translation=(x, y, z))


def positions(robot, n, seed=0):
    return np.random.default_rng(seed).uniform(robot.lower, robot.upper, (n, robot.dof))


def test_dumbo_is_the_published_chain():
    robot = load_robot("dumbo")
    q = positions(robot, 200)
    r = [q[:, i] for i in range(7)]
    mount = transforms.transform(transforms.from_rpy((np.pi / 2, 0, -np.pi / 2)), (-0.268, 0, 0))
    upper = mount @ turn(Z, r[0]) @ turn(Y, r[1]) @ slide(z=0.318)
    fore = turn(Z, r[2]) @ turn(Y, r[3]) @ slide(z=0.2765)
    hand = turn(Z, r[4]) @ turn(Y, r[5]) @ turn(Z, r[6]) @ slide(z=0.414848 + 0.1)
    assert np.allclose(robot.forward(q), upper @ fore @ hand, atol=1e-12)


def test_ur5e_is_the_published_denavit_hartenberg_chain():
    robot = load_robot("ur5e")
    q = positions(robot, 200)
    rows = ((0, np.pi / 2, 0.1625), (-0.425, 0, 0), (-0.3922, 0, 0), (0, np.pi / 2, 0.1333), (0, -np.pi / 2, 0.0997))
    expected = np.eye(4)
    for i, (a, alpha, d) in enumerate((*rows, (0, 0, 0.0996))):
        expected = expected @ turn(Z, q[:, i]) @ slide(z=d) @ slide(x=a) @ turn((1.0, 0, 0), alpha)
    assert np.allclose(robot.forward(q), expected @ slide(z=0.15), atol=1e-12)


@pytest.mark.parametrize("name", ROBOTS)
def test_the_jacobian_is_what_small_motions_do(name):
    robot = load_robot(name)
    q = positions(robot, 20)
    jacobian, step = robot.jacobian(q), 1e-6
    for i, one in enumerate(np.eye(robot.dof)):
        ahead, back = robot.forward(q + step * one), robot.forward(q - step * one)
        linear = (ahead - back)[:, :3, 3] / (2 * step)
        spin = (ahead - back)[:, :3, :3] / (2 * step) @ np.swapaxes(robot.forward(q)[:, :3, :3], 1, 2)
        angular = np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]], axis=1)
        assert np.allclose(jacobian[:, :3, i], linear, atol=1e-8)
        assert np.allclose(jacobian[:, 3:, i], angular, atol=1e-8)


@pytest.mark.parametrize("name", ROBOTS)
def test_robots_that_come_along_have_a_safe_pose_within_their_limits(name):
    robot = load_robot(name)
    assert (robot.margin(robot.pose("safe")) > 0).all()
    assert robot.capsules


ARM = """<robot name="a"><link name="base"/><link name="l1"/><link name="l2"/><link name="tip"/>
<joint name="j1" type="revolute"><parent link="base"/><child link="l1"/><axis xyz="0 0 2"/>
<limit lower="-1" upper="1" velocity="2" effort="1"/></joint>
<joint name="j2" type="{kind}"><parent link="l1"/><child link="l2"/><origin xyz="1 0 0"/><axis xyz="1 0 0"/>
{limit}{extra}</joint>
<joint name="j3" type="fixed"><parent link="l2"/><child link="{child}"/><origin xyz="0.5 0 0"/></joint></robot>"""
LIMIT = '<limit lower="-0.1" upper="0.2" velocity="1" effort="1"/>'


def urdf(kind="prismatic", limit=LIMIT, extra="", child="tip"):
    return ARM.format(kind=kind, limit=limit, extra=extra, child=child).encode()


def test_a_sliding_joint_slides_and_a_frozen_one_does_not_move():
    robot = parse_urdf(urdf(), "a.urdf")
    assert np.allclose(robot.forward((np.pi / 2, 0.2))[:3, 3], (0, 1.7, 0))
    held = parse_urdf(urdf(), "a.urdf", ChainRequest(frozen={"j2": 0.1}))
    assert held.joints == ("j1",)
    assert np.allclose(held.forward((0.0,))[:3, 3], (1.6, 0, 0))


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"", "no URDF"),
        (b"<svg/>", "expected <robot>"),
        (b"<robot name='a'>" + b"<a>" * 60 + b"</a>" * 60 + b"</robot>", "nested deeper"),
        (b"<!DOCTYPE r [<!ENTITY a 'b'>]><robot name='a'>&a;</robot>", "entities"),
        (b"<robot name='a'><link nam='b'/></robot>", "no URDF"),
        (b"<robot name='a'/>", "links without a parent"),
        (urdf(limit=""), "no limits"),
        (urdf(limit=LIMIT.replace("0.2", "-0.3")), "expected lower < upper"),
        (urdf(limit=LIMIT.replace('velocity="1"', 'velocity="0"')), "velocity limit of 0"),
        (urdf(extra='<mimic joint="j1"/>'), "mimics j1"),
        (urdf(child="nowhere"), "does not exist"),
        (urdf().replace(b'xyz="0 0 2"', b'xyz="0 0 0"'), "expected a direction"),
    ],
)
def test_a_urdf_that_cannot_be_used_is_one_line(data, words):
    with pytest.raises(BadInput, match=words) as error:
        parse_urdf(data, "a.urdf")
    assert "a.urdf" in str(error.value) or "robot a" in str(error.value)
    assert "\n" not in str(error.value)


def test_an_unknown_robot_names_those_there_are(tmp_path):
    with pytest.raises(BadInput, match="dumbo, lwa4d, ur5e"):
        load_robot("r2d2")
    with pytest.raises(BadInput, match=r"nowhere\.urdf"):
        load_robot(tmp_path / "nowhere.urdf")


def test_a_robot_of_ones_own_may_bring_a_toml(tmp_path):
    (tmp_path / "mine.urdf").write_bytes(urdf())
    (tmp_path / "mine.toml").write_text("acceleration = [3.0]\n[poses]\nsafe = [0.0, 0.1]\n")
    robot = load_robot(tmp_path / "mine.urdf")
    assert robot.name == "mine"
    assert robot.acceleration.tolist() == [3.0, 3.0]
    assert robot.pose("safe").tolist() == [0.0, 0.1]
    (tmp_path / "mine.toml").write_text("accelleration = [3.0]\n")
    with pytest.raises(BadInput, match="accelleration does not exist"):
        load_robot(tmp_path / "mine.urdf")
