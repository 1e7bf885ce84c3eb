"""The booth: guests queue, one operator commands, and nobody else does."""

from __future__ import annotations

import asyncio
import functools
import time

import pytest

import studios
from limner.errors import CannotDraw
from limner.studio.orders import Status, WrongState
from limner.studio.queue import Goal, Queue
from limner.studio.visitors import HeldDrawing, Visitor

FEW = {"style": "splines", "page.size": "a6"}


@pytest.fixture(scope="module")
def server():
    with studios.serving("--booth") as server:
        yield server


@pytest.fixture
def operator(server):
    with studios.enter(server, server.said["operator_url"]) as client:
        yield client
        command(client, "hold")
        for entry in client.get("/api/operator/queue").json()["queue"]:
            if entry["state"] == "drawing":
                command(client, "skip")
        until(client, lambda told: told["job"]["state"] in ("idle", "done", "cancelled", "error"))
        for entry in client.get("/api/operator/queue").json()["queue"]:
            client.post("/api/operator/remove", json={"entry": entry["entry"]})


@pytest.fixture
def guest(server):
    with studios.enter(server) as client:
        yield arrived(client)


def arrived(client):
    client.photo = client.post("/api/photo", content=studios.face_jpeg()).json()["photo"]
    client.drawing = client.post("/api/drawing", json={"photo": client.photo, "settings": FEW}).json()["drawing"]
    return client


def queued(client, name="Ada"):
    answer = client.post("/api/queue", json={"drawing": client.drawing, "name": name})
    assert answer.status_code == 201, answer.text
    return answer.json()["entry"]


def command(operator, name, **body):
    return operator.post(f"/api/operator/{name}", json=body)


def until(operator, right):
    ends = time.monotonic() + studios.PATIENCE_S
    while not right(told := operator.get("/api/operator/queue").json()):
        assert time.monotonic() < ends, told
        time.sleep(0.03)
    return told


def states(told):
    return [entry["state"] for entry in told["queue"]]


def test_a_guest_queues_and_commands_nothing(guest, operator):
    entry = queued(guest)
    (seen,) = guest.get("/api/queue").json()["queue"]
    assert (seen["entry"], seen["name"], seen["state"], seen["place"], seen["mine"]) == (
        entry,
        "Ada",
        "waiting",
        1,
        True,
    )
    assert seen["left_s"] > 5
    assert guest.post("/api/job", json={"drawing": guest.drawing, "to": "sim:"}).status_code == 403
    for name in ("pause", "resume", "cancel", "clear"):
        assert guest.post(f"/api/job/{name}").status_code == 403
        assert guest.post(f"/api/operator/{name}").status_code == 401
    assert guest.get("/api/operator/queue").status_code == 401
    assert guest.get("/api/booth").json()["candidates"] == 3
    assert operator.get("/").status_code == 401


def test_the_operator_begins_each_and_the_guest_hears_of_it(guest, operator):
    command(operator, "target", to="sim:100")
    queued(guest)
    with studios.live(guest) as talk:
        told = command(operator, "next").json()
        assert states(told) == ["drawing"]
        assert command(operator, "next").status_code == 409
        done, _ = talk.hear(lambda said: said["type"] == "queue" and said["queue"][0]["state"] == "done")
        assert done["queue"][0]["mine"]
    assert command(operator, "next").status_code == 409


def test_released_the_queue_draws_itself(guest, operator):
    command(operator, "target", to="sim:200", machine="grbl")
    for name in ("Ada", "Ben", "Cy"):
        queued(guest, name)
    assert states(operator.get("/api/operator/queue").json()) == ["waiting"] * 3
    command(operator, "release")
    told = until(operator, lambda told: set(states(told)) == {"done"})
    assert [entry["name"] for entry in told["queue"]] == ["Ada", "Ben", "Cy"]


def test_the_operator_pauses_skips_and_removes(guest, operator):
    command(operator, "target", to="sim:1")
    first, second, third = (queued(guest, name) for name in ("Ada", "Ben", "Cy"))
    command(operator, "next")
    until(operator, lambda told: told["job"]["state"] == "running")
    assert command(operator, "pause").json()["job"]["state"] == "pausing"
    assert command(operator, "resume").json()["job"]["state"] == "running"
    assert operator.post("/api/operator/remove", json={"entry": first}).status_code == 409
    command(operator, "skip")
    told = until(operator, lambda told: told["job"]["state"] == "cancelled")
    assert states(told) == ["skipped", "waiting", "waiting"]
    told = operator.post("/api/operator/remove", json={"entry": second}).json()
    assert [entry["entry"] for entry in told["queue"]] == [first, third]
    lines = operator.get(f"/api/operator/drawing/{third}.lines")
    assert lines.content[:1] == b"\x01"
    command(operator, "skip")
    assert command(operator, "skip").status_code == 409


