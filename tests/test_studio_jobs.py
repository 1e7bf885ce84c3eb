"""The one job of the studio: every state and command, seen by all pages, through a killed server, to its end."""

from __future__ import annotations

import asyncio
import threading
import time
import types

import httpx
import numpy as np
import pytest

import studios
from limner.errors import DeviceFailed
from limner.studio import machine
from limner.studio.jobs import Jobs
from limner.studio.orders import Order
from limner.studio.visitors import HeldDrawing
from limner.targets.journal import Place
from limner.types import Drawing, Page, Pen

FEW = {"style": "splines", "page.size": "a6"}
"""Nine lines, a quarter of a minute on a plotter."""

SLOW, FAST = "sim:1", "sim:200"
"""What is to be caught in the middle takes so long that no busy machine comes too late; what need not, no time."""


def photographed(client):
    """The browser, with a drawing of the astronaut in a few lines."""
    client.photo = client.post("/api/photo", content=studios.face_jpeg()).json()["photo"]
    answer = client.post("/api/drawing", json={"photo": client.photo, "settings": FEW})
    assert answer.status_code == 201, answer.text
    client.drawing = answer.json()["drawing"]
    return client


@pytest.fixture(scope="module")
def server():
    with studios.serving() as server:
        yield server


@pytest.fixture(scope="module")
def guest(server):
    with studios.enter(server) as client:
        yield photographed(client)


@pytest.fixture
def idle(guest):
    """A browser, when the machine has nothing to do."""
    yield guest
    settle(guest)


def settle(client):
    """Stop and forget whatever is there."""
    ends = time.monotonic() + studios.PATIENCE_S
    while (job := client.get("/api/job").json())["state"] != "idle":
        assert time.monotonic() < ends, job
        for command in ("clear", "cancel"):
            if command in job["may"] and job["state"] != "cancelling":
                client.post(f"/api/job/{command}")
        time.sleep(0.02)


def until(client, *states):
    """The job, once it is in one of these states."""
    ends = time.monotonic() + studios.PATIENCE_S
    while (job := client.get("/api/job").json())["state"] not in states:
        assert time.monotonic() < ends, job
        assert job["state"] != "error", job["error"]
        time.sleep(0.02)
    return job


def told(client, command, **body):
    return client.post(f"/api/job/{command}", json=body)


def start(client, to=FAST, **more):
    answer = client.post("/api/job", json={"drawing": client.drawing, "to": to} | more)
    assert answer.status_code == 201, answer.text
    return answer.json()


def test_nothing_to_do(idle):
    job = idle.get("/api/job").json()
    assert (job["state"], job["may"]) == ("idle", ["start"])
    for command in ("pause", "resume", "cancel", "clear"):
        answer = told(idle, command)
        assert answer.status_code == 409
        assert "idle" in answer.json()["error"]
    assert told(idle, "dance").status_code == 404


def test_a_job_runs_to_its_end_and_every_page_hears_of_it(server, idle):
    with studios.enter(server) as other, studios.live(other) as talk:
        assert talk.hear(lambda said: said["type"] == "job")[0]["state"] == "idle"
        start(idle)
        heard = [talk.hear(lambda said: said["type"] == "job")[0]]
        while heard[-1]["state"] != "done":
            heard.append(talk.hear(lambda said: said["type"] == "job")[0])
    strokes = [job["stroke"] for job in heard]
    shares = [job["share"] for job in heard]
    assert strokes == sorted(strokes)
    assert shares == sorted(shares)
    assert heard[-1]["share"] == 1
    assert heard[-1]["stroke"] == heard[-1]["strokes"] == 9
    assert not any(job["mine"] or job["drawing"] for job in heard), "it is another's"
    mine = idle.get("/api/job").json()
    assert mine["mine"]
    assert mine["drawing"] == idle.drawing
    assert mine["seconds"] == pytest.approx(mine_report(idle)["seconds"], rel=0.01)


def mine_report(client):
    return client.get("/api/drawings").json()["drawings"][0]["report"]


