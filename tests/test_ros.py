"""``limner ros`` through a real master: photos in, portraits out, drawn by an action; refusals, deaths, restarts."""

from __future__ import annotations

import signal

import numpy as np
import pytest

from limner.motion.arm.robots import load_robot
from limner.transforms import from_quaternion
from processes import until
from ros_world import World, need_ros

CONTROLLER = "left_arm_joint_trajectory_controller"
SQUARE = [[0.05, 0.05, 0], [0.09, 0.05, 0], [0.09, 0.09, 0], [0.05, 0.09, 0], [0.05, 0.05, 0]]
LINE = [[0.05, 0.12, 0], [0.11, 0.12, 0]]
LONG = [[0.03 + 0.09 * (k % 2), 0.03 + 0.004 * k, 0] for k in range(24)]
"""The arm is busy with it for so long that even a busy machine finds it in the middle."""
WAVE = [[0.05 + 0.002 * k, 0.14 + 0.01 * np.sin(k / 3), 0] for k in range(30)]
DUMBO = load_robot("dumbo")


@pytest.fixture(scope="module")
def photo():
    skimage = pytest.importorskip("skimage")
    from pathlib import Path

    return str(Path(skimage.__file__).parent / "data" / "astronaut.png")


class Desk:
    """The node and what it talks to, seen from outside."""

    def __init__(self, world):
        self.world = world
        world.master()
        self.controller()
        self.node()
        self.probe = world.probe()
        until(self.ready)

    def controller(self, *arguments):
        self.world.limner("controller", "_speed:=4", *arguments)

    def node(self, *arguments):
        # A busy machine keeps an arm silent for longer than one that draws may be.
        self.world.limner("node", f"_journal:={self.world.folder}/j", "_silence:=10", *arguments)

    def ready(self):
        return min(self.probe("connected")) > 0 and self.probe("count", topic="joint_states") > 0

    def call(self, name):
        return self.probe("call", service=f"/limner/{name}")

    def answer(self, name):
        """What a service that must be there says; a busy machine may keep it waiting."""
        return until(lambda: found if (found := self.call(name))[0] is not None else None)

    def grant(self, name):
        granted, message = self.answer(name)
        assert granted, message
        return message

    def refuse(self, name):
        granted, message = self.answer(name)
        assert granted is False, message
        return message

    def statuses(self):
        return self.probe("all", topic="status")

    def wait(self, text, since=0):
        """Until a status with this text has come; all that have come by then."""
        until(
            lambda: any(text in said for said in self.statuses()[since:]),
            lambda: f"{text!r} not in {self.statuses()[since:]}",
        )
        return self.statuses()

    def plan(self, *strokes):
        """Plan strokes [m], anew."""
        before = len(self.statuses())

        def cleared():
            # Again and again: after a node has ended its end of a connection seems to be there, and eats a message.
            self.probe("stroke", points=[])
            return any("drawing: 0 strokes" in said for said in self.statuses()[before:])

        until(cleared)
        for index, stroke in enumerate(strokes):
            self.probe("stroke", points=stroke)
            self.wait(f"drawing: {index + 1} strokes", before)
        count = self.probe("count", topic="trajectory")
        self.grant("plan")
        until(lambda: self.probe("count", topic="trajectory") > count)
        until(lambda: self.shows(strokes), lambda: f"not the strokes that were planned: {self.lines()}")

    def shows(self, strokes):
        """Whether these strokes [m] are those that were told last."""
        if not self.probe("last", topic="strokes"):
            return False
        told, given = self.lines(), [1000 * np.array(stroke)[:, :2] for stroke in strokes]
        return len(told) == len(given) and all(
            len(a) == len(b) and np.allclose(a, b, atol=1e-3) for a, b in zip(told, given, strict=True)
        )

    def finish(self, since):
        self.wait("drawn: ", since)
        # The last ink is published with the next tick.
        until(lambda: self.covers(self.lines()) < 1, lambda: f"{self.covers(self.lines()):.2f} mm of the plan lack ink")

    def lines(self):
        """Strokes that are planned [mm]."""
        return [1000 * np.array(line)[:, :2] for line in self.probe("last", topic="strokes")["lines"]]

    def ink(self):
        """Segments (n, 2, 2) [mm]."""
        return 1000 * np.array(self.probe("last", topic="ink")["points"]).reshape(-1, 2, 3)[..., :2]

    def covers(self, lines):
        """How far [mm] a place of the plan is from ink at most."""
        ink = self.ink()
        return max(distances(dense(line), ink).max() for line in lines) if len(ink) else np.inf

    def beside(self, lines):
        """How far [mm] ink is from the plan at most."""
        plan = np.concatenate([np.stack([line[:-1], line[1:]], axis=1) for line in lines])
        return distances(self.ink().reshape(-1, 2), plan).max()

    def pen_height(self):
        """Of the tip over the sheet [mm]."""
        found = self.probe("frame", target="paper", source="pen_tip")
        assert isinstance(found, list), found
        return 1000 * found[2]


