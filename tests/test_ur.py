"""An arm over TCP, on a strict fake of one: what is sent, what goes wrong, what is said of it."""

from __future__ import annotations

import contextlib
import dataclasses
import functools
import json
import os
import resource
import socket
import threading
from types import SimpleNamespace

import numpy as np
import pytest

from arms import arm_clock
from limner import storage
from limner.errors import BadInput, CannotDraw, DeviceFailed, NothingToDraw
from limner.motion.arm.check import check
from limner.motion.arm.legs import legs
from limner.motion.arm.place import PlaceSettings
from limner.motion.arm.plan import ArmSettings, plan_arm
from limner.motion.arm.retime import RetimeSettings
from limner.motion.arm.robots import load_robot
from limner.targets.fake_ur import FakeUr
from limner.targets.journal import Journal, Place
from limner.targets.send import Control, drive
from limner.targets.ur import Ur, parse_host
from limner.targets.urscript import UrSettings
from limner.types import Drawing
from processes import until

pytest.importorskip("urdf_parser_py", reason="pip install 'limner[robot]'")
pytest.importorskip("toppra", reason="pip install 'limner[robot]'")

LINES = ([[60, 80], [80, 90], [90, 70]], [[60, 100]], [[60, 120], [70, 130]], [[100, 60], [70, 50], [75, 45]])
DRAWN = 4
"""Strokes of them; the dot is one of them."""


@pytest.fixture(scope="module")
def robot():
    return load_robot("ur5e")


@pytest.fixture(scope="module")
def motion(robot):
    made = Drawing(tuple(np.array(line, float) for line in LINES), ("face",) * len(LINES), np.ones(len(LINES)))
    return plan_arm(made, robot, ArmSettings(place=PlaceSettings(at="0.45,0,0"))).trajectory


@pytest.fixture(scope="module")
def route(robot, motion):
    return legs(motion, robot, RetimeSettings())


@pytest.fixture
def arm(robot, route, tmp_path):
    """Draw on a fake; gives the fake, where it ended, and where the journal stands."""

    def run(
        control=None,
        watch=lambda place, waits: None,
        resume=False,
        q=None,
        settings=None,
        silence_s=60.0,
        host="127.0.0.1",
        **kind,
    ):
        control = control or Control()
        lines = route.lines_mm()
        journal = Journal(tmp_path / "j", Drawing(lines, ("face",) * DRAWN, np.ones(DRAWN)), resume=resume)
        fake = FakeUr(
            robot.pose("safe") if q is None else q, robot.lower, robot.upper, robot.velocity, host=host, **kind
        )
        try:
            with fake:
                ur = Ur(host, fake.port, route, settings or UrSettings(), silence_s=silence_s)

                def draw(place):
                    return Place(place.stroke + ur.draw(place.stroke, lambda: control.stop))

                return fake, drive(ur, draw, DRAWN, journal, control, watch), journal
        finally:
            journal.close()
            run.fake = fake

    return run


def test_each_stroke_is_a_checked_motion_from_rest_to_rest_in_the_air(robot, motion, route):
    assert len(route.ends) == DRAWN
    for index in range(DRAWN):
        part = route.stroke(index)
        check(part, robot)
        assert np.abs(part.qd[[0, -1]]).max() < 1e-6
        height = route.tips(part.q)[:, 2]
        assert min(height[0], height[-1]) > 0.003
        low = np.linalg.norm(np.diff(route.tips(part.q), axis=0), axis=1)[(height[1:] < 0) & ~part.down[1:]]
        assert low.sum() < 0.025, "what touches before and after a stroke is straight up and down, or a dot"
        if index:
            assert np.allclose(part.q[0], route.stroke(index - 1).q[-1])


def test_the_strokes_draw_what_the_whole_motion_draws(motion, route):
    drawn = [part.q[part.down] for part in map(route.stroke, range(DRAWN))]
    assert np.array_equal(np.concatenate(drawn), motion.q[motion.down])


def test_slowing_down_never_leaves_the_way(motion, route):
    for index in range(DRAWN):
        tips = route.tips(route.stroke(index).q)
        near = [np.abs(route.tips(motion.q) - tip).sum(1).min() for tip in tips]
        assert max(near) < 0.004


def test_ways_to_and_from_every_stroke_are_checked_and_stay_off_the_paper(robot, motion, route):
    for index in range(DRAWN + 1):
        ways = [route.home(index)] + ([route.to_stroke(robot.pose("home"), index)] if index < DRAWN else [])
        for way in ways:
            check(way, robot)
            assert route.tips(way.q)[:, 2].min() > 0.002


