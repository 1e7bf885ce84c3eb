import dataclasses
import json

import numpy as np
import pytest
from hypothesis import given, strategies as st

from limner import storage
from limner.errors import BadInput, CannotDraw, NothingToDraw
from limner.motion.arm.check import check
from limner.motion.arm.collide import deepest, segment_distance
from limner.motion.arm.ik import inverse
from limner.motion.arm.lifted import LiftSettings, lifted_path
from limner.motion.arm.paper import Placement
from limner.motion.arm.place import PlaceSettings, candidates, parse_place, reach_map, unreachable
from limner.motion.arm.plan import ArmSettings, plan_arm
from limner.motion.arm.retime import RetimeSettings, joined, move, retime
from limner.motion.arm.robot import Capsule
from limner.motion.arm.robots import load_robot
from limner.motion.arm.rock import _evenest, rocked
from limner.pipeline import Settings, draw
from limner.targets import joints
from limner.types import Drawing, Page

pytest.importorskip("urdf_parser_py", reason="pip install 'limner[robot]'")
pytest.importorskip("toppra", reason="pip install 'limner[robot]'")

MERGED_MM = 0.02  # points of the path nearer to each other become one
CENTRE = (-0.25, 0.4, -0.3)


def drawing(seed=0, strokes=6):
    rng = np.random.default_rng(seed)
    lines = [
        np.cumsum(rng.normal(0, 4, (rng.integers(1, 12), 2)), axis=0) + rng.uniform(40, 110, 2) for _ in range(strokes)
    ]
    lines.append(lines[-1][::-1] + rng.uniform(-0.5, 0.5, 2))
    return Drawing(tuple(lines), ("face",) * len(lines), np.ones(len(lines)))


def distance_to_polyline(points, line):
    a, b = line[:-1], line[1:]
    along = np.clip(((points[:, None] - a) * (b - a)).sum(-1) / np.maximum(((b - a) ** 2).sum(-1), 1e-12), 0, 1)
    return np.linalg.norm(points[:, None] - a - along[..., None] * (b - a), axis=-1).min(1)


@pytest.fixture(scope="module")
def planned():
    robot, settings = load_robot("dumbo"), LiftSettings()
    path = lifted_path(drawing(), settings)
    placed = Placement.flat(CENTRE, (148, 210))
    q, _ = inverse(robot).follow(placed.tips(path.points_mm))
    return robot, path, placed, retime(robot, path, q, RetimeSettings())


def highest_of_sheets(points_mm, settings):
    """(n,) how high the worst of many sheets lies at places: too high, and tilted about its middle any way."""
    towards = np.linspace(0, 2 * np.pi, 720)
    away = points_mm[:, :2] - (74, 105)
    slopes = np.tan(np.radians(settings.tilt_deg)) * np.stack([np.cos(towards), np.sin(towards)])
    return settings.paper_mm + (away @ slopes).max(1)


@given(st.integers(0, 10_000), st.floats(0.5, 20), st.floats(0, 3), st.floats(0, 3), st.floats(0, 2))
def test_the_pen_goes_straight_up_and_down_and_never_sideways_near_a_sheet_at_its_worst(seed, lift, press, high, tilt):
    settings = LiftSettings(lift_mm=lift, approach_mm=lift, press_mm=press, paper_mm=high, tilt_deg=tilt, clear_mm=0.1)
    path = lifted_path(drawing(seed), settings)
    over = path.points_mm[:, 2] - highest_of_sheets(path.points_mm, settings)
    low = ~path.down[1:] & (np.minimum(over[1:], over[:-1]) < 0)
    sideways = np.linalg.norm(np.diff(path.points_mm[:, :2], axis=0), axis=1)
    assert sideways[low].max(initial=0) < 1e-9
    assert np.isclose(path.points_mm[path.down, 2], -press).all()
    farthest = np.hypot(*(path.points_mm[:, :2] - (74, 105)).T).max()
    assert path.points_mm[:, 2].max() <= settings.highest_mm(farthest) + 0.1 + lift + 1e-9


