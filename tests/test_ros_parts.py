"""What ``limner ros`` does between messages: the desk, the arm, lifting, ink, a simulated arm; no ROS is needed."""

from __future__ import annotations

import subprocess
import sys
import threading
import time
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, strategies as st

from limner.errors import BadInput, CannotDraw, DeviceFailed
from limner.motion.arm.check import check
from limner.motion.arm.legs import legs
from limner.motion.arm.lift import lift
from limner.motion.arm.plan import plan_arm
from limner.motion.arm.retime import RetimeSettings, move
from limner.motion.arm.robots import ROBOTS, load_robot
from limner.pipeline import Settings
from limner.ros import master, messages, parameters, teller
from limner.ros.action import definitions
from limner.ros.arm import RosArm
from limner.ros.desk import Desk
from limner.ros.feed import JointFeed
from limner.ros.ink import InkTrail
from limner.ros.simulated import SimulatedArm
from limner.types import Drawing, Page, Pen, Photo
from processes import until
from ros_world import World, need_ros

DUMBO = load_robot("dumbo")
PAGE = Page(148, 210, 10)
LINES = (np.array([[50.0, 50], [60, 50], [60, 60]]), np.array([[50.0, 80], [60, 80]]))
DRAWING = Drawing(LINES, ("face", "face"), np.ones(2), PAGE)
STEP_S = 0.02


@pytest.fixture(scope="module")
def plan():
    return plan_arm(DRAWING, DUMBO, Settings().arm)


@pytest.fixture(scope="module")
def route(plan):
    return legs(plan.trajectory, DUMBO, Settings().arm.retime)


def touching(plan):
    """Joint positions amid a stroke."""
    return plan.trajectory.q[np.flatnonzero(plan.trajectory.down)[5]]


# Lifting.


def test_a_lift_is_within_limits_straight_and_ends_high(plan):
    motion = lift(DUMBO, touching(plan), RetimeSettings())
    check(motion, DUMBO)
    assert np.abs(motion.qd[[0, -1]]).max() < 1e-9
    tips = plan.placement.points_mm(DUMBO.forward(motion.q)[:, :3, 3])
    height = tips[:, 2] - tips[0, 2]
    assert height[-1] > 55
    assert (np.diff(height) > -0.1).all()
    # Where it may still touch the paper it leaves no trail.
    near = height < 4
    assert np.hypot(*(tips[near, :2] - tips[0, :2]).T).max() < 0.6


@pytest.mark.parametrize("name", ROBOTS)
def test_every_robot_can_lift_from_its_safe_pose(name):
    robot = load_robot(name)
    motion = lift(robot, robot.pose("safe"), RetimeSettings())
    tips = robot.forward(motion.q)[[0, -1]]
    assert np.linalg.norm(tips[1, :3, 3] - tips[0, :3, 3]) > 0.02


def test_an_arm_that_is_stretched_out_says_that_it_cannot_lift():
    with pytest.raises(CannotDraw, match="raise it by hand"):
        lift(DUMBO, DUMBO.upper - 1e-9, RetimeSettings())


# A simulated arm.


def test_it_goes_exactly_along_its_motion(route):
    arm, motion = SimulatedArm(DUMBO, route.stroke(0).q[0]), route.stroke(0)
    assert arm.refuse(motion) == ""
    arm.follow(motion)
    for k in range(1, 10_000):
        ended = arm.step(STEP_S)
        assert np.allclose(arm.q, motion.at(k * STEP_S))
        if ended:
            break
    assert np.allclose(arm.q, motion.q[-1])
    assert not arm.moving


@pytest.mark.parametrize("after", [0.0, 0.3])
def test_halting_stays_on_the_way_and_within_limits(after):
    q = DUMBO.pose("safe")
    arm, motion = SimulatedArm(DUMBO, q), move(DUMBO, q, q + 0.5, RetimeSettings())
    arm.follow(motion)
    for _ in range(round(after / STEP_S)):
        arm.step(STEP_S)
    arm.halt()
    assert arm.halting
    while not arm.step(STEP_S):
        assert (arm.qd <= DUMBO.velocity).all()
    share = (arm.q - q) / 0.5
    assert np.ptp(share) < 1e-9, "on the straight way"
    assert 0 <= share[0] < 0.99


