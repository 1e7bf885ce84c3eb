"""The studio's server, started as a stranger starts it: photos in, drawings out, and nothing that breaks it."""

from __future__ import annotations

import asyncio
import io
import json
import os
import signal
import socket
import struct
import subprocess
import sys
import time
from pathlib import Path

import httpx
import numpy as np
import pytest
from PIL import Image
from starlette.websockets import WebSocketDisconnect

import studios
from limner.errors import CannotDraw
from limner.studio.computer import Computer
from limner.studio.hub import Hub
from limner.studio.talk import talk
from limner.studio.visitors import Visitor
from limner.types import REGIONS


@pytest.fixture(scope="module")
def server():
    with studios.serving() as server:
        yield server


@pytest.fixture
def client(server):
    with studios.enter(server) as client:
        yield client


@pytest.fixture(scope="module")
def guest(server):
    """A browser with a photo of a face."""
    with studios.enter(server) as client:
        answer = client.post("/api/photo", content=studios.face_jpeg())
        assert answer.status_code == 200, answer.text
        yield client, answer.json()


def unpacked(frame):
    """Lines [mm] and regions of a frame, read by the table in docs/studio-protocol.md."""
    kind, rev, lines, points, unit = struct.unpack_from("<BxxxIIIf", frame)
    assert kind == 1
    ends = np.frombuffer(frame, "<u4", lines + 1, 24)
    places = np.frombuffer(frame, "<i2", 2 * points, 24 + 4 * (lines + 1)).reshape(-1, 2) * unit
    regions, pens = np.split(np.frombuffer(frame, "u1", 2 * lines, 24 + 4 * (lines + 1) + 4 * points), 2)
    assert len(frame) == 24 + 4 * (lines + 1) + 4 * points + 2 * lines
    assert not pens.any()
    return rev, np.split(places, ends[1:-1]), [REGIONS[region] for region in regions]


def test_a_photo_is_looked_at_and_shown(guest):
    client, photo = guest
    assert (photo["width"], photo["height"]) == (400, 400)
    (face,) = photo["faces"]
    assert np.shape(face["points_px"]) == (68, 2)
    shown = client.get(f"/api/photo/{photo['photo']}.jpg")
    assert shown.headers["content-type"] == "image/jpeg"
    assert shown.content[:2] == b"\xff\xd8"


def test_a_wish_gives_a_draft_then_the_drawing(guest):
    client, photo = guest
    with studios.live(client) as talk:
        talk.wish(rev=7, photo=photo["photo"], settings={"page.size": "a6"})
        draft, _ = talk.hear()
        final, frame = talk.hear()
    assert (draft["type"], draft["final"], final["type"], final["final"]) == ("preview", False, "preview", True)
    report = final["report"]
    rev, lines, regions = unpacked(frame)
    assert rev == final["rev"] == 7
    assert len(lines) == report["strokes"] > 10
    assert sum(map(len, lines)) == report["points"]
    assert "eye" in regions
    assert report["page"] == {"width_mm": 105.0, "height_mm": 148.0, "margin_mm": 10.0}
    places = np.concatenate(lines)
    assert places.min() > 9
    assert (places < [96, 139]).all()
    ink = sum(np.hypot(*np.diff(line, axis=0).T).sum() for line in lines)
    assert ink == pytest.approx(report["ink_mm"], rel=0.01)
    assert 0 < report["likeness"] <= 1
    # The eyes of the photo fall on the eyes of the page.
    affine = np.array(report["page_from_photo"])
    eyes = np.array(report["points_px"])[36:48] @ affine[:, :2].T + affine[:, 2]
    drawn = np.concatenate([line for line, region in zip(lines, regions, strict=True) if region == "eye"])
    assert np.hypot(*(drawn.mean(0) - eyes.mean(0))) < 8


def test_the_same_wish_gives_the_same_bytes(guest):
    client, photo = guest
    frames = []
    for _ in range(2):
        with studios.live(client) as talk:
            talk.wish(rev=3, photo=photo["photo"], settings={"style": "splines"})
            frames.append(talk.hear(lambda said: said.get("final"))[1])
    assert frames[0] == frames[1]