def test_hops_are_higher_where_the_sheet_may_be_and_where_they_are_long():
    def hop_mm(x, length, **changes):
        lines = (np.array([[x, 100.0], [x, 105]]), np.array([[x + length, 105.0], [x + length, 100]]))
        path = lifted_path(Drawing(lines, ("face",) * 2, np.ones(2)), LiftSettings(**changes))
        drawn = np.flatnonzero(path.down)
        return path.points_mm[drawn[0] : drawn[-1], 2].max()

    assert hop_mm(70, 3) < hop_mm(70, 5) < hop_mm(70, 30) == hop_mm(70, 30, arch=2.0)
    assert hop_mm(20, 3) > hop_mm(70, 3)
    assert hop_mm(20, 3, tilt_deg=0.0) == hop_mm(70, 3, tilt_deg=0.0) == 1.0 + 3 * LiftSettings().arch


@given(st.integers(0, 10_000), st.floats(0, 1))
def test_rounded_strokes_stay_within_the_tolerance_and_keep_their_ends(seed, tolerance):
    made = drawing(seed)
    path = lifted_path(made, LiftSettings(round_mm=tolerance, spacing_mm=0.5))
    for index, line in enumerate(made.lines_mm):
        if len(line) > 1:
            drawn = path.points_mm[path.stroke == index, :2]
            assert distance_to_polyline(drawn, line).max() <= tolerance + MERGED_MM
            assert np.allclose(drawn[-1], line[-1])
            assert distance_to_polyline(line, np.vstack([line[:1], drawn])).max() <= 2 * tolerance + MERGED_MM


def test_an_empty_drawing_has_no_path():
    with pytest.raises(NothingToDraw):
        lifted_path(Drawing((), (), np.zeros(0)), LiftSettings())


def test_limits_hold_at_every_sample_and_between(planned):
    robot, _, _, motion = planned
    check(motion, robot)
    assert (np.abs(motion.qd) <= robot.velocity).all()
    assert (np.abs(motion.qdd) <= robot.acceleration * 1.01).all()
    assert (np.diff(motion.t_s) > 0).all()


def test_the_tip_draws_what_was_asked_for(planned):
    robot, path, placed, motion = planned
    tip = placed.points_mm(robot.forward(motion.q)[:, :3, 3])
    assert distance_to_polyline(tip, path.points_mm).max() < 0.1
    assert tip[motion.down, 2].max() < -1.9


def test_the_pen_keeps_to_its_speed(planned):
    robot, _, placed, motion = planned
    tip = placed.points_mm(robot.forward(motion.q)[:, :3, 3])
    speed = np.linalg.norm(np.diff(tip, axis=0), axis=1) / np.diff(motion.t_s)
    assert speed[motion.down[1:]].max() <= 100 * 1.01


def test_the_same_plan_is_the_same_to_the_last_bit(planned):
    robot, path, placed, motion = planned
    q, _ = inverse(robot).follow(placed.tips(path.points_mm))
    assert retime(robot, path, q, RetimeSettings()) == motion


def test_jerk_is_limited_on_the_same_way_where_asked(planned):
    robot, path, placed, quick = planned
    settings = RetimeSettings(jerk_limited=True)
    q, _ = inverse(robot).follow(placed.tips(path.points_mm))
    drawn = retime(robot, path, q, settings)
    there = move(robot, robot.pose("safe"), drawn.q[0], settings)
    for motion in (drawn, there, joined((there, drawn))):
        check(motion, robot, jerk_limited=True)
        assert np.abs(np.diff(motion.qdd, axis=0)).max() <= 15 * 1.01 * np.diff(motion.t_s).max()
        assert np.abs(motion.qd[[0, -1]]).max() < 1e-6
        slopes = np.diff(motion.q, axis=0) / np.diff(motion.t_s)[:, None]
        assert np.abs(slopes - (motion.qd[1:] + motion.qd[:-1]) / 2).max() < 0.01
    assert np.allclose(there.q[[0, -1]], [robot.pose("safe"), drawn.q[0]])
    assert drawn.t_s[-1] > quick.t_s[-1]
    tip = placed.points_mm(robot.forward(drawn.q)[:, :3, 3])
    assert distance_to_polyline(tip, path.points_mm).max() < 0.1
    with pytest.raises(CannotDraw, match="jerk"):
        check(quick, robot, jerk_limited=True)