def test_it_refuses_what_begins_elsewhere_or_is_too_fast():
    q = DUMBO.pose("safe")
    arm, motion = SimulatedArm(DUMBO, q), move(DUMBO, q, q + 0.2, RetimeSettings())
    assert "begins" in SimulatedArm(DUMBO, q + 0.1).refuse(motion)
    assert arm.refuse(motion) == ""
    fast = type(motion)(
        motion.names, motion.t_s / 3, motion.q, 3 * motion.qd, 9 * motion.qdd, motion.down, motion.stroke
    )
    assert "over its limit" in arm.refuse(fast)


# Ink.


def test_ink_of_the_planned_motion_is_the_drawing(plan):
    trail = InkTrail(DUMBO, plan.placement)
    trail.take(list(plan.trajectory.q))
    assert len(trail.lines_mm) == 2
    for line, drawn in zip(LINES, trail.lines_mm, strict=True):
        for end in (0, -1):
            assert np.hypot(*(line[end] - drawn[end])) < 0.3


@given(st.lists(st.integers(1, 400), max_size=5))
def test_ink_does_not_depend_on_how_reports_are_bundled(cuts):
    q = PLAN.trajectory.q
    whole, parts = (InkTrail(DUMBO, PLAN.placement) for _ in range(2))
    whole.take(list(q))
    pieces = [parts.take(list(piece)) for piece in np.split(q, sorted(cuts))]
    assert sum(map(len, pieces)) == sum(map(len, whole.lines_mm))
    assert all(np.array_equal(a, b) for a, b in zip(whole.lines_mm, parts.lines_mm, strict=True))


PLAN = plan_arm(Drawing(LINES[1:], ("face",), np.ones(1), PAGE), DUMBO, Settings().arm)

# Joints.


def test_joints_come_in_any_order_with_others_among_them():
    feed = JointFeed(("a", "b"))
    feed.take(("gripper", "b", "a"), (9.0, 2.0, 1.0))
    assert feed.q().tolist() == [1.0, 2.0]
    assert [q.tolist() for q in feed.drain()] == [[1.0, 2.0]]
    assert feed.drain() == []


def test_joints_that_are_silent_are_said_to_be(monkeypatch):
    now = [5.0]
    monkeypatch.setattr("limner.ros.feed.time", SimpleNamespace(monotonic=lambda: now[0]))
    feed = JointFeed(("a",), silence_s=0.05)
    with pytest.raises(DeviceFailed, match="no joint_states have been heard"):
        feed.q()
    feed.take(("a",), (1.0,))
    assert feed.q().tolist() == [1.0]
    now[0] += 0.1
    with pytest.raises(DeviceFailed, match=r"no joint_states for 0\.1 s"):
        feed.q()


# The desk, with an arm in this process.


class Local:
    """A ``Link`` to a simulated arm whose time goes as fast as it can.

    Attributes:
        each: called after each step, before it is reported.
        alive: whether it moves and reports.
        muted: whether what it does is not reported.
    """

    name = "local"

    def __init__(self, feed):
        self.arm, self.feed, self.refused, self.sent = SimulatedArm(DUMBO, DUMBO.pose("safe")), feed, "", []
        self.lock, self.ended_by = threading.Lock(), threading.Event()
        self.thread = threading.Thread(target=self.run, daemon=True)
        self.alive, self.muted, self.each = True, False, lambda: None
        self.thread.start()

    def run(self):
        while not self.ended_by.wait(0.001):
            with self.lock:
                if self.alive:
                    self.arm.step(STEP_S)
                    self.each()
                    if not self.muted:
                        self.feed.take(DUMBO.joints, self.arm.q.tolist())

    def open(self):
        pass

    def send(self, motion):
        with self.lock:
            self.sent.append(motion)
            self.refused = self.arm.refuse(motion)
            if not self.refused:
                self.arm.follow(motion)

    def ended(self):
        with self.lock:
            return self.refused or (None if self.arm.moving or not self.alive else "")

    def cancel(self):
        with self.lock:
            if self.alive:
                self.arm.halt()


class Ear:
    def __init__(self):
        self.said, self.shares, self.drawings, self.plans = [], [], [], []

    def drawn(self, drawing, portrait):
        self.drawings.append(drawing)

    def planned(self, plan):
        self.plans.append(plan)

    def begun(self):
        self.shares.clear()

    def progress(self, share):
        self.shares.append(share)

    def status(self, text):
        self.said.append(text)


