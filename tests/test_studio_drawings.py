"""Drawings that are kept: plans of plotters and arms, every format they are saved as, and robots to look at."""

from __future__ import annotations

import io
import itertools
import json
import struct
import tomllib

import numpy as np
import pytest
from PIL import Image

import studios
from limner import storage
from limner.motion.arm.robots import ROBOTS, load_robot
from limner.motion.machine import load_machine
from limner.motion.pen import plan
from limner.pipeline import Session, Settings
from limner.targets import gcode_read, hpgl_read, svg_read
from limner.types import Drawing, JointTrajectory
from limner.vision.lines import PICTURES
from limner.vision.photo import load_photo

FEW = {"style": "splines"}


@pytest.fixture(scope="module")
def server():
    with studios.serving() as server:
        yield server


@pytest.fixture(scope="module")
def guest(server):
    with studios.enter(server) as client:
        client.photo = client.post("/api/photo", content=studios.face_jpeg()).json()["photo"]
        yield client


@pytest.fixture(scope="module")
def kept(guest):
    answer = guest.post("/api/drawing", json={"photo": guest.photo, "settings": FEW})
    assert answer.status_code == 201, answer.text
    return answer.json()


def exported(guest, kept, kind, **query):
    answer = guest.get(f"/api/export/{kept['drawing']}.{kind}", params=query)
    assert answer.status_code == 200, answer.text
    assert "attachment" in answer.headers["content-disposition"]
    return answer.content


@pytest.fixture(scope="module")
def drawing(guest, kept):
    return storage.from_npz(Drawing, exported(guest, kept, "npz"))


def unpacked(frame):
    """Times, places [mm], joints, lines and pen of a frame of a plan, by the table in docs/studio-protocol.md."""
    kind, rev, n, d, unit = struct.unpack_from("<BxxxIIIf", frame)
    assert kind == 2
    parts, at = [], 24
    for dtype, count in (("<f4", n), ("<i2", 2 * n), ("<f4", n * d), ("<i4", n), ("u1", n)):
        parts.append(np.frombuffer(frame, dtype, count, at))
        at += parts[-1].nbytes
    assert at == len(frame)
    t, places, joints, line, down = parts
    return rev, t, places.reshape(n, 2) * unit, joints.reshape(n, d), line, down


def unpacked_lines(frame):
    """Where each line begins and ends, and points [mm], of a frame of lines by the same table."""
    kind, _, n, m, unit = struct.unpack_from("<BxxxIIIf", frame)
    assert kind == 1
    offsets = np.frombuffer(frame, "<u4", n + 1, 24)
    return offsets, np.frombuffer(frame, "<i2", 2 * m, 24 + offsets.nbytes).reshape(m, 2) * unit


def test_what_is_kept_is_what_was_shown(guest, kept, drawing):
    with studios.live(guest) as talk:
        talk.wish(rev=1, photo=guest.photo, settings=FEW)
        final, frame = talk.hear(lambda said: said.get("final"))
    seen, told = kept["report"], final["report"]
    spent = {"compute_s", "cpu_s"}
    assert {key: seen[key] for key in seen.keys() - spent} == {key: told[key] for key in told.keys() - spent}
    lines = guest.get(f"/api/drawing/{kept['drawing']}.lines").content
    assert lines[8:] == frame[8:]
    assert len(drawing.lines_mm) == seen["strokes"]


def test_every_format_holds_the_same_drawing(guest, kept, drawing, tmp_path):
    readers = {"svg": svg_read.read_svg, "gcode": gcode_read.read_gcode, "hpgl": hpgl_read.read_hpgl}
    for kind, read in readers.items():
        path = tmp_path / f"it.{kind}"
        path.write_bytes(exported(guest, kept, kind))
        lines = read(str(path)).lines_mm
        assert len(lines) == len(drawing.lines_mm)
        assert max(np.abs(a - b).max() for a, b in zip(lines, drawing.lines_mm, strict=True)) < 0.05
    assert storage.from_json(Drawing, exported(guest, kept, "json")) == drawing
    with Image.open(io.BytesIO(exported(guest, kept, "png"))) as picture:
        assert picture.width / picture.height == pytest.approx(148 / 210, abs=0.01)
    assert tomllib.loads(exported(guest, kept, "toml").decode()) == Settings().replace(**FEW).to_dict()
    with Image.open(io.BytesIO(exported(guest, kept, "gif", machine="grbl"))) as film:
        assert film.n_frames > 20


