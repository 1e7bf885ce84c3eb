"""Bags of ROS: read by Debian's own ROS 1, by a reader of MCAP that is not the writer's, and by SQLite."""

from __future__ import annotations

import functools
import json
import os
import shlex
import shutil
import sqlite3
import subprocess
from pathlib import Path

import numpy as np
import pytest

from arms import LINES, drawing, planned, robot
from limner import storage, transforms
from limner.errors import BadInput, MissingExtra
from limner.motion.arm.robots import load_robot
from limner.targets import bag
from limner.targets.recording import LATCHED, START_NS, TOPICS, Recording, messages
from limner.targets.ros_points import controller_points
from limner.types import JointTrajectory

for package, extra in (("urdf_parser_py", "robot"), ("toppra", "robot"), ("rosbags", "ros")):
    pytest.importorskip(package, reason=f"pip install 'limner[{extra}]'")

BASE_FROM_ROOT = np.array([0.0, 0.06, 0.696 + 0.3125])
"""Where Dumbo's arm base is, as its makers publish it."""


def recording(motion=None):
    motion = motion or planned().trajectory
    return Recording(
        motion=motion,
        tips=robot().forward(motion.q),
        base_from_paper=planned().placement.base_from_paper,
        root_from_base=robot().root_from_base,
        root=robot().root,
        base=robot().base,
        pen_mm=0.5,
    )


@pytest.fixture(scope="module")
def said():
    return list(messages(recording()))


@pytest.fixture(scope="module")
def bags(tmp_path_factory):
    folder = tmp_path_factory.mktemp("bags")
    for suffix in bag.FORMATS:
        bag.save(recording(), folder / f"out{suffix}")
    return folder


def with_topic(said, topic):
    return [message for message in said if message.topic == topic]


def test_messages_come_in_the_order_of_the_plan(said):
    times = [message.time_ns for message in said]
    assert times == sorted(times)
    assert times[0] == START_NS
    assert times[-1] - START_NS == round(1e9 * planned().trajectory.t_s[-1])
    assert {message.topic for message in said} == set(TOPICS)
    for topic in LATCHED:
        assert len(with_topic(said, topic)) == 1


def test_frames_lead_from_the_root_to_the_pen(said):
    def matrix(transform):
        turn = transforms.from_quaternion([transform["transform"]["rotation"][k] for k in "wxyz"])
        return transforms.transform(turn, [transform["transform"]["translation"][k] for k in "xyz"])

    static = with_topic(said, "/tf_static")[0].fields["transforms"]
    assert [(t["header"]["frame_id"], t["child_frame_id"]) for t in static] == [
        ("base_link", "arm_base_link"),
        ("arm_base_link", "paper"),
    ]
    assert np.allclose(matrix(static[0])[:3, 3], BASE_FROM_ROOT)
    moving = with_topic(said, "/tf")
    for k in range(0, len(moving), 50):
        (tip,) = moving[k].fields["transforms"]
        assert (tip["header"]["frame_id"], tip["child_frame_id"]) == ("paper", "pen_tip")
        assert np.allclose(matrix(static[1]) @ matrix(tip), robot().forward(planned().trajectory.q[k]), atol=1e-9), (
            "the chain ends where the arm's kinematics say"
        )


def test_a_robot_without_more_around_it_has_no_root(tmp_path):
    arm = load_robot("dumbo", base="base_link")
    assert (arm.root, arm.base) == ("base_link", "base_link")
    assert np.array_equal(arm.root_from_base, np.eye(4))
    q = arm.pose("safe")
    assert np.allclose(arm.forward(q), robot().root_from_base @ robot().forward(q)), "both ways lead to the pen"


def test_ink_grows_to_the_whole_drawing(said):
    grown = {}
    for message in with_topic(said, "/ink"):
        points = np.array([[p["x"], p["y"]] for p in message.fields["points"]]) * 1000
        before = grown.get(message.fields["id"], points[:0])
        if message.fields["type"] == 4 and len(before) > 1:
            assert np.array_equal(points[: len(before)], before), "what is drawn stays"
        grown[message.fields["id"]] = points
    assert list(grown) == list(range(len(LINES))), "a dot is ink too"
    for line, points in zip(LINES, grown.values(), strict=True):
        for vertex in np.array(line, float):
            assert np.linalg.norm(points - vertex, axis=1).min() < 0.3, "rounded by 0.15 mm, and sampled"