@pytest.fixture
def bench(tmp_path):
    feed, ear = JointFeed(DUMBO.joints, silence_s=3.0), Ear()
    link = Local(feed)
    desk = Desk(lambda route: RosArm(link, feed, route), tmp_path / "journal", ear)

    def height():
        """Of the pen's tip over the sheet [mm]."""
        return ear.plans[-1].placement.points_mm(DUMBO.forward(link.arm.q)[:3, 3])[2]

    yield SimpleNamespace(desk=desk, ear=ear, link=link, feed=feed, height=height)
    if desk.busy:
        desk.stop()
    link.ended_by.set()
    link.thread.join()


def test_wishes_that_cannot_be_granted_say_why(bench):
    desk = bench.desk
    for wish, reason in (
        (desk.start, "nothing is planned"),
        (desk.pause, "does not draw"),
        (desk.resume, "nothing is planned"),
        (desk.stop, "does not draw"),
        (lambda: desk.sketch(Settings()), "there is no photo yet"),
        (lambda: desk.plan(Settings(), DUMBO), "there is no drawing yet"),
        (lambda: desk.probe(np.array([0, np.nan, 0])), "NaN"),
    ):
        with pytest.raises(BadInput, match=reason):
            wish()


def test_it_draws_and_tells_how_far_it_is(bench):
    bench.desk.take(DRAWING)
    bench.desk.plan(Settings(), DUMBO)
    bench.desk.start()
    with pytest.raises(BadInput, match="the arm is drawing"):
        bench.desk.start()
    until(lambda: not bench.desk.busy)
    assert bench.ear.said[-1] == "drawn: 2 of 2 strokes"
    assert bench.ear.shares == sorted(bench.ear.shares)
    assert bench.ear.shares[-1] == pytest.approx(1)
    for motion in bench.link.sent:
        check(motion, DUMBO)
    with pytest.raises(BadInput, match="nothing was left unfinished"):
        bench.desk.resume()


def test_the_sheet_stays_where_it_lies(bench):
    bench.desk.warm(Settings(), DUMBO)
    for line in (LINES[0], LINES[1] + [20.0, 40.0]):
        bench.desk.take(Drawing((line,), ("face",), np.ones(1), PAGE))
        bench.desk.plan(Settings(), DUMBO)
    first, second = (plan.placement.base_from_paper for plan in bench.ear.plans)
    assert np.array_equal(first, second)


def test_what_dies_is_not_moved_and_is_raised_first_when_it_is_back(bench):
    bench.desk.take(DRAWING)
    bench.desk.plan(Settings(), DUMBO)
    link = bench.link

    def die():
        link.alive = link.alive and bench.height() >= 0

    link.each = die
    bench.desk.start()
    until(lambda: not bench.desk.busy)
    assert "pen state unknown: lift it by hand" in bench.ear.said[-1]
    sent = len(link.sent)
    assert bench.height() < 0
    with link.lock:
        link.alive, link.arm, link.each = True, SimulatedArm(DUMBO, link.arm.q), lambda: None
    heard = bench.feed.reports
    until(lambda: bench.feed.reports > heard)
    bench.desk.resume()
    until(lambda: not bench.desk.busy)
    assert bench.ear.said[-1] == "drawn: 2 of 2 strokes"
    up = plan_heights(bench.ear.plans[-1], bench.link.sent[sent])
    assert up[0] < 0
    assert up[-1] > 50


def test_silence_is_not_taken_for_rest(bench):
    """A busy controller says nothing for a moment when it is told to stop, and goes on meanwhile."""
    bench.desk.take(DRAWING)
    bench.desk.plan(Settings(), DUMBO)
    link, halt, late = bench.link, bench.link.cancel, []

    def stop():
        if bench.height() < 0:
            bench.desk._control.stop = True

    def cancel():
        with link.lock:
            link.muted = True
        late.append(threading.Timer(0.5, heard))
        late[-1].start()

    def heard():
        halt()
        link.muted = False

    link.each, link.cancel = stop, cancel
    bench.desk.start()
    until(lambda: not bench.desk.busy)
    assert bench.ear.said[-1].startswith("stopped with the pen up: ")
    assert bench.height() > 50
    for timer in late:
        timer.join()