def test_it_pauses_at_a_lift_and_goes_on(idle):
    start(idle, to=SLOW)
    until(idle, "running")
    assert told(idle, "resume").status_code == 409
    assert told(idle, "pause").json()["state"] == "pausing"
    assert told(idle, "pause").status_code == 409
    paused = until(idle, "paused")
    assert set(paused["may"]) == {"resume", "cancel"}
    time.sleep(0.3)
    still = idle.get("/api/job").json()
    assert (still["state"], still["stroke"]) == ("paused", paused["stroke"])
    assert told(idle, "resume").json()["state"] == "running"
    told(idle, "cancel")
    until(idle, "cancelled")


def test_a_pause_can_be_taken_back(idle):
    start(idle, to=SLOW)
    until(idle, "running")
    told(idle, "pause")
    assert told(idle, "resume").json()["state"] == "running"


@pytest.mark.slow
def test_it_waits_for_each_next_pen_and_names_it(idle):
    settings = {"style": "cartoon", "cartoon.pens": 3, "page.size": "a6", "order.kicks": 0}
    kept = idle.post("/api/drawing", json={"photo": idle.photo, "settings": settings}).json()
    pens = [pen["name"] for pen in kept["report"]["pens"]]
    assert len(pens) > 1
    assert start(idle, drawing=kept["drawing"], to="sim:1000")["next_pen"] == ""
    for pen in pens[1:]:
        paused = until(idle, "paused")
        assert paused["next_pen"] == pen
        assert pen in paused["said"]
        assert told(idle, "resume").json()["next_pen"] == ""
        until(idle, "running", "done", "paused")
    assert until(idle, "done")["next_pen"] == ""


def test_only_one_job_at_a_time(server, idle):
    with studios.enter(server) as other:
        photographed(other)
        start(idle, to=SLOW)
        answer = other.post("/api/job", json={"drawing": other.drawing, "to": "sim:"})
        assert answer.status_code == 409
        assert "possible" in answer.json()["error"]


def drawn(client, strokes):
    """The job, once so many strokes are drawn."""
    ends = time.monotonic() + studios.PATIENCE_S
    while (job := client.get("/api/job").json())["stroke"] < strokes:
        assert time.monotonic() < ends, job
        time.sleep(0.01)
    return job


def test_stopped_it_goes_on_where_it_was(server, idle):
    start(idle, to=SLOW)
    drawn(idle, 3)
    told(idle, "cancel")
    stopped = until(idle, "cancelled")
    assert 3 <= stopped["stroke"] < 9
    assert {"resume", "start", "clear"} == set(stopped["may"])
    server.hurry(FAST)
    told(idle, "resume")
    seen = until(idle, "running", "done")
    assert seen["stroke"] >= stopped["stroke"]
    assert until(idle, "done")["stroke"] == 9


def test_another_page_of_the_same_browser_may_stop_it(server, idle):
    start(idle, to=SLOW)
    with studios.enter(server) as other:
        assert told(other, "cancel").status_code == 200
    until(idle, "cancelled")


def test_a_dry_run_goes_round_the_frame(idle):
    start(idle, frame_only=True)
    done = until(idle, "done")
    assert done["frame_only"]
    assert done["strokes"] == 1


@pytest.mark.parametrize("to", ["fake:", "fake:ebb", "grbl:/dev/no-such-port"])
def test_other_machines_than_simulated_ones(idle, to):
    pytest.importorskip("serial")
    start(idle, to=to)
    job = until(idle, "done", "error")
    assert (job["state"] == "error") == to.startswith("grbl")
    if job["error"]:
        assert "no such port" in job["error"]
        assert "--resume" not in job["error"]
        assert told(idle, "clear").json()["state"] == "idle"


