"""What a controller makes of a motion between its points stays within the limits; judged by SciPy's own cubics."""

import dataclasses
import functools

import numpy as np
import pytest
from hypothesis import Phase, given, settings, strategies as st
from scipy.interpolate import CubicHermiteSpline

from limner.errors import CannotDraw
from limner.motion.arm.check import check
from limner.motion.arm.legs import legs
from limner.motion.arm.lift import lift
from limner.motion.arm.lifted import LiftSettings
from limner.motion.arm.place import PlaceSettings
from limner.motion.arm.plan import ArmSettings, plan_arm
from limner.motion.arm.retime import RetimeSettings, move
from limner.motion.arm.robots import load_robot
from limner.motion.arm.spline import accelerations, hermite, peaks, subdivided
from limner.targets.ros_points import controller_points
from limner.types import Drawing, JointTrajectory, Page

pytest.importorskip("urdf_parser_py", reason="pip install 'limner[robot]'")
pytest.importorskip("toppra", reason="pip install 'limner[robot]'")

robots = functools.cache(load_robot)
PLACES = {"dumbo": "-0.25,0.4,-0.3", "lwa4d": "0.45,0,0.1", "ur5e": "0.45,0,0"}


def followed(motion, each=40):
    """Velocities and accelerations (m, dof) of a controller that is given a motion, at many times in every step."""
    points = controller_points(motion)
    t = points.time_ns / 1e9
    # Near both ends of every step, too, where a cubic's acceleration is largest.
    share = np.concatenate([[1e-6], np.linspace(0, 1, each)[1:-1], [1 - 1e-6]])
    dense = (t[:-1, None] + np.diff(t)[:, None] * share).ravel()
    way = CubicHermiteSpline(t, points.q, points.qd)
    return way(dense, 1), way(dense, 2)


def keeps_to_limits(motion, robot):
    velocity, acceleration = followed(motion)
    assert np.abs(velocity / robot.velocity).max() <= 1.01
    assert np.abs(acceleration / robot.acceleration).max() <= 1.01


@st.composite
def drawings(draw):
    rng = np.random.default_rng(draw(st.integers(0, 10**6)))
    lines = [
        np.clip(
            np.cumsum(rng.normal(0, rng.choice([0.3, 2, 8]), (rng.integers(1, 9), 2)), 0) + rng.uniform(8, 52, 2), 5, 55
        )
        for _ in range(draw(st.integers(1, 4)))
    ]
    # Of a dot alone nobody can tell in which plane it lies.
    lines.append(np.array([[8.0, 8.0], [20.0, 9.0], [10.0, 20.0]]))
    return Drawing(tuple(lines), ("face",) * len(lines), np.ones(len(lines)), Page(60, 60, 5))


@settings(max_examples=12, deadline=None, phases=[Phase.generate])
@given(
    drawn=drawings(),
    robot=st.sampled_from(["dumbo", "ur5e"]),
    round_mm=st.sampled_from([0.0, 0.15, 1.0]),
    sample_s=st.sampled_from([0.005, 0.02, 0.04]),
    gentle=st.booleans(),
)
def test_no_plan_leads_a_controller_over_a_limit(drawn, robot, round_mm, sample_s, gentle):
    arm = robots(robot)
    timing = RetimeSettings(sample_s=sample_s, jerk_limited=gentle)
    chosen = ArmSettings(place=PlaceSettings(at=PLACES[robot]), lift=LiftSettings(round_mm=round_mm), retime=timing)
    motion = plan_arm(drawn, arm, chosen).trajectory
    route = legs(motion, arm, timing)
    parts = [motion, route.to_stroke(arm.pose("safe"), 0), *map(route.stroke, range(len(route.ends)))]
    for part in [*parts, route.home(len(route.ends)), lift(arm, motion.q[route.ends[0][0]], timing)]:
        keeps_to_limits(part, arm)


@given(seed=st.integers(0, 10**6), far=st.sampled_from([1e-4, 0.01, 0.3, 2.0]))
def test_a_move_between_any_poses_keeps_to_the_limits(seed, far):
    arm, rng = robots("lwa4d"), np.random.default_rng(seed)
    start = rng.uniform(0.5 * arm.lower, 0.5 * arm.upper)
    motion = move(arm, start, start + far * rng.uniform(-0.5, 0.5, arm.dof), RetimeSettings())
    keeps_to_limits(motion, arm)
    check(motion, arm)