def test_who_hears_that_it_is_drawn_can_begin_anew_at_once(bench):
    bench.desk.take(DRAWING)
    bench.desk.plan(Settings(), DUMBO)
    status, again = bench.ear.status, []

    def hear(text):
        status(text)
        if text.startswith("drawn: 2 of") and not again:
            again.append(threading.Thread(target=lambda: again.append(bench.desk.start())))
            again[0].start()
            time.sleep(0.1)

    bench.ear.status = hear
    bench.desk.start()
    until(lambda: len(again) == 2)
    assert again[1] == "drawing 2 strokes"
    until(lambda: not bench.desk.busy)
    assert bench.ear.said.count("drawn: 2 of 2 strokes") == 2


def test_ink_of_the_last_moment_is_shown_though_the_drawing_has_ended(plan, monkeypatch):
    shown, now = [], SimpleNamespace(now=lambda: 0)
    monkeypatch.setattr(teller, "ros", lambda: SimpleNamespace(rospy=SimpleNamespace(Time=now)))
    monkeypatch.setattr(teller.pictures, "segments", list)
    ours = teller.Teller.__new__(teller.Teller)
    ours._lock, ours._feed, ours._inking = threading.Lock(), JointFeed(DUMBO.joints), False
    ours._trail, ours._plan = InkTrail(DUMBO, plan.placement), None
    ours._ink = SimpleNamespace(points=[], header=SimpleNamespace(stamp=0))
    ours._publish = {"ink": SimpleNamespace(publish=lambda ink: shown.append(len(ink.points)))}
    half = len(plan.trajectory.q) // 2

    def report(rows):
        for q in rows:
            ours._feed.take(DUMBO.joints, q.tolist())

    report(plan.trajectory.q[:half])
    ours.tick(lambda: True)
    report(plan.trajectory.q[half:])
    ours.tick(lambda: False)
    assert len(shown) == 2
    assert shown[1] == sum(map(len, ours._trail.lines_mm))
    report(plan.trajectory.q)
    ours.tick(lambda: False)
    assert len(shown) == 2, "whoever moves the arm afterwards does not draw"


def plan_heights(plan, motion):
    return plan.placement.points_mm(DUMBO.forward(motion.q)[:, :3, 3])[:, 2]


# Messages and parameters.


def image(**fields):
    given = {"encoding": "rgb8", "width": 2, "height": 1, "step": 6, "data": bytes(range(6))} | fields
    return SimpleNamespace(**given)


def test_images_in_three_encodings():
    assert messages.to_photo(image()).rgb.tolist() == [[[0, 1, 2], [3, 4, 5]]]
    assert messages.to_photo(image(encoding="bgr8")).rgb.tolist() == [[[2, 1, 0], [5, 4, 3]]]
    padded = image(encoding="mono8", step=4, data=bytes([7, 8, 0, 0]))
    assert messages.to_photo(padded).rgb.tolist() == [[[7] * 3, [8] * 3]]


@given(st.integers(1, 5), st.integers(1, 5), st.randoms())
def test_a_photo_comes_back_from_its_message(width, height, random):
    photo = Photo(
        np.array([random.randrange(256) for _ in range(3 * width * height)], np.uint8).reshape(height, width, 3)
    )
    assert messages.to_photo(messages.fill_image(SimpleNamespace(), photo)) == photo


@pytest.mark.parametrize(
    ("fields", "reason"),
    [
        ({"encoding": "yuv422"}, "choose rgb8"),
        ({"width": 0}, "0 x 1 pixels"),
        ({"step": 5}, "rows of"),
        ({"data": b""}, "0 bytes"),
    ],
)
def test_images_that_are_none(fields, reason):
    with pytest.raises(BadInput, match=reason):
        messages.to_photo(image(**fields))


def test_parameters_become_settings():
    found = parameters.settings(
        {"style": "canny", "page": "a4", "points": 200, "settings": {"gabor": {"orientations": 4}}}
    )
    assert (found.style, found.page.size, found.select.points, found.gabor.orientations) == ("canny", "a4", 200, 4)
    for wrong, reason in (
        ({"stile": "canny"}, "~stile does not exist"),
        ({"style": "x"}, "style"),
        ({"points": -1}, "points"),
    ):
        with pytest.raises(BadInput, match=reason):
            parameters.settings(wrong)
    for wrong in ({"target": "x"}, {"tf": "x"}, {"robot": "x"}):
        with pytest.raises(BadInput, match="choose"):
            parameters.fixed(wrong)
    assert parameters.fixed({"silence": 5})[0].silence_s == 5
    for wrong in (0, -1, 61, "5", True, float("nan")):
        with pytest.raises(BadInput, match=r"~silence = .* expected 0\.1 to 60 seconds"):
            parameters.fixed({"silence": wrong})


