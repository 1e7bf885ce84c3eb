"""An arm over rosbridge, on a strict fake of one: what is sent, what another client hears, what goes wrong."""

from __future__ import annotations

import functools
import http.server
import json
import re
import socket
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np
import pytest

from arms import DRAWN, arm_clock, planned, robot, route
from limner import storage
from limner.cli import jobs
from limner.errors import BadInput, DeviceFailed, MissingExtra
from limner.targets import bridge as bridge_module
from limner.targets.bridge import Bridge, BridgeAddress, parse_bridge
from limner.targets.fake_rosbridge import FakeRosbridge
from limner.targets.journal import Journal, Place
from limner.targets.rosbridge import Rosbridge, RosbridgeSettings
from limner.targets.send import Control, drive
from limner.types import Drawing
from processes import begun, until

for package, extra in (("urdf_parser_py", "robot"), ("toppra", "robot"), ("websockets", "ros")):
    pytest.importorskip(package, reason=f"pip install 'limner[{extra}]'")

TOPIC = "/left_arm_joint_trajectory_controller/command"
PACE = 20.0
PATIENCE_S = 60


def fake_arm(q=None, **options):
    limits = (robot().lower, robot().upper, robot().velocity, robot().acceleration)
    q = robot().pose("safe") if q is None else q
    return FakeRosbridge(robot().joints, q, limits, TOPIC, pace=PACE, **options)


def driver(port, settings=None, silence_s=40.0):
    address = BridgeAddress(f"ws://127.0.0.1:{port}", TOPIC)
    return Rosbridge(
        address, route(), settings or RosbridgeSettings(), robot().joints, robot().base, silence_s, arm_clock(PACE)
    )


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    monkeypatch.setattr("limner.targets.rosbridge.BACKOFF_S", (0.02, 0.02))


@pytest.fixture
def arm(tmp_path):
    """Draw on a fake; gives the fake, where it ended, and where the journal stands."""

    def run(control=None, watch=lambda place, waits: None, resume=False, settings=None, **kind):
        control = control or Control()
        journal = Journal(tmp_path / "j", Drawing(route().lines_mm(), ("face",) * DRAWN, np.ones(DRAWN)), resume=resume)
        fake = run.fake = fake_arm(**kind)
        try:
            with fake:
                device = driver(fake.port, settings)

                def draw(place):
                    return Place(place.stroke + device.draw(place.stroke, lambda: control.stop))

                return fake, drive(device, draw, DRAWN, journal, control, watch), journal
        finally:
            journal.close()

    return run


@pytest.mark.parametrize("ros", ["1", "2"])
def test_a_fake_draws_all_without_a_breach(arm, ros):
    fake, place, _ = arm(settings=RosbridgeSettings(ros=ros), ros=ros)
    assert (fake.breaches, place, fake.stops, fake.connections) == ([], Place(DRAWN), 0, 1)
    assert len(fake.done) == 1 + DRAWN + 1, "there, the strokes, and back"
    assert np.allclose(fake.q, robot().pose("safe"), atol=1e-9)
    for index, heard in enumerate(fake.done[1:-1]):
        part = route().stroke(index)
        assert np.allclose(heard.q, part.at(heard.t_s), atol=1e-9)
        assert np.abs(heard.t_s - part.t_s).max() < 1e-9


def test_it_begins_from_wherever_the_arm_is(arm):
    start = robot().pose("safe") + 0.1
    fake, place, _ = arm(q=start)
    assert (fake.breaches, place) == ([], Place(DRAWN))
    assert np.allclose(fake.done[0].q[0], start)


def test_services_are_called_where_they_are_named(arm):
    settings = RosbridgeSettings(before="/power/on", stop="/power/off")
    fake, place, _ = arm(settings=settings, services=("/power/on", "/power/off"))
    assert (fake.breaches, place, fake.called) == ([], Place(DRAWN), ["/power/on"])
    with pytest.raises(DeviceFailed, match=r"service /power/on failed: there is no such service"):
        arm(settings=settings)
    assert arm.fake.done == []