def test_a_motion_that_switches_between_its_samples_is_refused():
    """At every sample it is within the limits; a controller that joins these by cubics is half over them."""
    arm = robots("ur5e")
    rate, half = float(arm.acceleration[0]), 0.03
    t = np.arange(0, 2 * half + 1e-9, 0.02)
    early = t < half
    q, qd = np.zeros((len(t), arm.dof)), np.zeros((len(t), arm.dof))
    q[:, 0] = np.where(early, rate * t**2 / 2, rate * half**2 - rate * (2 * half - t) ** 2 / 2)
    qd[:, 0] = rate * np.minimum(t, 2 * half - t)
    motion = JointTrajectory(arm.joints, t, q, qd, 0 * q, np.zeros(len(t), bool), np.full(len(t), -1))
    assert np.abs(followed(motion)[1]).max() / rate == pytest.approx(1.5, abs=0.01)
    with pytest.raises(CannotDraw, match=r"an acceleration between samples of .*, 50 % over its limit"):
        check(motion, arm)
    fine = np.sort(np.append(t, half))
    parted = {"q": q, "qd": qd}
    exact = (rate * half**2 / 2, rate * half)
    for (name, values), value in zip(parted.items(), exact, strict=True):
        parted[name] = np.insert(values, int(early.sum()), np.eye(arm.dof)[0] * value, axis=0)
    none = np.zeros(len(fine), bool), np.full(len(fine), -1)
    check(JointTrajectory(arm.joints, fine, parted["q"], parted["qd"], 0 * parted["q"], *none), arm)


def random_motion(seed, n=12, dof=3):
    rng = np.random.default_rng(seed)
    t = np.cumsum(rng.uniform(0.001, 0.1, n))
    q, qd = rng.normal(size=(2, n, dof))
    return JointTrajectory(tuple("abc"), t, q, qd, 0 * q, np.zeros(n, bool), np.full(n, -1))


@given(seed=st.integers(0, 10**6))
def test_cubics_and_their_peaks_are_those_of_scipy(seed):
    motion = random_motion(seed)
    way = CubicHermiteSpline(motion.t_s, motion.q, motion.qd)
    t = np.linspace(motion.t_s[0], motion.t_s[-1], 500)[1:-1]
    for order, values in enumerate(hermite(motion, t)):
        assert np.allclose(values, way(t, order), rtol=1e-6, atol=1e-6 * np.abs(way(t, order)).max())
    dense = motion.t_s[:-1, None] + np.diff(motion.t_s)[:, None] * np.linspace(1e-9, 1 - 1e-9, 2001)
    for order, largest in enumerate(peaks(motion.t_s, motion.q, motion.qd), 1):
        seen = np.abs(way(dense, order)).max(1)
        assert (largest >= seen * (1 - 1e-9)).all()
        assert np.allclose(largest, seen, rtol=1e-5)


@given(seed=st.integers(0, 10**6))
def test_accelerations_are_those_just_after_each_sample_and_before_the_last(seed):
    motion = random_motion(seed)
    way, step = CubicHermiteSpline(motion.t_s, motion.q, motion.qd), np.diff(motion.t_s)
    beside = np.append(motion.t_s[:-1] + 1e-9 * step, motion.t_s[-1] - 1e-9 * step[-1])
    found = accelerations(motion.t_s, motion.q, motion.qd)
    assert np.allclose(found, way(beside, 2), rtol=1e-5, atol=1e-5 * np.abs(found).max())


def test_before_and_after_a_motion_the_arm_stands():
    motion = random_motion(0)
    q = hermite(motion, motion.t_s[[0, -1]] + [-1.0, 1.0]).q
    assert np.allclose(q, motion.q[[0, -1]])


def test_a_jump_in_no_time_has_no_bound_and_a_sample_said_twice_is_none():
    motion = random_motion(1)
    k = [0, 1, 2, 2, *range(3, 12)]
    twice = dataclasses.replace(
        motion, **{name: getattr(motion, name)[k] for name in ("t_s", "q", "qd", "qdd", "down", "stroke")}
    )
    velocity, acceleration = peaks(twice.t_s, twice.q, twice.qd)
    assert not velocity[2].any()
    assert not acceleration[2].any()
    q = twice.q.copy()
    q[2, 1] += 1e-9
    assert np.isinf(peaks(twice.t_s, q, twice.qd)[0][2, 1])


@given(times=st.lists(st.floats(0.001, 1), min_size=1, max_size=6), longest=st.floats(0.01, 0.5))
def test_subdivided_times_keep_those_given_and_are_near_each_other(times, longest):
    given_ = np.concatenate([[0.0], np.cumsum(times)])
    found = subdivided(given_, longest)
    assert np.isin(given_, found).all()
    assert (np.diff(found) > 0).all()
    assert np.diff(found).max() <= longest * (1 + 1e-6)