def test_a_controller_may_take_the_trajectory(said):
    (message,) = with_topic(said, "/trajectory")
    points = message.fields["points"]
    t = [p["time_from_start"]["sec"] * 10**9 + p["time_from_start"]["nanosec"] for p in points]
    assert t[0] == 0
    assert min(np.diff(t)) > 0
    assert max(np.diff(t)) <= 0.0201e9
    assert message.fields["header"]["stamp"] == {"sec": 0, "nanosec": 0}, "begins when it arrives"
    assert np.array_equal(points[0]["positions"], robot().pose("safe"))
    assert (np.abs([p["velocities"] for p in points]) <= 1.01 * robot().velocity).all()
    assert not any(p["accelerations"] for p in points), "with these, controllers lay quintics, not the cubics checked"
    assert not np.any(points[-1]["velocities"])


def test_what_a_controller_interpolates_stays_on_the_path():
    """Between points without accelerations ros_control lays cubics: the tip as planned, in the middle of every step."""
    points = controller_points(planned().trajectory)
    step = np.diff(points.time_ns / 1e9)[:, None]
    q, v = points.q, points.qd
    middle = (q[:-1] + q[1:]) / 2 + step * (v[:-1] - v[1:]) / 8
    tips = robot().forward(q)[:, :3, 3]
    off = robot().forward(middle)[:, :3, 3] - (tips[:-1] + tips[1:]) / 2
    sagitta = np.linalg.norm(off, axis=1) * 1000
    assert sagitta[planned().trajectory.down[1 : len(q)]].max() < 0.1


def motion_of(t, q, qd=None):
    n = len(t)
    qd = np.zeros((n, 1)) if qd is None else qd
    return JointTrajectory(("a",), t, q, qd, np.zeros((n, 1)), np.zeros(n, bool), np.full(n, -1))


def test_two_samples_at_one_time_are_one_point():
    points = controller_points(motion_of([0.5, 0.5, 0.52, 0.52, 0.54], np.zeros((5, 1))))
    assert points.time_ns.tolist() == [0, 20_000_000, 40_000_000]


def test_what_no_controller_takes_is_refused():
    with pytest.raises(BadInput, match="200 ms apart, controllers need 50 ms"):
        controller_points(motion_of([0.0, 0.2], np.zeros((2, 1))))
    with pytest.raises(BadInput, match="rest"):
        controller_points(motion_of([0.0, 0.02], np.zeros((2, 1)), np.ones((2, 1))))


def test_the_same_plan_gives_the_same_bytes(bags, tmp_path):
    for suffix in bag.FORMATS:
        bag.save(recording(), tmp_path / f"out{suffix}")
    names = [path.relative_to(tmp_path) for path in sorted(tmp_path.rglob("*")) if path.is_file()]
    assert [str(name) for name in names] == [
        *("out.bag", "out.db3/metadata.yaml", "out.db3/out.db3", "out.mcap/metadata.yaml", "out.mcap/out.mcap"),
    ]
    for name in names:
        assert (bags / name).read_bytes() == (tmp_path / name).read_bytes()


def expected_trajectory():
    points = controller_points(planned().trajectory)
    return points.time_ns / 1e9, points.q


def test_an_independent_reader_decodes_the_mcap(bags, said):
    reader = pytest.importorskip("mcap_ros2.reader", reason="pip install mcap-ros2-support")
    heard = {topic: [] for topic in TOPICS}
    for message in reader.read_ros2_messages(str(bags / "out.mcap" / "out.mcap")):
        heard[message.channel.topic].append((message.log_time_ns, message.ros_msg))
    assert {topic: len(found) for topic, found in heard.items()} == {t: len(with_topic(said, t)) for t in TOPICS}
    for topic in TOPICS:
        assert [time_ns for time_ns, _ in heard[topic]] == [message.time_ns for message in with_topic(said, topic)]
    ((_, trajectory),) = heard["/trajectory"]
    t, q = expected_trajectory()
    assert list(trajectory.joint_names) == list(robot().joints)
    times = [p.time_from_start.sec + 1e-9 * p.time_from_start.nanosec for p in trajectory.points]
    assert np.allclose(times, t, atol=1e-9)
    assert np.array_equal([p.positions for p in trajectory.points], q)
    ((_, path),) = heard["/path"]
    assert path.header.frame_id == "paper"
    assert len(path.poses) == len(planned().trajectory.t_s)
    _, marker = heard["/ink"][-1]
    assert (marker.ns, marker.type, marker.scale.x) == ("ink", 4, 0.0005)
    assert marker.color.a == 1.0