def test_the_menu_names_every_format(guest, kept):
    assert {"svg", "png", "gcode", "hpgl", "json", "npz", "toml", "gif", "mp4", "trajectory.json"} <= set(
        guest.get("/api/options").json()["exports"]
    )
    answer = guest.get(f"/api/export/{kept['drawing']}.exe")
    assert answer.status_code == 400
    assert "svg" in answer.json()["error"]


@pytest.mark.slow
def test_a_style_in_colours_gives_its_picture_and_others_say_that_they_have_none(guest, kept):
    settings = {"style": "cartoon", "order.kicks": 0}
    drawn = guest.post("/api/drawing", json={"photo": guest.photo, "settings": settings}).json()
    assert drawn["wish"] == {"face": 0, "points_px": None, "settings": settings}
    with Image.open(io.BytesIO(exported(guest, drawn, "picture.png"))) as picture:
        seen = np.asarray(picture)
    wanted = Session(load_photo(studios.face_jpeg())).draw(Settings.from_dict({"style": "cartoon"})).picture()
    assert (seen == wanted).all()
    refused = guest.get(f"/api/export/{kept['drawing']}.picture.png")
    assert refused.status_code == 400
    assert "no picture in colours; choose from" in refused.json()["error"]
    pictured = {style["name"] for style in guest.get("/api/options").json()["styles"] if style["picture"]}
    assert pictured == set(PICTURES)


def test_a_plotters_plan_is_the_planners(guest, drawing):
    with studios.live(guest) as talk:
        talk.wish(rev=9, photo=guest.photo, settings=FEW, want=["preview", "plan"], plan={"machine": "grbl"})
        message, frame = talk.hear(lambda said: said["type"] == "plan")
    path = plan(drawing, load_machine("grbl"))
    rev, t, places, joints, line, down = unpacked(frame)
    assert rev == message["rev"] == 9
    assert message["plan"]["unreachable"] == []
    assert message["plan"]["seconds"] == pytest.approx(float(path.t_s[-1]))
    assert joints.shape == (len(t), 0)
    assert np.allclose(t, path.t_s, atol=1e-3)
    assert np.allclose(places, [0, 210] + path.position_mm[:, :2] * [1, -1], atol=0.006)
    assert (line == path.stroke).all()
    assert (down == path.down).all()


def test_a_drawing_too_large_is_told_with_its_lines(guest):
    with studios.live(guest) as talk:
        settings = FEW | {"page.size": "a3"}
        talk.wish(rev=1, photo=guest.photo, settings=settings, want=["plan"], plan={"machine": "brachiograph"})
        message, frame = talk.hear(lambda said: said["type"] == "plan")
    assert frame is None
    assert "scale" in message["error"]
    assert message["plan"]["unreachable"]


@pytest.mark.parametrize("plan", [{"machine": "/etc/passwd.toml"}, {"robot": "/etc/robot.urdf"}, {"robot": 7}])
def test_the_page_chooses_no_files(guest, plan):
    with studios.live(guest) as talk:
        talk.wish(rev=1, photo=guest.photo, settings=FEW, want=["plan"], plan=plan)
        message, _ = talk.hear(lambda said: said["type"] in ("error", "plan"))
    assert message["type"] == "error"
    assert "choose" in message["error"]


@pytest.mark.slow
def test_an_arms_plan_leads_the_pen_along_the_drawing(guest, kept, drawing):
    pytest.importorskip("urdf_parser_py")
    with studios.live(guest) as talk:
        talk.wish(rev=2, photo=guest.photo, settings=FEW, want=["plan"], plan={"robot": "dumbo"})
        message, frame = talk.hear(lambda said: said["type"] == "plan")
    told, robot = message["plan"], load_robot("dumbo")
    _, t, places, joints, line, _ = unpacked(frame)
    assert told["joints"] == list(robot.joints)
    assert set(line.tolist()) == {-1, *range(len(drawing.lines_mm))}
    tips = robot.forward(joints.astype(float))[:, :3, 3]
    paper = np.linalg.inv(np.array(told["base_from_paper"]))
    seen = 1000 * (tips @ paper[:3, :3].T + paper[:3, 3])
    assert np.allclose(places, [0, 210] + seen[:, :2] * [1, -1], atol=0.1)
    assert told["seconds"] == pytest.approx(t[-1], rel=1e-3)
    assert told["velocity_used"] <= 1
    motion = storage.from_json(JointTrajectory, exported(guest, kept, "trajectory.json", robot="dumbo"))
    assert motion.names == robot.joints