def test_stopped_it_ends_in_the_air_and_goes_on_there(arm, monkeypatch):
    control, arrives, begun = Control(), Rosbridge._arrive, []

    def watch(place, waits):
        begun.append(place.stroke)

    def arrive(self, motion):
        control.stop = begun[-1] == 1
        arrives(self, motion)

    monkeypatch.setattr(Rosbridge, "_arrive", arrive)

    fake, place, journal = arm(control, watch)
    assert (fake.breaches, place, journal.doubtful, fake.stops) == ([], Place(2), False, 0)
    assert np.allclose(fake.q, robot().pose("safe"), atol=1e-9), "it goes home"
    monkeypatch.undo()
    again, place, _ = arm(resume=True)
    assert (again.breaches, place) == ([], Place(DRAWN))
    assert len(again.done) == 1 + (DRAWN - 2) + 1


def test_stopped_on_the_way_to_a_stroke_that_one_is_not_drawn():
    with fake_arm() as fake:
        device = driver(fake.port)
        device.open()
        assert not device.draw(0, lambda: True)
        assert device.abort(), "the pen is up"
        device.close()
    assert (len(fake.done), fake.breaches) == (1, [])


def test_paused_it_waits_in_the_air_hears_nothing_and_goes_on(arm):
    control, waited = Control(), []

    def watch(place, waits):
        waited.append((place.stroke, waits))
        control.pause = place.stroke == 1 and sum(paused for _, paused in waited) < 5
        if waits:
            until(lambda: not any("/joint_states" in client.subscribed for client in arm.fake._clients))

    fake, place, _ = arm(control, watch)
    assert (fake.breaches, place) == ([], Place(DRAWN))
    assert (1, True) in waited


@pytest.mark.parametrize("halted", [False, True])
def test_interrupted_it_is_told_to_hold_and_lifts_unless_a_service_has_halted_it(arm, monkeypatch, halted):
    held, aborted, states = [], Rosbridge.abort, Rosbridge._state

    def abort(self):
        held.append(aborted(self))
        return held[-1]

    def interrupted(self):
        if self._busy:
            monkeypatch.setattr(Rosbridge, "_state", states)
            raise KeyboardInterrupt
        return states(self)

    def watch(place, waits):
        if place.stroke == 1:
            monkeypatch.setattr(Rosbridge, "_state", interrupted)

    monkeypatch.setattr(Rosbridge, "abort", abort)
    settings = RosbridgeSettings(stop="/halt" if halted else "")
    with pytest.raises(KeyboardInterrupt):
        arm(watch=watch, settings=settings, services=("/halt",))
    assert held == [not halted]
    assert (arm.fake.breaches, arm.fake.stops, arm.fake.called) == ([], 1, ["/halt"] * halted)
    assert len(arm.fake.done) == 1 + 2 + (not halted), "the way there, two strokes, and the lift"
    if not halted:
        rise = 1000 * np.ptp(route().tips(arm.fake.done[-1].q), axis=0)
        assert rise[2] > 30
        assert np.hypot(*rise[:2]) < 0.2 * rise[2]


def test_an_arm_that_goes_on_after_it_was_told_to_stop_is_not_led_anywhere(arm, monkeypatch):
    monkeypatch.setattr("limner.targets.fake_controller.FakeController.put", lambda self, q: None)
    monkeypatch.setattr("limner.targets.rosbridge._REST_S", 1e9)
    with fake_arm() as fake:
        device = driver(fake.port)
        device.open()
        monkeypatch.setattr(Rosbridge, "_arrive", lambda self, motion: 1 / 0)
        with pytest.raises(ZeroDivisionError):
            device.draw(0, lambda: False)
        assert not device.abort()
        device.close()
    assert (len(fake.done), fake.stops) == (1, 1)


def test_a_lost_connection_is_had_again_and_nothing_is_drawn_twice(arm):
    fake, place, journal = arm(fault="drop", motion=1)
    assert (fake.breaches, place, journal.doubtful, fake.connections) == ([], Place(DRAWN), False, 2)
    assert len(fake.done) == 1 + DRAWN + 1


def test_a_connection_lost_while_paused_is_had_again(arm):
    control, waited = Control(), []

    def watch(place, waits):
        waited.append(waits)
        if waits and not control.stop:
            for client in list(arm.fake._clients):
                client.socket.close()
        control.pause = place.stroke == 1 and sum(waited) < 2

    fake, place, _ = arm(control, watch)
    assert (fake.breaches, place, fake.connections) == ([], Place(DRAWN), 2)