def test_a_faster_pen_is_never_slower(planned):
    robot, path, placed, motion = planned
    q, _ = inverse(robot).follow(placed.tips(path.points_mm))
    slow = retime(robot, path, q, RetimeSettings(pen_speed=20.0, travel_speed=50.0))
    assert slow.t_s[-1] > motion.t_s[-1]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda m, r: dataclasses.replace(m, q=m.q + 10), "goes to"),
        (lambda m, r: dataclasses.replace(m, qd=m.qd * 5), "velocity"),
        (lambda m, r: dataclasses.replace(m, qdd=m.qdd * 2), "acceleration"),
        (lambda m, r: dataclasses.replace(m, t_s=m.t_s / 3), "over its limit|jumps"),
        (lambda m, r: dataclasses.replace(m, t_s=m.t_s / 3, qd=m.qd * 0, qdd=m.qdd * 0), "over its limit"),
        (lambda m, r: dataclasses.replace(m, names=("a",) * 7), "for the joints"),
    ],
)
def test_an_altered_motion_is_refused(planned, change, words):
    robot, _, _, motion = planned
    with pytest.raises(CannotDraw, match=words):
        check(change(motion, robot), robot)


def test_one_altered_sample_is_found(planned):
    robot, _, _, motion = planned
    rng = np.random.default_rng(0)
    for sample in rng.integers(1, len(motion.t_s) - 1, 20):
        q = motion.q.copy()
        q[sample, 3] += 0.1
        with pytest.raises(CannotDraw):
            check(dataclasses.replace(motion, q=q), robot)


def test_places_that_are_found_can_be_drawn_at():
    robot = load_robot("dumbo")
    arm = inverse(robot)
    reach = reach_map(robot, arm, PlaceSettings(table_m=-0.4, step_m=0.08))
    places = candidates((148, 210), reach)
    assert places
    corners = np.array([(x, y, z) for x in (5, 74, 143) for y in (5, 105, 205) for z in (-2.0, 5.0)])
    for placed in places:
        assert (arm.margins(placed.tips(corners)) > 0).all()
        assert placed.base_from_paper[2, 3] == pytest.approx(-0.4)


def test_what_cannot_be_reached_is_named():
    robot = load_robot("dumbo")
    placed = parse_place("-0.25,0.6,-0.3", (148, 210), None)
    points = np.column_stack([*np.meshgrid(np.linspace(10, 138, 5), np.linspace(10, 200, 7))]).reshape(-1, 2)
    error = unreachable(inverse(robot), placed, points, (148, 210))
    assert "upper" in str(error)
    assert "shoulder" in str(error) or "joint" in str(error)


@pytest.mark.parametrize("text", ["here", "1,2", "1,2,nan", "1,2,3,4,5", ""])
def test_a_place_that_is_none_is_refused(text):
    with pytest.raises(BadInput, match="no place"):
        parse_place(text, (148, 210), None)


@given(st.integers(0, 2**32 - 1))
def test_the_distance_of_segments_is_that_of_many_points_on_them(seed):
    p0, p1, q0, q1 = np.random.default_rng(seed).normal(size=(4, 3))
    t = np.linspace(0, 1, 200)[:, None]
    sampled = np.linalg.norm((p0 + t * (p1 - p0))[:, None] - (q0 + t * (q1 - q0)), axis=-1).min()
    found = float(segment_distance(p0, p1, q0, q1))
    assert found <= sampled + 1e-12
    assert sampled - found < 0.05


def test_collisions_with_table_and_self_are_found_and_absent_in_the_plan(planned):
    robot, _, placed, motion = planned
    elbow_first = np.array([[0, 1.5, 0, 2.0, 0, 0.5, 0]])
    folded = np.array([[0, 0, 0, 2.09, 0, 1.95, 0]])
    assert deepest(robot, folded).other > 0 or deepest(robot, folded).link >= 0
    table = Placement.flat((0, 0, 0.05), (148, 210)).base_from_paper
    assert deepest(robot, elbow_first, table) is not None
    assert deepest(robot, robot.pose("safe")[None]) is None
    apart = dataclasses.replace(robot, capsules=(Capsule(1, np.zeros(3), np.zeros(3), 0.01),))
    assert deepest(apart, folded) is None
    assert deepest(robot, motion.q[::20], placed.base_from_paper) is None


@pytest.mark.slow
@pytest.mark.parametrize("name", ["dumbo", "ur5e"])
def test_a_drawing_is_planned_from_the_safe_pose_and_back(name):
    robot = load_robot(name)
    planned = plan_arm(drawing(), robot, ArmSettings())
    check(planned.trajectory, robot)
    assert np.allclose(planned.trajectory.q[[0, -1]], robot.pose("safe"))
    assert planned.trajectory.stroke.max() == len(drawing().lines_mm) - 1
    assert planned.report()["margin_deg"] > 0