def test_candidates_come_one_by_one_and_stop_for_something_newer(guest):
    client, photo = guest
    with studios.live(client) as talk:
        talk.wish(rev=1, photo=photo["photo"], want=["preview", "candidates"])
        first, _ = talk.hear(lambda said: said["type"] == "candidate")
        assert first["rev"] == 1
        assert first["place"] == 0
        talk.wish(rev=2, photo=photo["photo"], settings={"style": "splines"}, want=["preview", "candidates"])
        talk.hear(lambda said: said.get("rev") == 2)
        seen = []
        while len(seen) < 5:
            message, frame = talk.hear(lambda said: said["type"] == "candidate")
            assert message["rev"] == 2
            assert message["place"] == len(seen)
            # It is the same whichever is chosen now.
            assert message["settings"].keys() == {"style", "refine"}
            assert len(unpacked(frame)[1]) == message["report"]["strokes"]
            seen.append(message["name"])
    assert len(set(seen)) == 5 < first["of"]


def test_the_latest_wish_is_always_answered(guest):
    client, photo = guest
    with studios.live(client) as talk:
        for rev in range(1, 40):
            talk.wish(rev=rev, photo=photo["photo"], settings={"select.points": 100 + 5 * rev})
        final, _ = talk.hear(lambda said: said.get("final") and said["rev"] == 39)
    assert final["report"]["points"] <= 295


def test_landmarks_placed_by_hand_are_drawn_from(guest):
    client, photo = guest
    placed = client.post(f"/api/photo/{photo['photo']}/face", json={"box_px": [100, 120, 300, 330]}).json()["face"]
    points = np.array(placed["points_px"])
    assert points[:, 0].min() >= 99
    assert points[:, 0].max() <= 301
    assert points[36:48, 1].mean() < points[48:68, 1].mean()
    assert points[36, 0] < points[45, 0]
    with studios.live(client) as talk:
        talk.wish(rev=1, photo=photo["photo"], points_px=points.tolist(), settings={"style": "splines"})
        final, _ = talk.hear(lambda said: said.get("final"))
    assert np.allclose(final["report"]["points_px"], points)


WRONG_WISHES = [
    ("{", "JSON"),
    ("[]", "JSON object"),
    ('{"rev": -1, "photo": "x"}', "rev"),
    ('{"rev": 1}', "photo"),
    ('{"rev": 1, "photo": "x", "want": ["gold"]}', "want"),
    ('{"rev": 1, "photo": "x", "face": "first"}', "face"),
    ('{"rev": 1, "photo": "x"}', "no such photo"),
]


@pytest.mark.parametrize(("text", "words"), WRONG_WISHES)
def test_a_wrong_wish_gets_one_line(client, text, words):
    with studios.live(client) as talk:
        talk.socket.send(text)
        said, _ = talk.hear()
    assert said["type"] == "error"
    assert words in said["error"]
    assert "\n" not in said["error"]


WRONG_SETTINGS = [
    ({"gold": 1}, "does not exist"),
    ({"gabor": 1}, "does not exist"),
    ({"portrait.detail": "much"}, "expected a number"),
    ({"portrait.detail": 1e9}, "0.1 to 10"),
    ({"detect.file": "/etc/passwd"}, "file of this computer"),
    ({"detect.detector": "file"}, "file of this computer"),
    ({"refinement.shape.model": "/etc/passwd"}, "file of this computer"),
    ({"machine": "/etc/passwd.toml"}, "choose axidraw"),
    ({"page.size": "1e9x1e9"}, "page"),
]


@pytest.mark.parametrize(("settings", "words"), WRONG_SETTINGS)
def test_a_wrong_setting_gets_one_line_and_no_file_is_read(guest, settings, words):
    client, photo = guest
    with studios.live(client) as talk:
        talk.wish(rev=5, photo=photo["photo"], settings=settings)
        said, _ = talk.hear()
    assert said["type"] == "error"
    assert said["rev"] == 5
    assert words in said["error"]


UPLOADS = {
    "empty": (b"", 400),
    "text": (b"hello, I am no picture\n" * 100, 400),
    "cut short": (studios.face_jpeg()[:3000], 400),
    "svg": (b'<svg xmlns="http://www.w3.org/2000/svg"><script>alert(1)</script></svg>', 400),
    "zip": (b"PK\x03\x04" + bytes(200), 400),
    "gif that moves": (studios.moving("GIF"), 400),
    "png that moves": (studios.moving("PNG"), 400),
    "webp that moves": (studios.moving("WEBP"), 400),
    "huge": (b"\x89PNG\r\n\x1a\n" + b"\x00\x00\x00\rIHDR" + struct.pack(">II", 60_000, 60_000) + bytes(40), 400),
    "long": (bytes(41 * 2**20), 413),
}


@pytest.mark.parametrize("name", UPLOADS)
def test_what_is_no_photo_is_refused_in_one_line(client, name):
    data, status = UPLOADS[name]
    answer = client.post("/api/photo", content=data)
    assert answer.status_code == status
    assert list(answer.json()) == ["error"]
    assert "\n" not in answer.json()["error"]


