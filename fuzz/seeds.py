"""Nothing goes in; the corpus of every harness comes out, made by limner's own writers and by hand: ``fuzz/corpus``.

``python -m fuzz.seeds`` writes it anew and leaves the files whose names begin with ``found-``: what fuzzing found.
"""

from __future__ import annotations

import contextlib
import dataclasses
import io
import json
import sys
import tempfile
from collections.abc import Iterator
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from fuzz import CORPUS, harnesses, seeds_folders
from fuzz.journals import HEAD
from fuzz.models import OWNER
from fuzz.robots import ARM
from limner import storage
from limner.pipeline import Settings
from limner.settings import write_toml
from limner.targets import gcode, hpgl, joints, svg
from limner.types import Drawing, EdgeMap, Face, JointTrajectory, Page, Pen, PenPath, Photo, Strokes

_TEXT = 116  # bytes of free text in which a MAT-file begins

Seed = tuple[str, str, bytes]
"""Name of the harness, of the file, and what is in it."""


def main() -> None:
    """Write all of it."""
    for old in CORPUS.glob("*/seed-*"):
        old.unlink()
    for harness, name, data in _all():
        assert harness in harnesses(), harness
        (CORPUS / harness).mkdir(parents=True, exist_ok=True)
        (CORPUS / harness / f"seed-{name}").write_bytes(data)


def _all() -> Iterator[Seed]:
    for part in (
        _photos,
        _drawings,
        _faces,
        _stored,
        _models,
        _settings,
        _robots,
        _lists,
        _journals,
        _machines,
        _studio,
        seeds_folders.annotated,
        seeds_folders.batches,
        seeds_folders.requests,
    ):
        yield from part()


def _drawing() -> Drawing:
    lines = (np.array([[20.0, 20], [40, 30], [50, 20]]), np.array([[60.0, 60]]), np.array([[10.0, 90], [90, 95]]))
    pens = (Pen(0.5), Pen(0.3, (200, 30, 20), "red"))
    return Drawing(lines, ("eye", "mouth", "face"), np.array([3.0, 1, 2]), Page(105, 148, 5), pens, np.array([0, 0, 1]))


def _face() -> Face:
    angle = np.linspace(0, 2 * np.pi, 68, endpoint=False)
    points = np.round(100 + 40 * np.column_stack([np.cos(angle), np.sin(angle)]), 2)
    return Face(points, np.array([60.0, 60, 140, 140]), 1.5, -3.0, "hand")


def _motion() -> JointTrajectory:
    t = np.array([0.0, 0.02, 0.04])
    q = np.column_stack([t, -t])
    return JointTrajectory(("a", "b"), t, q, q * 0, q * 0, [False, True, True], [-1, 0, 0])


def _photos() -> Iterator[Seed]:
    rgb = np.arange(12 * 10 * 3, dtype=np.uint8).reshape(10, 12, 3)
    image = Image.fromarray(rgb)
    exif = Image.Exif()
    exif[0x0112] = 6
    for kind, more in (
        *(("PNG", {}), ("JPEG", {"exif": exif}), ("WEBP", {"lossless": True}), ("GIF", {}), ("BMP", {}), ("PPM", {})),
        *(("TIFF", {"compression": "tiff_lzw"}), ("JPEG2000", {}), ("AVIF", {})),
    ):
        out = io.BytesIO()
        with contextlib.suppress(KeyError):  # not every Pillow writes every format
            image.save(out, kind, **more)
            yield "photo", kind.lower(), out.getvalue()
    for mode in ("1", "LA", "P", "I;16", "CMYK"):
        out = io.BytesIO()
        image.convert("L" if mode == "I;16" else mode).convert(mode).save(out, "TIFF" if mode == "CMYK" else "PNG")
        yield "photo", f"mode-{mode.lower().replace(';', '')}", out.getvalue()


def _drawings() -> Iterator[Seed]:
    drawing = _drawing()
    own = svg.to_svg(drawing, {"style": "portrait"})
    yield "svg", "own.svg", own
    yield "svg-about", "own.svg", own
    yield "svg", "shapes.svg", _SHAPES
    for pen in ("servo", "z"):
        yield "gcode", f"{pen}.gcode", gcode.to_gcode(drawing, gcode.GcodeSettings(pen=pen))
    yield (
        "gcode",
        "arcs.gcode",
        b"G21 G90\nG0 X10 Y10\nM3 S90\nG2 X20 Y10 I5 J0 F600\nG3 X10 Y10 I-5\nG91 G1 X1\nM5\nG92 X0\n",
    )
    yield "hpgl", "own.hpgl", hpgl.to_hpgl(drawing)
    yield "hpgl", "others.hpgl", b'IN;SP1;CO "a";PA100,100;PD200,200,300,100;PR;PD10,10;LBtext\x03PU;SP2;PD0,0;SP0;'