@pytest.mark.slow
def test_a_pen_that_swings_draws_on_a_larger_sheet():
    sides = np.array([[10, 10], [287, 10], [287, 410], [10, 410], [10, 10.0]])
    a3 = Drawing((sides, sides[[0, 2]], sides[[1, 3]]), ("face",) * 3, np.ones(3), Page(297, 420, 10))
    robot = load_robot("dumbo")
    with pytest.raises(CannotDraw, match="fits nowhere"):
        plan_arm(a3, robot, ArmSettings(place=PlaceSettings(swing_deg=0.0)))
    planned = plan_arm(a3, robot, ArmSettings())
    assert planned.report()["margin_deg"] > 5
    tips = planned.robot.forward(planned.trajectory.q[planned.trajectory.down])
    up = -tips[:, :3, 2] @ planned.placement.base_from_paper[:3, 2]
    assert np.degrees(np.arccos(up)).max() < PlaceSettings().swing_deg + 0.1


def test_a_rocking_hand_leads_the_pen_the_same_way_and_lifts_it_faster(planned):
    robot, path, placed, motion = planned
    q, _ = inverse(robot).follow(placed.tips(path.points_mm))
    moved = rocked(robot, path, q, np.array([0.0, 0, 1]))
    assert np.abs(robot.forward(moved)[:, :3, 3] - robot.forward(q)[:, :3, 3]).max() < 1e-6
    assert np.abs(moved - q)[path.down].max() < 1e-6
    pens = robot.forward(moved)[:, :3, 2]
    assert (-pens[:, 2]).min() > np.cos(np.radians(4))
    quicker = retime(robot, path, moved, RetimeSettings())
    check(quicker, robot)

    def travel_s(motion):
        return np.diff(motion.t_s)[~motion.down[1:]].sum()

    assert travel_s(quicker) < 0.97 * travel_s(motion)


def test_a_hand_that_would_leave_its_limits_does_not_rock(planned):
    robot, path, placed, _ = planned
    q, _ = inverse(robot).follow(placed.tips(path.points_mm))
    tight = dataclasses.replace(robot, lower=q.min(0) - 1e-4, upper=q.max(0) + 1e-4)
    assert rocked(tight, path, q, np.array([0.0, 0, 1])) is q


@given(st.integers(0, 2**32 - 1))
def test_the_joints_share_a_motion_about_as_evenly_as_can_be(seed):
    optimize = pytest.importorskip("scipy.optimize")
    matrix, goal = np.random.default_rng(seed).normal(size=(3, 7)), np.array([0.0, 0, 1])
    found = _evenest(matrix, goal)
    assert np.allclose(matrix @ found, goal)
    # Least bound such that all numbers are within it: a linear programme.
    bounds = np.kron([[1], [-1]], np.eye(7))
    best = optimize.linprog(
        np.r_[np.zeros(7), 1],
        A_ub=np.column_stack([bounds, -np.ones(14)]),
        b_ub=np.zeros(14),
        A_eq=np.column_stack([matrix, np.zeros(3)]),
        b_eq=goal,
        bounds=(None, None),
    )
    assert best.fun * (1 - 1e-6) <= np.abs(found).max() <= 1.1 * best.fun


@pytest.mark.slow
def test_six_hundred_points_take_a_minute_at_most():
    settings = Settings().assign("select.points", "600")
    portrait = draw(pytest.importorskip("skimage").data.astronaut(), settings)
    planned = plan_arm(portrait.drawing, load_robot("dumbo"), settings.arm)
    assert planned.report()["ink_s"] <= 60
    check(planned.trajectory, planned.robot)


def test_a_place_out_of_reach_says_why_and_names_one_within():
    robot = load_robot("dumbo")
    asked = ArmSettings(place=PlaceSettings(at="-0.25,0.75,-0.3"))
    with pytest.raises(CannotDraw, match="nearest place found that can") as error:
        plan_arm(drawing(), robot, asked)
    place = str(error.value).rpartition(": ")[2]
    planned = plan_arm(drawing(), robot, ArmSettings(place=PlaceSettings(at=place)))
    assert planned.report()["strokes"] == len(drawing().lines_mm)