def test_a_motion_without_strokes_or_beyond_limits_has_no_legs(robot, motion):
    with pytest.raises(NothingToDraw):
        legs(dataclasses.replace(motion, stroke=np.full(len(motion.t_s), -1)), robot, RetimeSettings())
    with pytest.raises(CannotDraw, match="over its limit"):
        legs(dataclasses.replace(motion, t_s=motion.t_s / 2), robot, RetimeSettings())


@pytest.mark.parametrize("way", ["servoj", "movel"])
def test_a_fake_draws_all_without_a_breach(arm, robot, route, way):
    fake, place, _ = arm(settings=UrSettings(way=way))
    assert (fake.breaches, place) == ([], Place(DRAWN))
    assert len(fake.done) == 2 + DRAWN, "there, the strokes, and back"
    assert np.allclose(fake.q, robot.pose("safe"), atol=1e-6)
    for index, moves in enumerate(fake.done[1:-1]):
        part = route.stroke(index)
        assert np.allclose(moves.q[[0, -1]], part.q[[0, -1]], atol=1e-7)
        if way == "servoj":
            assert np.abs(moves.q - part.at(moves.t_s)).max() < 1e-6


def test_a_host_may_have_the_newer_kind_of_address(arm):
    try:
        socket.create_server(("::1", 0), family=socket.AF_INET6).close()
    except OSError:
        pytest.skip("no IPv6 here; run: sysctl net.ipv6.conf.lo.disable_ipv6=0")
    fake, ended, _ = arm(host="::1")
    assert (fake.breaches, ended) == ([], Place(DRAWN))


def test_it_begins_from_wherever_the_arm_is(arm, robot):
    fake, place, _ = arm(q=robot.pose("home"))
    assert (fake.breaches, place) == ([], Place(DRAWN))
    assert np.allclose(fake.done[0].q[0], robot.pose("home"), atol=1e-5)


def test_stopped_within_a_stroke_it_lifts_and_goes_on_with_that_stroke(arm):
    control = Control()

    def watch(place, waits):
        if place.stroke == 1:
            threading.Timer(0.2, setattr, (control, "stop", True)).start()

    fake, place, journal = arm(control, watch, fault="stall", program=3)
    assert (fake.breaches, fake.lifts, place, journal.doubtful) == ([], 1, Place(1), False)
    assert len(fake.done) == 2, "it does not go home from within a stroke"
    again, place, _ = arm(resume=True, q=fake.q)
    assert (again.breaches, place) == ([], Place(DRAWN))
    assert len(again.done) == 1 + (DRAWN - 1) + 1


def test_paused_it_waits_in_the_air_and_goes_on(arm):
    control, waited = Control(), []

    def watch(place, waits):
        waited.append((place.stroke, waits))
        control.pause = place.stroke == 1 and sum(paused for _, paused in waited) < 3

    fake, place, _ = arm(control, watch)
    assert (fake.breaches, fake.lifts, place) == ([], 0, Place(DRAWN))
    assert (1, True) in waited


@pytest.mark.parametrize(
    ("fault", "program", "words", "pen"),
    [
        ("silence", 0, "never began; is the arm on", "unknown"),
        ("silence", 2, "never began", "is up"),
        ("stall", 2, "never ended", "is up"),
        ("again", 2, "never ended", "is up"),
        ("drop", 2, "connection to the arm ended", "is up"),
        ("die", 2, "connection to the arm ended", "unknown"),
        ("astray", 2, "5.7 degrees from where", "unknown"),
        ("nonsense", 2, "'nowhere', expected six joint positions", "is up"),
    ],
)
def test_what_goes_wrong_is_named_with_the_state_of_the_pen(arm, monkeypatch, fault, program, words, pen):
    monkeypatch.setattr("limner.targets.ur.SLACK", 0.0)
    monkeypatch.setattr("limner.targets.ur.time", SimpleNamespace(monotonic=arm_clock(1.0)))
    with pytest.raises(DeviceFailed) as error:
        arm(fault=fault, program=program, silence_s=2.5)
    text = str(error.value)
    assert words in text
    assert ("the pen is up" if pen == "is up" else "pen state unknown") in text
    assert "\n" not in text
    assert arm.fake.breaches == []
    assert arm.fake.lifts == (pen == "is up")


def test_it_draws_in_a_program_that_has_many_files_open(arm):
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    most = 1400
    if hard != resource.RLIM_INFINITY and hard < most:
        pytest.skip(f"ulimit -Hn is {hard}, expected {most} or more")
    with contextlib.ExitStack() as files:
        files.callback(resource.setrlimit, resource.RLIMIT_NOFILE, (soft, hard))
        resource.setrlimit(resource.RLIMIT_NOFILE, (max(soft, most), hard))
        highest = -1
        while highest < 1100:
            highest = files.enter_context(open(os.devnull)).fileno()
        fake, place, _ = arm(control=(control := Control()), watch=lambda p, _: setattr(control, "stop", p.stroke == 1))
    assert (fake.breaches, place) == ([], Place(1))