def test_a_length_that_lies_does_not_help(server, client):
    def endless():
        for _ in range(60):
            yield bytes(2**20)

    try:
        status = client.post("/api/photo", content=endless()).status_code
    except httpx.TransportError:
        status = 413  # the server hung up while it was still being told
    assert status == 413
    assert client.get("/api/options").status_code == 200


def test_no_face_is_told_and_landmarks_can_be_placed(client):
    answer = client.post("/api/photo", content=studios.picture(size=(200, 240)))
    assert answer.status_code == 200
    about = answer.json()
    assert about["faces"] == []
    assert "no face" in about["error"].lower()
    placed = client.post(f"/api/photo/{about['photo']}/face", json={"box_px": [40, 40, 160, 200]})
    assert placed.status_code == 200
    assert client.post(f"/api/photo/{about['photo']}/face", json={"index": 0}).status_code == 400
    assert client.post(f"/api/photo/{about['photo']}/face", content=b"{").status_code == 400


def test_a_long_file_is_kept_small_and_drawn_the_same_by_another_process(server, client):
    out = io.BytesIO()
    with Image.open(io.BytesIO(studios.face_jpeg(1500))) as face:
        face.save(out, "BMP")
    assert len(out.getvalue()) > 6e6
    photo = client.post("/api/photo", content=out.getvalue()).json()["photo"]
    frames = []
    with studios.live(client) as talk:
        for rev in (1, 1):
            talk.wish(rev=rev, photo=photo, settings={"style": "splines"})
            frames.append(talk.hear(lambda said: said.get("final"))[1])
            for pid in computing(server):
                os.kill(pid, signal.SIGKILL)
    assert frames[0] == frames[1]


def test_two_people_do_not_see_each_others_photos(server, guest):
    _, photo = guest
    with studios.enter(server) as other:
        assert other.get(f"/api/photo/{photo['photo']}.jpg").status_code == 404
        with studios.live(other) as talk:
            talk.wish(rev=1, photo=photo["photo"])
            assert "no such photo" in talk.hear()[0]["error"]


def test_a_photo_that_is_let_go_is_gone(client):
    name = client.post("/api/photo", content=studios.picture()).json()["photo"]
    assert client.delete(f"/api/photo/{name}").status_code == 204
    assert client.get(f"/api/photo/{name}.jpg").status_code == 404


def test_only_the_latest_photos_are_held(client):
    names = [client.post("/api/photo", content=studios.picture()).json()["photo"] for _ in range(8)]
    held = [client.get(f"/api/photo/{name}.jpg").status_code == 200 for name in names]
    assert held == [False] * 2 + [True] * 6


def test_the_menu_holds_every_setting_but_files(client):
    menu = client.get("/api/options").json()
    settings = {item["path"]: item for item in menu["settings"]}
    assert settings["portrait.detail"]["default"] == 1.0
    assert settings["select.minutes"]["type"] == "float?"
    assert "detect.file" not in settings
    for slider in menu["sliders"]:
        for item in slider["sets"]:
            about = settings[item["path"]]
            for value in item.get("steps") or [stop[1] for stop in item["stops"]]:
                assert about["low"] is None or about["low"] <= value <= about["high"]
                assert not about["choices"] or value in about["choices"]
            if "stops" in item:
                middle = dict(map(tuple, item["stops"]))[slider["default"]]
                assert middle == about["default"]
    for preset in menu["presets"]:
        assert set(preset["settings"]) <= set(settings)


def computing(server):
    """Process ids of the server's children that compute."""
    tasks = Path(f"/proc/{server.pid}/task").glob("*/children")
    children = {int(child) for path in tasks for child in read(path).split()}
    return {pid for pid in children if b"spawn_main" in read(Path(f"/proc/{pid}/cmdline"))}


def read(path):
    """A file of a process; nothing when it has just ended."""
    try:
        return path.read_bytes()
    except OSError:
        return b""


def test_a_killed_computing_process_is_replaced(guest, server):
    client, photo = guest
    # For what is slow there may be a second one.
    before = computing(server)
    assert before
    for pid in before:
        os.kill(pid, signal.SIGKILL)
    with studios.live(client) as talk:
        talk.wish(rev=1, photo=photo["photo"], settings={"style": "canny"})
        final, _ = talk.hear(lambda said: said.get("final"))
    assert final["report"]["strokes"] > 5
    (after,) = computing(server)
    assert after not in before