_SHAPES = b"""<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink"
 width="100mm" height="80mm" viewBox="0 0 100 80"><style>.a{stroke:#f00;stroke-width:2px}</style>
<defs><g id="g"><circle cx="5" cy="5" r="3" stroke="black"/></g></defs>
<g transform="translate(10,10) rotate(30) scale(2)" class="a"><path d="M0 0L10 10C1 2 3 4 5 6Q1 2 3 4A5 5 0 0 1 9 9z"/>
<rect x="1" y="2" width="10" height="5" rx="1"/><use href="#g" x="3"/><use xlink:href="#g"/></g>
<polyline points="0,0 1,1 2,0" style="stroke:blue;fill:none"/><ellipse cx="1" cy="2" rx="3" ry="4"/></svg>"""


def _faces() -> Iterator[Seed]:
    face = _face()
    fields = storage.to_fields(face)
    yield "faces-json", "faces.json", json.dumps({"faces": [fields]}).encode()
    yield "faces-json", "face.json", storage.to_json(face).encode()
    yield "faces-json", "points.json", json.dumps({"points_px": fields["points_px"]}).encode()
    rows = [f"{x:g} {y:g}" for x, y in face.points_px]
    yield "faces-pts", "face.pts", "\n".join(["version: 1", "n_points: 68", "{", *rows, "}"]).encode()
    yield "faces-csv", "face.csv", "\n".join(["x,y", *(row.replace(" ", ",") for row in rows)]).encode()


def _stored() -> Iterator[Seed]:
    flat = np.zeros((2, 3))
    lines = (np.array([[1.0, 2], [3, 4]]), np.array([[5.0, 6]]))
    values: list[Any] = [
        *(Photo(np.zeros((2, 3, 3), np.uint8)), _face(), EdgeMap(flat > 0, flat, flat), _drawing(), _motion()),
        Strokes(lines, ("eye", "nose"), np.ones(2), (10, 10)),
        PenPath([0.0, 1.0], np.zeros((2, 3)), [False, True], [-1, 0]),
    ]
    for value in values:
        name = type(value).__name__.lower()
        yield "json", f"{name}.json", storage.to_json(value).encode()
        yield "npz", f"{name}.npz", storage.to_npz(value)
    yield "joints-csv", "motion.csv", joints.to_csv(_motion())


def _models() -> Iterator[Seed]:
    from scipy.io import savemat

    from limner.vision.landmarks.fmp.model import Component, FmpModel, pack_model
    from limner.vision.likeness.discriminant import Discriminant
    from limner.vision.likeness.model import LikenessModel, save_likeness
    from limner.vision.refine.descent import Descent, Look, Step, save_descent
    from limner.vision.refine.shape import ShapeModel, save_shape

    springs, anchors = np.array([[0.0] * 4, [0.01, 0, 0.01, 0]]), np.array([[0, 0], [1, 2]])
    part = Component(0.0, 0.5, np.array([-1, 0]), np.array([0, 0]), springs, anchors, np.array([0, 1]))
    model = FmpModel(np.zeros((1, 5, 5, 32), np.float32), (part,), -0.5)
    yield "fmp", "tiny.npz", pack_model(model)
    yield "checkpoint", "tiny.npz", storage.pack_npz(_state(pack_model(model)))
    out = io.BytesIO()
    savemat(out, {"model": _release()}, do_compression=True)
    # Its first bytes tell the time of day, which no reader looks at.
    yield "mat", "tiny.mat", b"MATLAB 5.0 MAT-file".ljust(_TEXT) + out.getvalue()[_TEXT:]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "model.npz"
        learnt = Discriminant(np.zeros(4, np.float32), np.zeros(4, np.float32), np.ones((4, 2), np.float32))
        save_likeness(LikenessModel(learnt, np.ones((3, 2), np.float32)), path)
        yield "likeness", "tiny.npz", path.read_bytes()
        save_shape(ShapeModel(np.zeros((68, 2)), np.ones((68, 2)), np.ones((136, 1)), np.ones(1)), path)
        yield "shape", "tiny.npz", path.read_bytes()
        look = Look(8, 0.06, 0.12, 1)
        step = Step(look, np.zeros((544, 1), np.float32), np.zeros((1, 136), np.float32), np.zeros(136, np.float32))
        save_descent(Descent(np.zeros((68, 2)), (step,)), path)
        yield "best", "tiny.npz", path.read_bytes()