def dense(line, step=0.5):
    along = np.r_[0, np.cumsum(np.hypot(*np.diff(line, axis=0).T))]
    t = np.linspace(0, along[-1], int(along[-1] / step) + 2)
    return np.stack([np.interp(t, along, line[:, k]) for k in range(2)], axis=1)


def distances(points, segments):
    """From each of (n, 2) points to the nearest of (m, 2, 2) segments."""
    a, d = segments[:, 0], segments[:, 1] - segments[:, 0]
    length = np.maximum((d**2).sum(1), 1e-12)
    t = np.clip(((points[:, None] - a) * d).sum(2) / length, 0, 1)
    return np.linalg.norm(points[:, None] - (a + t[..., None] * d), axis=2).min(1)


@pytest.fixture(scope="module")
def world(tmp_path_factory):
    need_ros()
    world = World(tmp_path_factory.mktemp("ros"))
    try:
        yield Desk(world)
    finally:
        world.close()


@pytest.fixture
def desk(world):
    """The one of the module; a test that fails leaves no arm that draws, and tells what its programs said."""
    before = {name: len(world.world.said(name)) for name in ("node", "controller")}
    said = len(world.statuses())
    yield world
    world.call("stop")
    print(*world.statuses()[said:], sep="\n")
    for name, length in before.items():
        print(f"-- {name}", world.world.said(name)[length:], sep="\n")


def test_distances():
    segments = np.array([[[0, 0], [10, 0]]], float)
    assert np.allclose(distances(np.array([[5, 3], [-4, 3], [10, 0]], float), segments), [3, 5, 0])


def test_a_photo_goes_in_and_the_arm_draws_the_portrait(desk, photo):
    desk.probe("param", name="/limner/points", value=60)
    before = len(desk.statuses())
    desk.probe("photo", file=photo)
    desk.wait("planned", before)
    # Each topic comes its own way: the status may be the first.
    until(lambda: all(desk.probe("last", topic=topic) for topic in ("trajectory", "portrait", "path", "strokes")))
    portrait = desk.probe("last", topic="portrait")
    assert portrait["encoding"] == "rgb8"
    assert portrait["size"] == [592, 840]
    assert 200 < portrait["mean"] < 254
    lines, motion, path = desk.lines(), desk.probe("last", topic="trajectory"), desk.probe("last", topic="path")
    assert sum(map(len, lines)) <= 60 + len(lines)
    assert path["frame"] == "paper"
    assert tuple(motion["names"]) == DUMBO.joints
    assert (DUMBO.margin(motion["q"]) > 0).all()
    low, high = np.concatenate(lines).min(0), np.concatenate(lines).max(0)
    assert (low > 9).all()
    assert (high < (139, 201)).all()
    before = len(desk.statuses())
    desk.grant("start")
    desk.finish(before)
    assert desk.beside(lines) < 0.5
    assert desk.probe("all", topic="progress")[-1] == pytest.approx(1)


def test_frames_go_from_the_robot_to_the_pen(desk):
    desk.plan(LINE)
    assert desk.probe("frame", target="base_link", source="arm_base_link")[:3] == pytest.approx([0, 0.06, 1.0085])
    assert isinstance(desk.probe("frame", target="base_link", source="pen_tip"), list)
    assert desk.pen_height() > 40