def test_sqlite_has_every_message(bags, said):
    with sqlite3.connect(f"file:{bags / 'out.db3' / 'out.db3'}?mode=ro", uri=True) as data:
        topics = dict(data.execute("select name, type from topics"))
        counts = dict(
            data.execute("select t.name, count(*) from messages m join topics t on t.id = m.topic_id group by t.name")
        )
        times = [row[0] for row in data.execute("select timestamp from messages order by id")]
        qualities = dict(data.execute("select name, offered_qos_profiles from topics"))
        (path,) = data.execute(
            "select m.data from messages m join topics t on t.id = m.topic_id where t.name = '/path'"
        ).fetchone()
    data.close()
    assert topics == TOPICS
    assert counts == {topic: len(with_topic(said, topic)) for topic in TOPICS}
    assert times == [message.time_ns for message in said]
    assert {topic for topic, text in qualities.items() if "durability: 1" in text} == set(LATCHED)
    # CDR: four bytes of encapsulation, the stamp (sec, nanosec), then the name of the frame with its length.
    assert path[:4] == b"\x00\x01\x00\x00"
    assert np.frombuffer(path[4:16], "<i4").tolist() == [1, 0, 6]
    assert path[16:22] == b"paper\x00"


def debian(*needed):
    for program in needed:
        if shutil.which(program) is None:
            pytest.skip("apt-get install -y --no-install-recommends python3-rosbag (and the rest of tests/debian.txt)")


def plain_environment():
    return {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "VIRTUAL_ENV"))}


def test_rosbag_info_reads_the_ros1_bag(bags, said):
    from ruamel.yaml import YAML

    debian("rosbag")
    command = ["/usr/bin/python3", shutil.which("rosbag"), "info", "--yaml", str(bags / "out.bag")]
    done = subprocess.run(command, capture_output=True, text=True, check=True, env=plain_environment(), timeout=240)
    told = YAML(typ="safe").load(done.stdout)
    assert told["messages"] == len(said)
    assert told["duration"] == pytest.approx(planned().trajectory.t_s[-1], abs=1e-3)
    assert {t["topic"]: t["messages"] for t in told["topics"]} == {t: len(with_topic(said, t)) for t in TOPICS}
    # The check sums that ROS 1 itself has for these messages.
    sums = {t["type"]: t["md5"] for t in told["types"]}
    program = (
        "import sys; from roslib.message import get_message_class as c; print(*[c(n)._md5sum for n in sys.argv[1:]])"
    )
    command = ["/usr/bin/python3", "-c", program, *sums]
    own = subprocess.run(command, capture_output=True, text=True, check=True, env=plain_environment(), timeout=240)
    assert dict(zip(sums, own.stdout.split(), strict=True)) == sums