def _state(model: bytes) -> dict[str, Any]:
    return {
        "ticket": np.array(OWNER),
        "model": np.frombuffer(model, np.uint8),
        "start": np.zeros(3),
        "table": np.zeros((1, 3), np.int64),
        "cells": np.zeros((1, 2, 2), np.int64),
        "groups": np.zeros(1, np.int64),
        "alpha": np.zeros(1),
        "rounds": np.array("[]"),
        "curve": np.array("[]"),
    }


def _release() -> dict[str, Any]:
    """A model as the release has it, of no use."""
    parts = [{"defid": k + 1.0, "filterid": 1.0, "parent": float(k)} for k in range(68)]
    parts[1:] = [part | {"parent": 1.0} for part in parts[1:]]
    springs = [{"w": np.full(4, 0.01), "anchor": np.array([1.0, 1, 0])} for _ in parts]
    springs[0]["w"] = np.array([0.5])
    kinds = [("w", object), ("anchor", object)]
    component = np.empty((1, 1), object)
    component[0, 0] = np.array([[tuple(part.values()) for part in parts]], [(name, object) for name in parts[0]])[0]
    return {
        "defs": np.array([[tuple(spring.values()) for spring in springs]], kinds),
        "components": component,
        "filters": np.array([[(np.zeros((5, 5, 32)),)]], [("w", object)]),
        "thresh": -0.5,
        "interval": 5.0,
        "sbin": 4.0,
    }


def _settings() -> Iterator[Seed]:
    from limner.vision.landmarks.fmp.train_settings import TrainSettings

    short = b'style = "portrait"\n[page]\nsize = "a6"\n[arm.retime]\nsample_s = 0.02\n[detect]\n'
    yield "settings", "short.toml", short
    yield "settings", "odd.toml", b"a.b = [1, {c = 1979-05-27T07:32:00Z}]\n[[x]]\ny = '''z'''\n"
    yield "settings", "all.toml", write_toml(Settings()).encode()
    for k, text in enumerate(("page.size=a5", "order.kicks=3", "simulate=1", "arm.retime.sample_s=0.02", "x.y=[1]")):
        yield "assigned", str(k), text.encode()
    folder = resources.files("limner.motion") / "machines"
    yield "machine", "axidraw.toml", (folder / "axidraw.toml").read_bytes()
    yield "training", "all.toml", write_toml(TrainSettings()).encode()
    for k, text in enumerate(("length 12.5mm", "time 1.5h", "page a5:landscape", "page 5x7in", "page 120x160mm")):
        yield "quantities", str(k), text.encode()


def _robots() -> Iterator[Seed]:
    folder = resources.files("limner.motion.arm.robots")
    yield "urdf", "ur5e.urdf", (folder / "ur5e.urdf").read_bytes()
    yield "urdf", "arm.urdf", ARM
    yield "urdf", "shapes.urdf", ARM.replace(b'<link name="tip"/>', _LINK)
    fields = b'base = "base"\ntip = "end"\nacceleration = [1, 2]\njerk = [3]\ncontroller = "c"\nfrozen = {k = 0.1}\n'
    yield (
        "robot-toml",
        "all.toml",
        fields.replace(b"[1, 2]", b"[1]") + b"sheet_box_m = [[0,0,0],[1,1,1]]\nposes = {safe = [0]}\n",
    )
    yield "robot-toml", "own.toml", (folder / "ur5e.toml").read_bytes()


_LINK = b"""<link name="tip"><inertial><origin xyz="0 0 1" rpy="1 2 3"/><mass value="2"/>
<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>
<collision><geometry><cylinder length="1" radius="0.1"/></geometry></collision>
<collision><origin xyz="1 0 0"/><geometry><box size="1 2 3"/></geometry></collision>
<collision><geometry><sphere radius="0.1"/></geometry></collision></link>"""