def test_it_ends_cleanly_and_so_does_its_computing(tmp_path):
    server = studios.Server(cwd=tmp_path)
    with studios.enter(server) as client:
        client.post("/api/photo", content=studios.picture())
        children = computing(server)
        code, err = server.close()
    assert code == 0
    assert "Traceback" not in err
    assert list(tmp_path.iterdir()) == []
    ends = time.monotonic() + studios.PATIENCE_S
    while any(os.path.exists(f"/proc/{pid}") for pid in children) and time.monotonic() < ends:
        time.sleep(0.05)
    assert not any(os.path.exists(f"/proc/{pid}") for pid in children)


def run(*arguments):
    command = [sys.executable, "-m", "limner", "studio", "--no-browser", *arguments]
    return subprocess.run(command, capture_output=True, text=True, timeout=studios.PATIENCE_S)


def test_a_port_in_use_is_one_clear_line():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        ran = run("--port", str(taken.getsockname()[1]))
    assert ran.returncode == 2
    assert "in use" in ran.stderr
    assert len(ran.stderr.splitlines()) == 1


def test_a_host_that_is_none_is_one_clear_line():
    ran = run("--host", "203.0.113.7")
    assert ran.returncode == 2
    assert "--host 203.0.113.7" in ran.stderr
    assert len(ran.stderr.splitlines()) == 1


def test_listening_to_the_network_is_warned_of():
    with studios.serving("--host", "0.0.0.0") as server:
        _, err = server.close()
    assert "warning" in err


def test_a_booth_has_an_operator_with_a_token_of_his_own():
    with studios.serving("--booth") as server:
        operator = server.said["operator_url"]
        assert operator.startswith(server.base + "/operator?token=")
        assert operator.rpartition("=")[2] != server.url.rpartition("=")[2]


def test_without_the_extra_it_says_how_to_get_it(tmp_path):
    (tmp_path / "uvicorn.py").write_text("raise ImportError('not installed')\n")
    ran = subprocess.run(
        [sys.executable, "-m", "limner", "studio", "--no-browser"],
        capture_output=True,
        text=True,
        env=os.environ | {"PYTHONPATH": os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")])},
        timeout=studios.PATIENCE_S,
    )
    assert ran.returncode == 2
    assert "limner[studio]" in ran.stderr
    assert json.dumps("Traceback") not in ran.stderr


class SlowSocket:
    """A page that takes what it is sent slowly, and wishes for something else meanwhile."""

    def __init__(self, wishes):
        self.scope = {"visitor": Visitor()}
        self.wishes, self.heard = list(wishes), []

    async def accept(self):
        pass

    async def receive_text(self):
        for _ in range(3 * len(self.wishes) % 40):
            await asyncio.sleep(0)
        if not self.wishes:
            raise WebSocketDisconnect
        return json.dumps(self.wishes.pop(0))

    async def send_text(self, text):
        for _ in range(5):
            await asyncio.sleep(0)
        self.heard.append(json.loads(text)["rev"])

    async def send_bytes(self, data):
        for _ in range(5):
            await asyncio.sleep(0)
        self.heard.append(data)


class QuickStudio:
    """Has drawn everything before it is asked."""

    hub = Hub()

    async def compute(self, visitor, task, wish, urgency, **more):
        return {"report": {}, "frame": wish["rev"]}


def test_no_message_is_sent_without_its_frame_although_a_newer_wish_calls_it_off():
    page = SlowSocket({"rev": rev, "photo": f"photo {rev}"} for rev in range(1, 60))
    asyncio.run(talk(page, studio=QuickStudio()))
    assert len(page.heard) > 20
    assert page.heard[::2][: len(page.heard) // 2] == page.heard[1::2]


async def asked(meanwhile, limit_s):
    """What a computing process answers within a limit, though something happens to it meanwhile."""
    computer = Computer({})
    await computer.open()
    try:
        await computer.ask("options")
        # It has got ready, however long that took.
        await computer.ask("options")
        computer._limit_s = limit_s
        answer = asyncio.ensure_future(computer.ask("warm"))
        await asyncio.to_thread(meanwhile, computer.pid)
        return await answer
    finally:
        await computer.close()


def test_what_computes_for_too_long_is_broken_off():
    with pytest.raises(CannotDraw, match="longer than"):
        asyncio.run(asked(lambda pid: None, 0.05))


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="needs Linux: elsewhere the time that passes counts")
def test_on_a_busy_machine_nothing_is_broken_off_because_it_waits():
    limit_s = 6.0

    def busy(pid):
        os.kill(pid, signal.SIGSTOP)
        time.sleep(limit_s + 1)
        os.kill(pid, signal.SIGCONT)

    assert asyncio.run(asked(busy, limit_s)) is None