WRONG = [
    ({"to": "sim:"}, 404, "no such drawing"),
    ({"drawing": True}, 400, "address"),
    ({"drawing": True, "to": "sim:fast"}, 0, "sim:20"),
    ({"drawing": True, "to": "gold:"}, 0, "expected"),
    ({"drawing": True, "to": "sim:", "machine": "/etc/passwd.toml"}, 400, "machine"),
    ({"drawing": True, "to": "sim:", "machine": "gold"}, 0, "no machine"),
    ({"drawing": True, "to": "sim:", "robot": "../evil.urdf"}, 400, "robot"),
    ({"drawing": True, "to": "sim:", "robot": "gold"}, 400, "not known"),
]


@pytest.mark.parametrize(("body", "status", "words"), WRONG)
def test_what_cannot_be_started_says_why(idle, body, status, words):
    given = body | ({"drawing": idle.drawing} if "drawing" in body else {})
    checked = idle.post("/api/job/check", json=given)
    assert checked.status_code == (status or 400)
    assert words in checked.json()["error"]
    answer = idle.post("/api/job", json=given)
    if status:
        assert answer.status_code == status
        assert idle.get("/api/job").json()["state"] == "idle"
    else:
        assert words in until(idle, "error")["error"]


def test_the_checklist_moves_nothing(idle):
    answer = idle.post("/api/job/check", json={"drawing": idle.drawing, "to": "sim:", "machine": "grbl"}).json()
    assert answer["strokes"] == 9
    assert answer["name"] == "grbl"
    assert answer["ask"]
    assert "pen" in answer["ready"]
    assert idle.get("/api/job").json()["state"] == "idle"


def test_a_bare_serial_port_is_called_one(monkeypatch):
    found = [
        ("/dev/ttyS0", "n/a", False),
        ("/dev/ttyUSB0", "USB2.0-Serial", False),
        ("/dev/ttyACM0", "EiBotBoard", True),
    ]
    monkeypatch.setattr("limner.targets.serial_link.ports", lambda: found)
    told = {target["address"]: target["help"] for target in machine._ports()}
    assert told["grbl:/dev/ttyUSB0"] == "USB2.0-Serial"
    assert told["ebb:/dev/ttyACM0"] == "EiBotBoard"
    assert "does not say" in told["grbl:/dev/ttyS0"]


def test_simulators_are_always_there(idle):
    targets = idle.get("/api/targets").json()["targets"]
    assert {("sim:", "plotter"), ("sim:", "arm")} <= {(item["address"], item["kind"]) for item in targets}


def killed_in_mid_job(state):
    """A server killed while its machine draws; how far it said it was, its visitor's cookie, its port."""
    server = studios.Server(state=state)
    try:
        with studios.enter(server) as client:
            photographed(client)
            start(client, to=SLOW)
            job = drawn(client, 3)
            server.kill()
            server.hurry(FAST)
            return job["stroke"], dict(client.cookies), server.port
    finally:
        server.close()


def test_killed_in_mid_job_it_is_there_again_and_goes_on(tmp_path):
    before, _, _ = killed_in_mid_job(tmp_path)
    with studios.serving(state=tmp_path) as server, studios.enter(server) as client:
        job = client.get("/api/job").json()
        assert job["state"] == "interrupted"
        assert before <= job["stroke"] < 9
        assert job["strokes"] == 9
        assert {"resume", "start", "clear"} == set(job["may"])
        assert told(client, "resume").status_code == 200
        on = until(client, "running", "done")
        assert on["stroke"] >= before
        assert until(client, "done")["stroke"] == 9
    assert not list(tmp_path.rglob("*.npz")), "nothing is left of a job that is done"