def test_two_starts_at_once_and_a_pause(desk):
    desk.plan(LONG, LINE, WAVE)
    assert "does not draw" in desk.refuse("pause")
    before = len(desk.statuses())
    (granted, _), (refused, why) = sorted(desk.probe("race", service="/limner/start"), reverse=True)
    assert (granted, refused) == (True, False)
    assert "the arm is drawing" in why
    for wish in ("start", "plan", "sketch", "calibrate_point"):
        assert "the arm is drawing" in desk.refuse(wish)
    assert "already" in desk.refuse("resume")
    desk.wait("drawing stroke 1", before)
    desk.grant("pause")
    desk.wait("paused with the pen up before stroke 2 of 3", before)
    until(lambda: desk.pen_height() > 3)  # the frame is told a moment after
    until(lambda: desk.covers(desk.lines()[:1]) < 1)
    assert "the arm is drawing" in desk.refuse("start")
    assert desk.beside(desk.lines()[:1]) < 0.5, "no ink of what comes after the pause"
    assert desk.covers(desk.lines()) > 10
    desk.grant("resume")
    desk.finish(before)
    assert desk.beside(desk.lines()) < 0.5


def test_stop_raises_the_pen_in_the_middle_of_a_stroke(desk):
    desk.plan(LONG, WAVE)
    before = len(desk.statuses())
    desk.grant("start")
    until(lambda: len(desk.ink()) > 10)
    message = desk.grant("stop")
    assert "stopped with the pen up: 0 of 2" in message
    until(lambda: desk.pen_height() > 30)
    assert desk.covers(desk.lines()) > 10
    assert desk.beside(desk.lines()) < 0.5
    assert "does not draw" in desk.refuse("stop")
    desk.grant("resume")
    desk.finish(before)
    assert desk.beside(desk.lines()) < 0.5
    assert "nothing was left unfinished" in desk.refuse("resume")


def test_a_controller_that_dies_leaves_the_pen_alone(desk):
    desk.plan(LONG, LINE)
    before = len(desk.statuses())
    desk.grant("start")
    until(lambda: len(desk.ink()) > 10)
    desk.world.end("controller", signal.SIGKILL)
    said = desk.wait("pen state unknown: lift it by hand", before)[-1]
    assert "joint_states" in said
    assert "~resume" in said
    where = desk.probe("last", topic="joint_states")["q"]
    before = len(desk.statuses())
    desk.grant("resume")
    desk.wait("is the controller running?", before)
    desk.controller("_start:=" + str(list(where)))
    heard = desk.probe("count", topic="joint_states")
    until(lambda: desk.probe("count", topic="joint_states") > heard)
    before = len(desk.statuses())
    desk.grant("resume")
    desk.finish(before)
    assert desk.beside(desk.lines()) < 0.5


@pytest.mark.parametrize(
    ("stroke", "frame", "reason"),
    [
        ([[0.05, float("nan"), 0]], "paper", "NaN"),
        ([[0.05, 0.05, 0]], "base_link", "in frame 'base_link', expected 'paper'"),
        ([[0.05, 0.05, 0]], "", "in frame ''"),
        ([[50, 50, 0], [60, 50, 0]], "paper", "leaves the page"),
        ([[0.05, 0.05, 0.2]], "paper", "0.2 m off the sheet"),
    ],
)
def test_strokes_that_are_none_are_refused(desk, stroke, frame, reason):
    before = len(desk.statuses())
    desk.probe("stroke", points=stroke, frame=frame)
    assert reason in next(said for said in desk.wait("refused: drawing", before)[before:] if "refused" in said)


def test_images_that_are_none_are_refused(desk, photo):
    for encoding, size, reason in (
        ("16UC1", None, "choose rgb8, bgr8, mono8"),
        ("rgb8", [9000, 9000], "expected 1 to 40 million"),
        ("rgb8", [700, 512], "bytes with rows of"),
    ):
        before = len(desk.statuses())
        desk.probe("photo", file=photo, encoding=encoding, size=size)
        desk.wait(reason, before)


@pytest.mark.parametrize("encoding", ["bgr8", "mono8"])
def test_other_encodings_draw(desk, photo, encoding):
    before = len(desk.statuses())
    desk.probe("photo", file=photo, encoding=encoding)
    desk.wait("planned", before)


def test_joints_that_cannot_be_are_refused(desk):
    for names, q, reason in (
        (DUMBO.joints, [float("nan")] * 7, "NaN"),
        (DUMBO.joints[:3], [0.0] * 3, f"no {DUMBO.joints[3]}"),
        (DUMBO.joints, [0.0], "7 names, 1 positions"),
    ):
        before = len(desk.statuses())
        desk.probe("joints", names=names, q=q)
        desk.wait(reason, before)