@pytest.mark.parametrize("place", [(0.05, 1.8e305), (50, 50), (-0.001, 0.05), (0.05, 0.2101)])
def test_a_path_that_leaves_the_page(place):
    path = SimpleNamespace(header=SimpleNamespace(frame_id="paper"), poses=[pose(*place)])
    with pytest.raises(BadInput, match=r"leaves the page of 0\.148 x 0\.21 m"):
        messages.to_stroke(path, PAGE)


def test_a_path_to_the_corner_of_the_page():
    path = SimpleNamespace(header=SimpleNamespace(frame_id="paper"), poses=[pose(0, 0), pose(0.148, 0.21)])
    assert np.allclose(messages.to_stroke(path, PAGE), [[0, 0], [148, 210]])


def pose(x, y):
    return SimpleNamespace(pose=SimpleNamespace(position=SimpleNamespace(x=x, y=y, z=0.0)))


class Master:
    """Forgets everybody from time to time, and breaks off; a node is known from its first topic on."""

    def __init__(self):
        self.topics, self.breaks = [], 0

    def lookupNode(self, name, other):  # noqa: N802  (the master's own names)
        return (1, "", "http://node") if self.topics else (-1, "", "")

    def registerPublisher(self, name, topic, kind, uri):  # noqa: N802  (likewise)
        if self.topics and self.breaks:
            self.breaks -= 1
            raise ConnectionResetError("the master is restarted once more")
        self.topics.append(topic)
        return 1, "", []


def test_a_node_is_registered_whole_after_the_master_broke_off(monkeypatch):
    broken, told = Master(), []
    broken.breaks = 2
    rounds = iter(range(8))
    rospy = SimpleNamespace(
        is_shutdown=lambda: next(rounds, None) is None,
        get_name=lambda: "limner",
        get_node_uri=lambda: "http://node",
        topics=SimpleNamespace(
            get_topic_manager=lambda: SimpleNamespace(
                get_publications=lambda: [("ink", ""), ("status", ""), ("path", "")], get_subscriptions=list
            )
        ),
        impl=SimpleNamespace(
            registration=SimpleNamespace(get_service_manager=lambda: SimpleNamespace(get_services=list))
        ),
    )
    monkeypatch.setattr(master, "ros", lambda: SimpleNamespace(rospy=rospy))
    monkeypatch.setattr(master, "_master", lambda: broken)
    monkeypatch.setattr(master, "LOOK_S", 0)
    master._watch(told.append)
    assert set(broken.topics) == {"ink", "status", "path"}
    assert told[-1] == "the ROS master is back; registered with it again"


def test_the_desk_takes_strokes_one_by_one(bench):
    for line in LINES:
        bench.desk.add_stroke(line, PAGE, Pen())
    assert len(bench.ear.drawings[-1].lines_mm) == 2
    bench.desk.add_stroke(np.zeros((0, 2)), PAGE, Pen())
    with pytest.raises(BadInput, match="there is no drawing"):
        bench.desk.plan(Settings(), DUMBO)


def test_a_program_that_died_keeps_no_other_from_its_end(tmp_path):
    world = World(tmp_path)
    other = world.begin("other", [sys.executable, "-c", "input()"], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    dead = world.begin("dead", [sys.executable, "-c", ""], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    dead.wait(60)
    dead.stdin.write("nobody reads this")
    world.close()
    assert other.poll() is not None


def test_the_action_has_the_sums_that_controllers_expect():
    need_ros()
    # In a process of its own: what ROS imports is not clean of warnings.
    code = (
        "from limner.ros.middleware import ros; c = ros().control;"
        "print(c.FollowJointTrajectoryAction._md5sum, c.FollowJointTrajectoryGoal._md5sum)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["bc4f9b743838566551c0390c65f1a248", "69636787b6ecbde4d61d711979bc7ecb"]
    assert len(definitions()) == 8