@pytest.mark.slow
def test_whose_job_was_interrupted_is_known_by_his_cookie_and_nobody_else_is(tmp_path):
    _, cookies, port = killed_in_mid_job(tmp_path)
    assert not any(
        cookie in path.read_text("latin-1") for path in tmp_path.rglob("*.json") for cookie in cookies.values()
    )
    with studios.serving("--port", port, state=tmp_path) as server:
        how = {"base_url": server.base, "headers": {"origin": server.base}, "timeout": studios.PATIENCE_S}
        owner = httpx.Client(cookies=cookies, **how)
        wrong = {name: "x" + cookie[1:] for name, cookie in cookies.items()}
        stranger = httpx.Client(cookies=wrong, **how)
        with owner, stranger, studios.enter(server) as other:
            assert stranger.get("/api/job").status_code == 401
            assert not other.get("/api/job").json()["mine"]
            job = owner.get("/api/job").json()
            assert job["mine"]
            assert owner.get(f"/api/drawing/{job['drawing']}.lines").content[:1] == b"\x01"
            assert other.get(f"/api/drawing/{job['drawing']}.lines").status_code == 404
            assert told(owner, "clear").json()["state"] == "idle"


@pytest.mark.slow
def test_what_was_left_behind_can_be_forgotten(tmp_path):
    killed_in_mid_job(tmp_path)
    with studios.serving(state=tmp_path) as server, studios.enter(server) as client:
        assert told(client, "clear").json()["state"] == "idle"
        assert not list(tmp_path.rglob("*.npz"))
    (tmp_path / "limner" / "studio" / "job").mkdir(parents=True)
    (tmp_path / "limner" / "studio" / "job" / "order.json").write_text("{")
    with studios.serving(state=tmp_path) as server, studios.enter(server) as client:
        assert client.get("/api/job").json()["state"] == "idle"


@pytest.mark.slow
def test_two_studios_have_a_job_each(tmp_path):
    with (
        studios.serving(state=tmp_path, own_port=False) as one,
        studios.serving(state=tmp_path, own_port=False) as two,
        studios.enter(one) as first,
        studios.enter(two) as second,
    ):
        assert one.port != two.port
        start(photographed(first), to=SLOW)
        assert second.get("/api/job").json()["state"] == "idle"


@pytest.mark.slow
def test_ended_in_mid_job_the_pen_goes_up_and_the_job_stays(tmp_path):
    with studios.serving(state=tmp_path) as server, studios.enter(server) as client:
        start(photographed(client), to=SLOW)
        until(client, "running")
    with studios.serving(state=tmp_path) as server, studios.enter(server) as client:
        assert client.get("/api/job").json()["state"] == "interrupted"


@pytest.mark.slow
def test_a_simulated_arm_draws_it(idle):
    pytest.importorskip("mujoco")
    pytest.importorskip("urdf_parser_py")
    start(idle, to="sim:1000", robot="ur5e")
    done = until(idle, "done", "error")
    assert done["state"] == "done", done["error"]
    assert done["stroke"] == 9
    start(idle, to="sim:1000", robot="ur5e", frame_only=True)
    done = until(idle, "done", "error")
    assert done["state"] == "done", done["error"]


class Lingering(Jobs):
    """Its thread stays a little after it has told its last, as on a busy machine."""

    let_go = threading.Event()

    def _post(self, call, *arguments):
        super()._post(call, *arguments)
        if call in (self._ended, self._failed):
            self.let_go.wait(studios.PATIENCE_S)


@pytest.mark.parametrize("ends", ["done", "error"])
def test_a_job_that_is_over_can_be_put_away_at_once(tmp_path, ends):
    drawing = Drawing((np.array([(0.0, 0.0), (1.0, 1.0)]),), ("eye",), np.ones(1), Page(20, 20, 1), (Pen(),))

    def run(journal, control, watch):
        if ends == "error":
            raise DeviceFailed("no more ink")
        return Place(1)

    made = types.SimpleNamespace(drawing=drawing, begins_s=[0.0], seconds=1.0, name="it", run=run)

    async def job():
        over = asyncio.Event()
        jobs = Lingering(tmp_path / "job", lambda order, file: made, lambda: jobs.busy or over.set())
        jobs.start(Order("sim:"), b"", HeldDrawing("a", "b", b"", {}), None)
        await over.wait()
        assert jobs.status.state == ends
        jobs.clear()
        assert jobs.status.state == "idle"
        jobs.let_go.set()

    asyncio.run(job())