def _lists() -> Iterator[Seed]:
    points = [[0.1, 0.2, 0.3], [0.4, 0.2, 0.3], [0.1, 0.5, 0.3], [0.4, 0.5, 0.301]]
    yield "calibration-json", "points.json", json.dumps(points).encode()
    yield "calibration-csv", "points.csv", "\n".join(",".join(map(str, row)) for row in points).encode()
    yield "photos-txt", "names.txt", b"a.jpg\nsub/b.png\r\n\nhttps://example.org/c.jpg\n"
    yield "photos-csv", "names.csv", b'id,photo\n1,a.jpg\n2,"b ""x"".png"\n'
    yield "photos-piped", "lines", b"a.jpg\nb.jpg\n"
    yield "photos-piped", "nul", b"a.jpg\0b\nc.jpg\0"
    from limner.batch.manifest import COLUMNS, Row

    row = dataclasses.astuple(Row("a.jpg", "00", "a.svg", 1, 20, 300, 1.5, 2.5, 0.1))
    yield "manifest", "one.csv", "\r\n".join([",".join(COLUMNS), ",".join(map(str, row)), ""]).encode()


def _journals() -> Iterator[Seed]:
    import zlib

    lines = [HEAD, "begin 0 0", "reached 0 2", "begin 1 0"]
    yield "journal", "begun", b"".join(f"{line} {zlib.crc32(line.encode()):08x}\n".encode() for line in lines)
    yield "journal-signed", "begun", "\n".join(lines[1:]).encode()


def _machines() -> Iterator[Seed]:
    greeting = b"\r\nGrbl 1.1h ['$' for help]\r\n"
    yield (
        "grbl",
        "good",
        b"\x3f" + greeting + b"<Idle|MPos:0,0,0>\r\n" + b"ok\r\n" * 60 + b"<Idle>\r\n" + b"ok\r\n" * 60,
    )
    yield "grbl", "z", b"\x7f" + greeting + b"<Idle>\r\n$32=0\r\n" + b"ok\r\n" * 60
    yield "grbl", "alarm", b"\x3f" + greeting + b"<Alarm>\r\n"
    yield "grbl", "error", b"\x3f" + greeting + b"<Idle>\r\nok\r\nerror:9\r\nALARM:1\r\n"
    yield "grbl", "talks", b"\xbf" + greeting + b"<Run>\r\n[MSG:x]\r\n$1=2\r\n\r\n"
    yield "ebb", "good", b"\x3fEBBv13_and_above EB Firmware Version 2.8.1\r\n0500,0500\r\nOK\r\n" + b"OK\r\n" * 40
    yield "ebb", "again", b"\x9fEBB Version\r\n1,999\r\nOK\r\nQM,0,0,0,0\r\n12,-34\r\nOK\r\n!8 Err\r\n"
    state = {"op": "publish", "topic": "/joint_states", "msg": {"name": ["a", "b"], "position": [0.0, 0.0]}}
    answer = {"op": "service_response", "id": "limner:call_service:2", "result": True, "values": {"success": True}}
    yield "rosbridge", "good", b"\n".join(json.dumps(said).encode() for said in [answer, *[state] * 20])
    yield "rosbridge", "refused", json.dumps({"op": "status", "level": "error", "msg": "no"}).encode()
    yield "ur", "good", b"\x10token begun\ntoken done [0, 1.5, -1, 0, 0, 0]\nother done\n"
    for k, text in enumerate(
        ("ur ur:10.0.0.1:30002", "ur ur:[fd00::1]", "bridge rosbridge:ws://h:1/a/b", "x grbl:COM3")
    ):
        yield "addresses", str(k), text.encode()


def _studio() -> Iterator[Seed]:
    points = np.round(_face().points_px, 1).tolist()
    wish = {"rev": 1, "photo": "abc", "face": 0, "want": ["preview", "plan"], "plan": {"machine": "axidraw"}}
    for harness in ("wish", "body"):
        yield harness, "wish.json", json.dumps(wish | {"settings": {"page.size": "a6", "style": "canny"}}).encode()
        yield harness, "hand.json", json.dumps(wish | {"points_px": points}).encode()
    yield "body", "points.json", json.dumps({"points_px": points}).encode()
    yield "body", "box.json", json.dumps({"box_px": [10, 10, 200, 220]}).encode()


if __name__ == "__main__":
    sys.exit(main())