def test_a_host_that_refuses_or_is_unknown_is_named(route):
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
    for host, words in (("127.0.0.1", "refuses the connection"), ("no-such-host.invalid", "no host of this name")):
        with pytest.raises(DeviceFailed, match=words):
            Ur(host, port, route, UrSettings()).open()


@pytest.mark.parametrize(
    "text", ["ur:", "ur:a b", "ur:h:x", "ur:h:0", "ur:h:70000", "ur:fd00::10", "ur:[host]", "grbl:h", "ur"]
)
def test_what_is_no_host_is_refused(text):
    with pytest.raises(BadInput, match="ur:HOST"):
        parse_host(text)


def test_hosts_are_read():
    assert parse_host("ur:arm.local") == ("arm.local", 30002)
    assert parse_host("ur:10.0.0.2:30003") == ("10.0.0.2", 30003)
    assert parse_host("ur:[fd00::10]") == ("fd00::10", 30002)
    assert parse_host("ur:[fe80::1%eth0]:30003") == ("fe80::1%eth0", 30003)


def test_the_fake_finds_breaches(robot):
    def breaches(*programs):
        fake = FakeUr(robot.pose("safe"), robot.lower, robot.upper, robot.velocity)
        with fake, socket.create_connection(("127.0.0.1", fake.port)) as end:
            for text in programs:
                end.sendall(text.encode())
            end.shutdown(socket.SHUT_WR)
            until(lambda: fake.breaches)
        return " ".join(fake.breaches)

    with socket.create_server(("127.0.0.1", 0)) as ours:
        head = f'if not socket_open("127.0.0.1", {ours.getsockname()[1]}, "limner"):\nhalt\nend\n'
        head = "def limner():\n  " + head.replace("\n", "\n  ") + 'socket_send_line("ab begun", "limner")\n'
        tail = (
            'socket_send_line(str_cat("ab done ", to_str(get_actual_joint_positions())), "limner")\n'
            'socket_close("limner")\nend\n'
        )
        at = ", ".join(map(str, robot.pose("safe")))
        start = f"movej([{at}], a=0.5, v=0.25)\n"
        assert "in the middle" in breaches(head + start)
        assert "does not report" in breaches("def limner():\nend\n")
        assert "elsewhere" in breaches(head + "movej([0, 0, 0, 0, 0, 0], a=1, v=1)\n" + tail)
        assert "limits" in breaches(head + start + "movej([9, 0, 0, 0, 0, 0], a=1, v=1)\n" + tail)
        assert "faster" in breaches(head + start + "servoj([0, 0, 0, 0, 0, 0], 0, 0, 0.008, 0.1, 300)\n" + tail)
        assert "no move" in breaches(head + start + "servoj([nan, 0, 0, 0, 0, 0], 0, 0, 0.008, 0.1, 300)\n" + tail)


@pytest.fixture
def run(command, tmp_path, motion):
    storage.save(motion, tmp_path / "m.npz")
    storage.save(dataclasses.replace(motion, q=motion.q * 1.5), tmp_path / "altered.npz")
    return functools.partial(command, "send")


def test_the_command_draws_on_a_fake(run, tmp_path):
    code, out, err = run("m.npz", "--robot", "ur5e", "--to", "fake:", "--yes", "--json")
    assert (code, err) == (0, "")
    assert json.loads(out) == {"strokes": DRAWN, "began": 0, "drawn": DRAWN, "finished": True, "journal": None}
    assert not list(tmp_path.glob("*.journal"))


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (["m.npz", "--robot", "ur5e", "--to", "fake:"], 2, "--yes"),
        (["m.npz", "--robot", "ur5e", "--to", "grbl:x", "--yes"], 2, "ur:HOST"),
        (["m.npz", "--robot", "ur5e", "--to", "fake:", "--fit"], 2, "--fit is for plotters"),
        (["m.npz", "--robot", "dumbo", "--to", "fake:", "--yes"], 4, "for the joints"),
        (["altered.npz", "--robot", "ur5e", "--to", "fake:", "--yes"], 4, "trajectory"),
        (["m.npz", "--robot", "ur5e", "--to", "ur:127.0.0.1:9", "--yes"], 5, "refuses the connection"),
        (["m.npz", "--robot", "ur5e", "--to", "ur:no-such-host.invalid", "--yes"], 5, "is known; nothing has moved"),
        (["m.npz", "--to", "ur:127.0.0.1", "--yes"], 2, "--robot"),
    ],
)
def test_what_cannot_be_sent_is_said_in_a_line(run, arguments, code, words):
    found, out, err = run(*arguments)
    assert (found, out, err.count("\n")) == (code, "", 1)
    assert words in err