def test_goals_may_be_cancelled_at_any_moment(desk):
    """Feedback that is told while a cancel comes in must not have the two wait for each other."""
    here = np.array(desk.probe("last", topic="joint_states")["q"])
    given = {"names": DUMBO.joints, "q": [here.tolist(), here.tolist()], "t": [0.0, 60.0]}
    ended = desk.probe("cancels", controller=CONTROLLER, times=40, **given)
    assert set(ended) == {2}, "preempted"
    count = desk.probe("count", topic="joint_states")
    until(lambda: desk.probe("count", topic="joint_states") > count + 10)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"names": ["elbow", *DUMBO.joints[1:]]}, "for the joints elbow"),
        ({"q": "far"}, "begins 1.000 rad from where"),
        ({"q": "over"}, "its limits are"),
        ({"q": "nan"}, "NaN"),
        ({"t": [0.0, 0.01]}, "velocity"),
        ({"t": [0.0, 0.0]}, "times from the start must grow"),
        ({"velocities": False}, "0 velocities, expected 7"),
        ({"q": [], "t": []}, "has no points"),
    ],
)
def test_the_controller_refuses_what_a_real_one_would(desk, change, reason):
    here = np.array(desk.probe("last", topic="joint_states")["q"])
    given = {"names": DUMBO.joints, "q": [here, here + 0.1], "t": [0.0, 5.0], "velocities": True} | change
    if isinstance(given["q"], str):
        move = {"far": [here + 1, here + 1], "over": [here, here + 9], "nan": [here, here * np.nan]}
        given["q"] = move[given["q"]]
    given["q"] = [list(row) for row in given["q"]]
    state, text = desk.probe("goal", controller=CONTROLLER, **given)
    assert state == 5, "rejected"
    assert reason in text
    assert np.allclose(desk.probe("last", topic="joint_states")["q"], here)


def test_three_probed_points_say_where_the_sheet_lies(desk):
    desk.plan(LINE)
    found = desk.probe("frame", target="arm_base_link", source="paper")
    here, turn = np.array(found[:3]), from_quaternion(found[3:])
    desk.grant("calibrate_clear")
    before = len(desk.statuses())
    desk.probe("point", place=here.tolist(), frame="somewhere")
    desk.wait("in frame 'somewhere', expected 'arm_base_link'", before)
    corner = here + np.array([0.02, 0.01, 0.005])
    # Along the sheet as it was found to lie, a little beside it: there the arm reaches all of it too.
    for step in ([0, 0, 0], [0.12, 0, 0], [0.06, 0.1, 0]):
        desk.probe("point", place=(corner + turn @ step).tolist(), frame="arm_base_link")
    until(lambda: "point 3" in desk.statuses()[-1])
    assert "nothing is planned" in desk.refuse("start")
    desk.plan(LINE)
    until(lambda: near(desk.probe("frame", target="arm_base_link", source="paper")[:3], corner))
    assert "forgot 3 points" in desk.grant("calibrate_clear")


def near(place, other):
    return np.allclose(place, other, atol=1e-6)


def test_the_master_goes_away_and_comes_back(desk):
    desk.plan(LONG, LINE)
    before = len(desk.statuses())
    desk.grant("start")
    until(lambda: len(desk.ink()) > 10)
    desk.world.end("master")
    desk.wait("the ROS master is gone", before)
    desk.finish(before)
    desk.world.master()
    desk.wait("the ROS master is back", before)
    desk.grant("start")
    assert desk.refuse("start").startswith("start: the arm is drawing")
    desk.grant("stop")


def restarted(desk, *arguments):
    desk.world.end("node")
    desk.node(*arguments)
    # A node that previews an arm does not listen to joints.
    until(lambda: desk.call("pause")[0] is not None and min(desk.probe("connected")[:-1]) > 0)


def test_a_command_topic_draws_the_same(desk):
    restarted(desk, "_target:=command")
    desk.plan(LINE, SQUARE)
    before = len(desk.statuses())
    desk.grant("start")
    until(lambda: len(desk.ink()) > 5)
    assert "stopped with the pen up" in desk.grant("stop")
    until(lambda: desk.pen_height() > 30)
    desk.grant("resume")
    desk.finish(before)
    assert desk.beside(desk.lines()) < 0.5


def test_a_preview_draws_without_an_arm(desk):
    desk.world.end("controller")
    restarted(desk, "_target:=none")
    desk.plan(LINE)
    before = len(desk.statuses())
    desk.grant("start")
    desk.finish(before)
    assert desk.beside(desk.lines()) < 0.5