def test_only_ones_own_is_taken_back(server, guest, operator):
    entry = queued(guest)
    with studios.enter(server) as other:
        assert other.delete(f"/api/queue/{entry}").status_code == 404
        seen = other.get("/api/queue").json()["queue"]
        assert not seen[0]["mine"]
    assert guest.delete(f"/api/queue/{entry}").status_code == 204
    assert guest.get("/api/queue").json()["queue"] == []


def test_a_guest_cannot_fill_the_queue(guest, operator):
    for _ in range(3):
        queued(guest)
    answer = guest.post("/api/queue", json={"drawing": guest.drawing})
    assert answer.status_code == 422
    assert "wait already" in answer.json()["error"]
    for name in ("x" * 41, "a\nb", 7):
        assert guest.post("/api/queue", json={"drawing": guest.drawing, "name": name}).status_code == 400


def test_who_leaves_is_forgotten_but_what_he_queued_is_drawn(guest, operator):
    command(operator, "target", to="sim:200")
    queued(guest)
    assert guest.post("/api/leave").status_code == 204
    assert guest.get(f"/api/photo/{guest.photo}.jpg").status_code == 404
    assert guest.get("/api/drawings").json() == {"drawings": []}
    command(operator, "next")
    until(operator, lambda told: states(told) == ["done"])


def test_the_operators_page_hears_too(operator, guest):
    queued(guest)
    base = str(operator.base_url).rstrip("/")
    with studios.live(operator, path="/ws/operator") as talk:
        assert talk.hear(lambda said: said["type"] == "queue")[0]["queue"][0]["name"] == "Ada"
    assert studios.refused(guest, base, "/ws/operator")


@pytest.mark.slow
def test_a_studio_that_is_no_booth_has_no_queue():
    with studios.serving() as server, studios.enter(server) as client:
        assert client.get("/api/queue").status_code == 404
        assert client.get("/api/operator/queue").status_code == 401
        assert client.get("/operator").status_code == 401


class Machine:
    """Stands in for the jobs of a server: says what a test lets it say."""

    def __init__(self):
        self.status, self.may, self.drawn = Status(), ("start",), []

    def check(self, command):
        pass

    def start(self, order, data, held, owner):
        self.drawn.append(held)
        self.status = Status("running")


class Preparing:
    """Takes as long as a test lets it take to prepare a drawing, and cannot draw one that is called impossible."""

    def __init__(self):
        self.on = asyncio.Event()

    async def __call__(self, held, order):
        await self.on.wait()
        if held.name == "impossible":
            raise CannotDraw("out of reach")
        return b""


def line_of(*names):
    """A queue with a drawing of each name, its machine, and what prepares."""
    machine, preparing = Machine(), Preparing()
    line = Queue(machine, preparing, lambda: None)
    line.goal = Goal("grbl:")
    for name in names:
        line.add(Visitor(), HeldDrawing(name, "", b"", {"settings": {}}), name)
    return line, machine, preparing


def in_a_loop(test):
    """A test that waits for nothing but what it does itself."""

    @functools.wraps(test)
    def run(**given):
        asyncio.run(test(**given))

    return run


async def let_run():
    """Everything that can go on without waiting does."""
    for _ in range(20):
        await asyncio.sleep(0)


@in_a_loop
async def test_what_is_skipped_while_it_is_prepared_is_not_drawn():
    line, machine, preparing = line_of("a", "b")
    beginning = asyncio.ensure_future(line.next())
    await let_run()
    line.skip()
    preparing.on.set()
    with pytest.raises(WrongState):
        await beginning
    assert machine.drawn == []
    assert [entry.state for entry in line.entries] == ["skipped", "waiting"]


@pytest.mark.parametrize("before", ["done", "idle"])
@in_a_loop
async def test_what_is_prepared_is_not_done_because_the_one_before_is(before):
    line, machine, preparing = line_of("a")
    beginning = asyncio.ensure_future(line.next())
    await let_run()
    machine.status = Status(before)
    line.job_changed()
    assert line.entries[0].state == "drawing"
    preparing.on.set()
    await beginning
    machine.status = Status("done")
    line.job_changed()
    assert line.entries[0].state == "done"


@in_a_loop
async def test_a_released_queue_passes_over_what_cannot_be_drawn():
    line, machine, preparing = line_of("impossible", "impossible", "a", "b")
    preparing.on.set()
    line.hold(False)
    await let_run()
    assert [held.name for held in machine.drawn] == ["a"]
    assert [entry.state for entry in line.entries] == ["skipped", "skipped", "drawing", "waiting"]