def test_an_arm_that_was_moved_meanwhile_is_not_driven_on(arm):
    def watch(place, waits):
        if place.stroke == 1:
            arm.fake.arm.put(arm.fake.q + 0.3)

    with pytest.raises(DeviceFailed, match=r"was moved, it is 17.2 degrees from where"):
        arm(watch=watch)
    assert len(arm.fake.done) == 2


@pytest.mark.parametrize(
    ("fault", "motion", "words", "pen"),
    [
        ("silence", -1, "does not tell where left_arm_1_joint", "unknown"),
        ("silence", 1, "/joint_states is silent", "unknown"),
        ("deaf", 1, "has not moved; does its controller listen", "unknown"),
        ("refuse", 1, "rosbridge refuses: publish: wrong type of message", "unknown"),
        ("nonsense", 1, "says '<html>', which is no JSON", "unknown"),
        ("nan", 1, "nan is no number", "unknown"),
        ("huge", 1, "a message of more than 1 MB came", "unknown"),
        ("astray", 1, "5.7 degrees from where its motion leads", "unknown"),
        ("die", 1, "the connection ended, the arm may go on", "unknown"),
        ("deaf", 1 + DRAWN, "has not moved", "is up"),
    ],
)
def test_what_goes_wrong_is_named_with_the_state_of_the_pen(arm, monkeypatch, fault, motion, words, pen):
    monkeypatch.setattr("limner.targets.rosbridge.SLACK", 1.0)
    with pytest.raises(DeviceFailed) as error:
        arm(fault=fault, motion=motion)
    text = str(error.value)
    assert words in text
    assert ("the pen is up" if pen == "is up" else "pen state unknown") in text
    assert "\n" not in text
    assert arm.fake.breaches == []


def test_who_is_not_there_or_is_no_rosbridge_is_named():
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
    with pytest.raises(DeviceFailed, match=r"nobody listens there; start it with: roslaunch"):
        driver(port).open()
    with pytest.raises(DeviceFailed, match=r"ws://no-such-host.invalid:9090: the connection failed"):
        Bridge("ws://no-such-host.invalid:9090", 5.0).connect()
    web = http.server.HTTPServer(("127.0.0.1", 0), http.server.BaseHTTPRequestHandler)
    web.RequestHandlerClass.log_message = lambda *_: None
    threading.Thread(target=web.serve_forever, daemon=True).start()
    try:
        with pytest.raises(DeviceFailed, match="something else than rosbridge is there"):
            driver(web.server_port).open()
    finally:
        web.shutdown()
        web.server_close()


def test_a_server_that_never_answers_is_given_up():
    with socket.create_server(("127.0.0.1", 0)) as server, pytest.raises(DeviceFailed, match="does not answer"):
        Bridge(f"ws://127.0.0.1:{server.getsockname()[1]}", 0.3).connect()


def test_too_large_a_motion_is_not_sent(monkeypatch):
    monkeypatch.setattr(bridge_module, "LARGEST_OUT", 2000)
    with fake_arm() as fake:
        device = driver(fake.port)
        device.open()
        with pytest.raises(DeviceFailed, match="are sent at once"):
            device.draw(0, lambda: False)
        device.close()
    assert fake.done == []


@pytest.mark.parametrize(
    ("text", "url", "topic"),
    [
        ("rosbridge:ws://arm.local/c/command", "ws://arm.local:9090", "/c/command"),
        ("rosbridge:wss://10.0.0.2:443/c/command", "wss://10.0.0.2:443", "/c/command"),
        ("rosbridge:ws://[::1]:9090/a_1/joint_trajectory", "ws://[::1]:9090", "/a_1/joint_trajectory"),
    ],
)
def test_addresses_are_read(text, url, topic):
    assert parse_bridge(text) == BridgeAddress(url, topic)