@pytest.mark.slow
def test_what_an_arm_cannot_reach_is_told_line_by_line(guest):
    pytest.importorskip("urdf_parser_py")
    with studios.live(guest) as talk:
        settings = FEW | {"page.size": "a5", "arm.place.at": "0.92,0.1,0.0"}
        talk.wish(rev=2, photo=guest.photo, settings=settings, want=["preview", "plan"], plan={"robot": "ur5e"})
        _, lines = talk.hear(lambda said: said["type"] == "preview" and said["final"])
        message, frame = talk.hear(lambda said: said["type"] == "plan")
    assert frame is None
    assert "cannot be reached" in message["error"]
    base_from_paper, red = np.array(message["plan"]["base_from_paper"]), set(message["plan"]["unreachable"])
    offsets, points = unpacked_lines(lines)
    places = np.c_[points[:, 0], 210 - points[:, 1], np.zeros(len(points))] / 1000
    away = np.linalg.norm((places @ base_from_paper[:3, :3].T + base_from_paper[:3, 3])[:, :2], axis=1)
    farthest = [away[i:j].max() for i, j in itertools.pairwise(offsets)]
    # An upright pen is held as far from the first joint on all sides: a circle parts what is reached from what is not.
    reached = [far for i, far in enumerate(farthest) if i not in red]
    assert 0 < len(red) < len(farthest)
    assert max(reached) < min(farthest[i] for i in red) + 0.002


@pytest.mark.parametrize("name", ROBOTS)
def test_a_robot_can_be_looked_at(guest, name):
    pytest.importorskip("urdf_parser_py")
    seen, robot = guest.get(f"/api/robot/{name}.json").json(), load_robot(name)
    frame = np.eye(4)
    q = np.linspace(-0.5, 0.5, robot.dof)
    positions = dict(zip(robot.joints, q, strict=True))
    for joint in seen["joints"]:
        frame = frame @ origin(joint["xyz"], joint["rpy"]) @ turned(joint, positions.get(joint["name"], 0.0))
    assert np.allclose(frame, robot.forward(q), atol=1e-9)
    assert [link["name"] for link in seen["links"]][1:] == [joint["child"] for joint in seen["joints"]]
    assert sum(len(link["shapes"]) for link in seen["links"]) == len(robot.capsules)
    assert guest.get(f"/api/robot/{name}.urdf").content.lstrip().startswith(b"<")


def origin(xyz, rpy):
    """As URDF says: turns about the fixed axes x, y, z, one after the other."""
    turn = np.eye(3)
    for axis, angle in enumerate(rpy):
        turn = about(np.eye(3)[axis], angle) @ turn
    frame = np.eye(4)
    frame[:3, :3], frame[:3, 3] = turn, xyz
    return frame


def about(axis, angle):
    """Rodrigues."""
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def turned(joint, position):
    frame = np.eye(4)
    if joint["type"] == "prismatic":
        frame[:3, 3] = position * np.array(joint["axis"])
    elif joint["type"] == "revolute":
        frame[:3, :3] = about(joint["axis"], position)
    return frame


def test_no_other_robot_is_read(guest):
    assert guest.get("/api/robot/passwd.json").status_code == 400
    assert guest.get("/api/robot/passwd.urdf").status_code == 400


def test_drawings_are_their_visitors_own(server, guest, kept):
    assert kept["drawing"] in json.dumps(guest.get("/api/drawings").json())
    with studios.enter(server) as other:
        assert other.get("/api/drawings").json() == {"drawings": []}
        assert other.get(f"/api/export/{kept['drawing']}.svg").status_code == 404
        assert other.get(f"/api/drawing/{kept['drawing']}.lines").status_code == 404
        assert other.delete(f"/api/drawing/{kept['drawing']}").status_code == 404
        assert other.post("/api/drawing", json={"photo": guest.photo}).status_code == 404


def test_a_drawing_that_is_let_go_is_gone(guest):
    name = guest.post("/api/drawing", json={"photo": guest.photo, "settings": FEW}).json()["drawing"]
    assert guest.delete(f"/api/drawing/{name}").status_code == 204
    assert guest.get(f"/api/export/{name}.svg").status_code == 404