def test_rosbag_play_replays_it_in_the_time_of_the_plan(bags, said):
    debian("rosbag", "rosmaster", "unshare", "ip")
    script = Path(__file__).with_name("ros_replay.py")
    rate = 4.0
    counts = {topic: len(with_topic(said, topic)) for topic in TOPICS}
    played = shlex.quote(json.dumps(counts))
    inner = f'ip link set lo up && exec /usr/bin/python3 "{script}" "{bags / "out.bag"}" {rate} {played}'
    # roscpp listens on every address whatever it is told: the test has a network of its own.
    own = ["unshare", "-n"] if os.geteuid() == 0 else ["unshare", "-rn"]
    done = subprocess.run(
        [*own, "sh", "-c", inner], capture_output=True, text=True, env=plain_environment(), timeout=480, check=False
    )
    assert done.returncode == 0, done.stderr[-2000:]
    heard = json.loads(done.stdout)
    assert heard["counts"]["/path"] == heard["counts"]["/trajectory"] == heard["counts"]["/tf_static"] == 1
    for topic in ("/tf", "/joint_states", "/ink"):
        assert 0.9 * counts[topic] <= heard["counts"][topic] <= counts[topic]
    # No faster than planned; how much slower is the machine's. How long it lasts ``rosbag info`` has told exactly.
    assert heard["seconds"] * rate > 0.75 * planned().trajectory.t_s[-1]
    t, q = expected_trajectory()
    assert np.allclose(heard["times"], t, atol=1e-8)
    assert np.array_equal(heard["positions"], q)
    assert heard["path_frame"] == "paper"
    poses = transforms.inverse(planned().placement.base_from_paper) @ robot().forward(planned().trajectory.q)
    assert np.allclose(heard["path"], poses[:, :3, 3], atol=1e-9)
    tip = transforms.apply(robot().root_from_base, robot().forward(planned().trajectory.at(2.0))[:3, 3])
    assert np.allclose(heard["tip_at_2s"], tip, atol=1e-3), "tf finds the pen from the robot's root"
    assert len(heard["ink"]) == len(LINES)


@pytest.fixture
def run(command, tmp_path):
    storage.save(drawing(), tmp_path / "d.json")
    return functools.partial(command, "plan", "d.json")


def test_the_command_writes_bags_over_those_that_are_there(run, tmp_path, bags):
    bag.save(recording(), tmp_path / "out.mcap")
    (tmp_path / "out.mcap" / "metadata.yaml").write_text("old")
    code, out, _ = run("--robot", "dumbo", "--bag", "out.bag", "--bag", "out.mcap", "--json")
    assert (code, json.loads(out)["out"]) == (0, ["out.bag", "out.mcap"])
    for name in ("out.bag", "out.mcap/metadata.yaml", "out.mcap/out.mcap"):
        assert (tmp_path / name).read_bytes() == (bags / name).read_bytes()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["d.json", "out.bag", "out.mcap"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--robot", "dumbo", "--bag", "out.rosbag"], "a bag cannot be '.rosbag'; choose .bag, .mcap, .db3"),
        (["--bag", "out.bag"], "--bag is for arms"),
        (["--robot", "dumbo", "--bag", "file.mcap"], "file.mcap: something else has this name"),
        (["--robot", "dumbo", "--bag", "folder.db3"], "folder.db3: something else has this name"),
        (["--robot", "dumbo", "--bag", "folder.bag"], "folder.bag: something else has this name"),
        (["--robot", "dumbo", "--bag", "no/out.bag"], "no/out.bag: cannot be written (No such file or directory)"),
        (["--robot", "dumbo", "--bag", "no/out.mcap"], "no/out.mcap: cannot be written (No such file or directory)"),
    ],
)
def test_what_cannot_be_written_is_said_in_a_line(run, tmp_path, arguments, words):
    (tmp_path / "file.mcap").write_text("mine")
    for name in ("folder.db3", "folder.bag"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "mine.txt").write_text("mine")
    before = sorted(tmp_path.rglob("*"))
    code, out, err = run(*arguments)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert words in err
    assert sorted(tmp_path.rglob("*")) == before


def test_a_bag_that_fails_in_the_middle_leaves_the_old_one(tmp_path, monkeypatch):
    def broken(recording):
        yield from list(messages(recording))[:10]
        raise OSError(28, "No space left on device")

    for suffix in bag.FORMATS:
        bag.save(recording(), tmp_path / f"out{suffix}")
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    monkeypatch.setattr(bag, "messages", broken)
    for suffix in bag.FORMATS:
        with pytest.raises(BadInput, match="No space left"):
            bag.save(recording(), tmp_path / f"out{suffix}")
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before


def test_without_rosbags_it_says_what_to_install(monkeypatch, tmp_path):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(MissingExtra, match=r"limner\[ros\]"):
        bag.check(tmp_path / "out.bag")
