"""Nothing goes in; seeds for what reads folders and answers pages come out, as ``fuzz/seeds.py`` writes them."""

from __future__ import annotations

import dataclasses
import io
import json
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from PIL import Image

from fuzz.annotated import NAMES, PICTURE, SIZE
from fuzz.batches import DIGEST, PHOTO
from limner.batch import state, tile
from limner.batch.state import Known, State
from limner.storage import pack_npz
from limner.studio.orders import Order
from limner.targets import svg
from limner.types import Drawing
from limner.vision.landmarks import mesh

Seed = tuple[str, str, bytes]


def annotated() -> Iterator[Seed]:
    """Landmarks of two photos, photos of every orientation, people."""
    n, chance = len(NAMES), np.random.default_rng(0)
    arrays = {
        "names": np.array(NAMES),
        "size_wh": np.array([SIZE] * n),
        "ibug68": np.round(chance.uniform(1, 9, (n, 68, 2)), 1),
        "imm73": np.round(chance.uniform(1, 9, (n, 73, 2)), 1),
        "mp468": np.round(chance.uniform(1, 9, (n, mesh.POINTS, 2)), 1).astype(np.float32),
        "score": np.array([1.0, 0.5]),
    }
    by_hand = {name: array for name, array in arrays.items() if name not in ("mp468", "score")}
    yield "annotated", "by-hand.npz", pack_npz(by_hand)
    yield "annotated-machine", "mesh.npz", pack_npz({name: arrays[name] for name in arrays if name != "imm73"})
    yield "annotated-machine", "no-mesh.npz", pack_npz(by_hand)
    yield "annotated-photo", "plain.png", PICTURE
    exif = Image.Exif()
    exif[0x0112] = 6
    for kind in ("JPEG", "PNG", "TIFF"):
        out = io.BytesIO()
        Image.new("RGB", SIZE).save(out, kind, exif=exif)
        yield "annotated-photo", f"turned.{kind.lower()}", out.getvalue()
    yield "people", "info.csv", b'face_id,face_eth\r\na,one\r\nb,"two, or three"\r\n'


def batches() -> Iterator[Seed]:
    """What a run left behind, and addresses."""
    figures = {"drawing": "a-1.svg", "error": "", "faces": 1, "strokes": 20, "points": 300}
    figures |= {"ink_mm": 1.5, "travel_mm": 2.5, "seconds": 0.1}
    drawing = svg.to_svg(Drawing((np.array([[20.0, 20], [40, 30]]),), ("eye",), np.ones(1)), {})
    pictured = tile.tile_of_svg(drawing).replace(b'"photo": ""', b'"photo": "AA=="')
    with tempfile.TemporaryDirectory() as folder:
        with State.opened(Path(folder)) as known:
            known.keep_digest(PHOTO, "1 2 3", DIGEST)
            known.keep_done(DIGEST, Known("mark", figures, pictured))
        yield "batch-state", "one.sqlite", (Path(folder) / state.NAME).read_bytes()
    yield "batch-rows", "drawn", json.dumps(figures).encode() + b"\n" + pictured
    yield "batch-rows", "failed", json.dumps({"drawing": "", "error": "no face"}).encode() + b"\n"
    yield "tile", "own.svg", drawing
    yield "tile", "tile.json", pictured
    yield "urls", "some", b"memory://photos/a.jpg\nmemory://photos/\nmemory://*.jpg\ndata://,x\nnowhere://a/b.jpg?c=d"
    yield "urls", "packed", b"zip://a.jpg::memory://photos.zip\nzip://*::memory://photos.zip\na%20b.jpg"


def requests() -> Iterator[Seed]:
    """Of a guest, an operator and a stranger; and what a studio left behind."""
    order = Order("sim:", "axidraw", settings={"style": "portrait"})
    plan = json.dumps(["axidraw", 12.5, [0.0, 3.5]])
    journal = "limner-journal-1 x 2 0\nbegin 0 0 0\nreached 1 0 0\n"
    owner = json.dumps({"seal": "s", "about": {"drawing": "d", "photo": "p"}})
    yield "left-behind", "all", "\0".join([json.dumps(dataclasses.asdict(order)), plan, journal, owner]).encode()
    wish = json.dumps({"photo": "p", "settings": {"style": "canny"}, "want": ["preview", "plan"]})
    yield "socket", "wishes", f"{wish}\n{wish}\n{{}}\n\0binary".encode()
    known = "cookie: COOKIE\n"
    for k, (first, headers, body) in enumerate(
        (
            ("GET /?token=token&a=b", "", ""),
            ("GET /operator?token=token", "origin: http://localhost\nsec-fetch-site: none\n", ""),
            ("GET /api/queue", "host: [::1]:9000\ncookie: limner_visitor_9000=x\n", ""),
            ("POST /api/photo", f"{known}content-length: 3\n", "abc"),
            ("POST /api/photo/p/face", known, '{"box_px": [1, 2, 30, 40]}'),
            ("GET /api/photo/p.jpg", known, ""),
            ("DELETE /api/drawing/d", known, ""),
            ("POST /api/drawing", known, wish),
            ("GET /api/export/d.svg?machine=axidraw", known, ""),
            ("POST /api/job/check", known, '{"drawing": "d", "to": "sim:", "machine": "axidraw"}'),
            ("POST /api/job", known, '{"drawing": "d", "to": "sim:"}'),
            ("POST /api/queue", known, '{"drawing": "d", "name": "Ann"}'),
            ("DELETE /api/queue/x", known, ""),
            ("POST /api/operator/target", known, '{"to": "sim:", "robot": "dumbo"}'),
            ("POST /api/operator/remove", known, '{"entry": "x"}'),
            ("POST /api/operator/next", known, ""),
            ("GET /api/openapi.json", known, ""),
            ("POST /api/leave", f"{known}origin: http://example.org\n", ""),
        )
    ):
        yield "request", f"{k:02d}", f"{first}\n{headers}\n{body}".encode()