@pytest.mark.parametrize(
    "text",
    [
        *("rosbridge:", "rosbridge:ws://", "rosbridge:ws://h", "rosbridge:ws://h/", "rosbridge:http://h/c/command"),
        *("rosbridge:ws://h:x/c", "rosbridge:ws://h:99999/c", "rosbridge:ws://h/c d", "rosbridge:ws://h/1c"),
        *("rosbridge:ws://h/c?x=1", "rosbridge:ws://u:p@h/c", "rosbridge:ws://[::1/c", "rosbridge:h/c", "ws://h/c"),
    ],
)
def test_what_is_no_address_is_refused(text):
    with pytest.raises(BadInput, match=r"expected (rosbridge:ws://|one such as)"):
        parse_bridge(text)


def test_names_of_ros_are_checked():
    for settings in ({"states": "joint states"}, {"states": ""}, {"before": "on"}, {"stop": "/off/"}):
        with pytest.raises(BadInput, match=r"rosbridge\."):
            driver(1, RosbridgeSettings(**settings))


def test_without_websockets_it_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "websockets.exceptions", None)
    with pytest.raises(MissingExtra, match=r"limner\[ros\]"):
        driver(1)


def test_another_client_hears_the_same_motions(arm):
    """roslibpy listens along through the same server: what arrives is what was planned."""
    pytest.importorskip("roslibpy", reason="pip install roslibpy")
    script = Path(__file__).with_name("rosbridge_listener.py")
    with fake_arm() as fake:
        command = [sys.executable, str(script), str(fake.port), TOPIC, "trajectory_msgs/JointTrajectory"]
        with begun(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as listener:
            assert listener.stdout.readline() == "ready\n"
            until(lambda: any(TOPIC in client.subscribed for client in fake._clients))
            device = driver(fake.port)
            device.open()
            assert device.draw(0, lambda: False)
            device.close()
            heard = [json.loads(listener.stdout.readline()) for _ in range(2)]
            listener.stdin.close()
            listener.wait(PATIENCE_S)
    assert fake.breaches == []
    for message, part in zip(heard, (route().to_stroke(robot().pose("safe"), 0), route().stroke(0)), strict=True):
        assert message["joint_names"] == [f"left_arm_{k}_joint" for k in range(1, 8)]
        assert message["header"]["frame_id"] == "arm_base_link"
        assert message["header"]["stamp"] == {"secs": 0, "nsecs": 0}
        t = [p["time_from_start"]["secs"] + 1e-9 * p["time_from_start"]["nsecs"] for p in message["points"]]
        assert t[0] == 0
        assert min(np.diff(t)) > 0
        assert t[-1] == pytest.approx(part.t_s[-1], abs=1e-6)
        for name, values in (("positions", part.q), ("velocities", part.qd), ("accelerations", part.qdd[:, :0])):
            assert np.array_equal([point[name] for point in message["points"]], values)


def test_the_fake_finds_breaches():
    from websockets.sync.client import connect

    def breaches(*messages):
        with fake_arm() as fake, connect(f"ws://127.0.0.1:{fake.port}", proxy=None) as end:
            for message in messages:
                end.send(message if isinstance(message, str) else json.dumps(message))
            until(lambda: fake.breaches or fake.done)
        return " ".join(fake.breaches)

    def motion(q, seconds=1.0, forces=(), **changes):
        still = [0.0] * 7
        stamps = [{"secs": 0, "nsecs": 0}, {"secs": 0, "nsecs": int(5e7 * seconds)}]
        points = [
            {
                "positions": list(p),
                "velocities": still,
                "accelerations": list(forces),
                "effort": [],
                "time_from_start": t,
            }
            for p, t in zip(q, stamps, strict=True)
        ]
        header = {"stamp": {"secs": 0, "nsecs": 0}, "frame_id": ""}
        said = {"header": header, "joint_names": list(robot().joints), "points": points} | changes
        return {"op": "publish", "topic": TOPIC, "msg": said}

    advertise = {"op": "advertise", "topic": TOPIC, "type": "trajectory_msgs/JointTrajectory"}
    still = [0.0] * 7
    safe = robot().pose("safe")
    assert "no operation" in breaches("hello")
    assert "no operation" in breaches({"op": "fly"})
    assert "without msg" in breaches({"op": "publish", "topic": TOPIC})
    assert "advertises a" in breaches(advertise | {"type": "std_msgs/String"})
    assert "without advertising" in breaches(motion([safe, safe]))
    assert "fields" in breaches(advertise, motion([safe, safe], extra=1))
    assert "joints" in breaches(advertise, motion([safe, safe], joint_names=["a"]))
    assert "increase" in breaches(advertise, motion([safe, safe], seconds=0))
    assert "50 ms" in breaches(advertise, motion([safe, safe], seconds=2))
    assert "elsewhere" in breaches(advertise, motion([safe + 0.5, safe + 0.5]))
    assert "leaves" in breaches(advertise, motion([safe, safe + 9]))
    assert "too fast" in breaches(advertise, motion([safe, safe + 0.5]))
    # Between rests 0.05 s apart: 6 times the way over the square of the time by cubics, 5.77 times by quintics.
    most = float(robot().acceleration.min()) * 0.05**2
    for forces, times in (((), 6.0), (still, 10 / 3**0.5)):
        assert "accelerates" in breaches(advertise, motion([safe, safe + 1.05 * most / times], forces=forces))
        assert breaches(advertise, motion([safe, safe + 0.99 * most / times], forces=forces)) == ""
    assert "another size" in breaches(advertise, motion([safe, safe], forces=still[:3]))
    assert "says NaN" in breaches('{"op": "advertise", "topic": NaN, "type": "x"}')


@pytest.fixture
def run(command, monkeypatch, tmp_path):
    monkeypatch.setattr(jobs, "Rosbridge", functools.partial(Rosbridge, silence_s=40.0, clock=arm_clock(PACE)))
    storage.save(planned().trajectory, tmp_path / "m.json")
    motion = planned().trajectory
    fast = {name: getattr(motion, name) for name in ("names", "q", "qd", "qdd", "down", "stroke")}
    storage.save(type(motion)(t_s=motion.t_s / 2, **fast), tmp_path / "fast.json")
    return functools.partial(command, "send")


def test_the_command_draws_on_a_fake(run, tmp_path):
    with fake_arm() as fake:
        to = f"rosbridge:ws://127.0.0.1:{fake.port}{TOPIC}"
        code, out, err = run("m.json", "--robot", "dumbo", "--to", to, "--yes", "--json")
    assert (code, err, fake.breaches) == (0, "", [])
    assert json.loads(out) == {"strokes": DRAWN, "began": 0, "drawn": DRAWN, "finished": True, "journal": None}
    assert not list(tmp_path.glob("*.journal"))


def test_a_command_that_breaks_off_resumes(run, tmp_path):
    with fake_arm(fault="refuse", motion=2) as fake:
        to = f"rosbridge:ws://127.0.0.1:{fake.port}{TOPIC}"
        code, _, err = run("m.json", "--robot", "dumbo", "--to", to, "--yes")
    assert code == 5
    assert re.search(r"pen state unknown.*in stroke 2 of 4, --resume draws that one again", err)
    with fake_arm() as fake:
        to = f"rosbridge:ws://127.0.0.1:{fake.port}{TOPIC}"
        code, out, _ = run("m.json", "--robot", "dumbo", "--to", to, "--yes", "--resume", "--json")
    assert (code, json.loads(out)["began"], len(fake.done)) == (0, 1, DRAWN + 1)


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (["m.json", "--robot", "dumbo", "--to", "rosbridge:ws://127.0.0.1:9/c/command", "--yes"], 5, "nobody listens"),
        (["m.json", "--robot", "dumbo", "--to", "rosbridge:tcp://h/c", "--yes"], 2, "expected rosbridge:ws://"),
        (["m.json", "--to", "rosbridge:ws://h/c", "--yes"], 2, "--robot"),
        (["fast.json", "--robot", "dumbo", "--to", "rosbridge:ws://127.0.0.1:9/c", "--yes"], 4, "over its limit"),
        (["m.json", "--robot", "lwa4d", "--to", "rosbridge:ws://127.0.0.1:9/c", "--yes"], 4, "for the joints"),
        (
            ["m.json", "--robot", "dumbo", "--to", "rosbridge:ws://h/c", "--yes", "--set", "rosbridge.ros=3"],
            *(2, "rosbridge.ros"),
        ),
    ],
)
def test_what_cannot_be_sent_is_said_in_a_line(run, arguments, code, words):
    found, out, err = run(*arguments)
    assert (found, out, err.count("\n")) == (code, "", 1)
    assert words in err