def test_the_trajectory_survives_its_files(planned, tmp_path):
    on_a_sheet = dataclasses.replace(planned[3], sheet_m=planned[2].corners_m((148, 210)), press_mm=3.0)
    for suffix in joints.FORMATS:
        for motion in (planned[3], on_a_sheet):
            joints.save(motion, tmp_path / f"motion{suffix}")
            assert joints.load(tmp_path / f"motion{suffix}") == motion
    with pytest.raises(BadInput, match="cannot be"):
        joints.save(planned[3], tmp_path / "motion.gcode")
    whole = joints.to_csv(on_a_sheet).decode()
    for text, words in (
        ("t_s,q:a\n1,2\n", "expected the columns"),
        (whole.replace("# sheet_m,", "# sheet_m,1,"), "no table"),
        (whole.replace("# sheet_m,", "# sheet_m,1,2,3,"), "four corners"),
        (whole.replace("# sheet_m,", "# sheet_m,nan,2,3,"), "sheet_m"),
        ("# sheet_m\n", "no table"),
        ("", "no table"),
    ):
        (tmp_path / "wrong.csv").write_text(text)
        with pytest.raises(BadInput, match=words):
            joints.load(tmp_path / "wrong.csv")


@pytest.fixture
def run(command, tmp_path):
    (tmp_path / "d.json").write_text(storage.to_json(drawing()))
    return command


def test_the_command_plans_an_arm(run, tmp_path):
    (tmp_path / "probed.csv").write_text("-0.32,0.30,-0.3\n-0.17,0.30,-0.3\n-0.32,0.5,-0.299\n-0.2,0.5,-0.299\n")
    outs = ["-o", "m.csv", "--waypoints", "w.json", "--reach", "r.png"]
    code, out, err = run("plan", "d.json", "--robot", "dumbo", "--calibration", "probed.csv", "--json", *outs)
    assert (code, err) == (0, "")
    report = json.loads(out)
    assert report["probed_used"] == 4
    assert 0.2 < report["tilt_deg"] < 0.4
    assert report["out"] == ["m.csv", "w.json", "r.png"]
    first = json.loads((tmp_path / "w.json").read_text())["waypoints"][0]
    assert set(first) == {"t_s", "position_m", "orientation_wxyz", "down", "stroke"}
    assert (tmp_path / "r.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("arguments", [["--reach", "r.png"], ["--robot", "dumbo", "--fit"], ["--robot", "nobody"]])
def test_options_that_do_not_go_together_are_refused(run, arguments):
    code, out, err = run("plan", "d.json", *arguments)
    assert (code, out) == (2, "")
    assert err.count("\n") == 1


@pytest.mark.parametrize("apart", [0.05, 0.4, 0.99])
def test_to_a_place_close_by_takes_no_longer_than_to_one_farther_away(apart):
    def hop_s(apart):
        lines = (np.array([[60.0, 80], [70, 80]]), np.array([[70 + apart, 80], [80, 90]]))
        plan = plan_arm(Drawing(lines, ("face", "face"), np.ones(2)), load_robot("dumbo"), ArmSettings())
        points, down = plan.path.points_mm, plan.path.down
        drawn = np.flatnonzero(down)
        hop = points[drawn[0] : drawn[-1]][~down[drawn[0] : drawn[-1]]]
        settings = LiftSettings()
        low = hop[hop[:, 2] < settings.highest_mm(float(np.hypot(70 - 74, 80 - 105)))]
        assert np.isin(low[:, 0], (70, 70 + apart)).all()
        motion = plan.trajectory
        first, last = np.flatnonzero(motion.down)[[0, -1]]
        up = first + np.flatnonzero(~motion.down[first:last])
        return motion.t_s[up[-1]] - motion.t_s[up[0]]

    assert hop_s(apart) < 1.1 * hop_s(4.0)


def test_points_a_hair_apart_do_not_make_the_arm_jerk(planned):
    robot, _, placed, _ = planned
    line = np.array([[60, 60], [60, 60.00005], [80, 60], [80, 60.00005], [80, 90.0]])
    hops = (line, line + np.array([0.00005, 31]), line[::-1] + 0.0001)
    made = Drawing(hops, ("face",) * 3, np.ones(3))
    path = lifted_path(made, LiftSettings())
    q, _ = inverse(robot).follow(placed.tips(path.points_mm))
    check(retime(robot, path, q, RetimeSettings()), robot)
