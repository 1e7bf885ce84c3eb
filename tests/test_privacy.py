"""Photos stay on the machine and nowhere on its disk: a studio is visited, its files and connections are watched."""

import contextlib
import os
import subprocess
import sys
from pathlib import Path

import numpy as np

import studios
from limner.vision.photo import load_photo

HOOK = """
import os, sys
def heard(event, arguments):
    if event in ("socket.connect", "socket.sendto", "socket.bind"):
        address = arguments[-1]
    elif event in ("socket.getaddrinfo", "socket.gethostbyname"):
        address = arguments
    else:
        return
    if isinstance(address, tuple):
        with open(os.environ["LIMNER_HEARD"], "a") as file:
            print(event, address[0], file=file)
sys.addaudithook(heard)
"""
OURS = ("127.0.0.1", "::1", "localhost")


def watched(folder, monkeypatch):
    """Every connection that a Python process begins from now on is written down."""
    (folder / "hook").mkdir()
    (folder / "hook" / "sitecustomize.py").write_text(HOOK)
    before = os.environ.get("PYTHONPATH", "")
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(filter(None, [str(folder / "hook"), before])))
    monkeypatch.setenv("LIMNER_HEARD", str(folder / "heard"))
    return folder / "heard"


def away(file):
    """What was begun, but by listening on this machine's own address, and by looking that up."""
    lines = file.read_text().splitlines() if file.exists() else []
    own = ("socket.bind", "socket.getaddrinfo")
    return [line for line in lines if not (line.startswith(own) and line.endswith(OURS))]


def pieces(data):
    """Parts of a file that nothing else has."""
    parts = [data[at : at + 48] for at in range(600, len(data) - 48, len(data) // 20)]
    return [part for part in parts if len(set(part)) > 8]


def test_after_a_visit_nothing_of_the_photo_is_left_and_nobody_was_called(tmp_path, monkeypatch):
    heard = watched(tmp_path, monkeypatch)
    for name in ("tmp", "state", "home", "cwd"):
        (tmp_path / name).mkdir()
    monkeypatch.setenv("TMPDIR", str(tmp_path / "tmp"))
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    photo = studios.face_jpeg()
    parts = pieces(photo) + pieces(load_photo(photo).rgb.tobytes())

    def kept():
        """Files in which a part of the photo or of its pixels stands, or that are a picture."""
        found = []
        for file in tmp_path.rglob("*"):
            data = b""
            with contextlib.suppress(FileNotFoundError):  # what is gone is not kept
                data = file.read_bytes() if file.is_file() else b""
            picture = data.startswith((b"\xff\xd8\xff", b"\x89PNG", b"RIFF"))
            if picture or any(part in data for part in parts):
                found.append(file)
        return found

    server = studios.Server(cwd=tmp_path / "cwd", state=tmp_path / "state")
    try:
        with studios.enter(server) as client:
            taken = client.post("/api/photo", content=photo).json()
            wish = {"photo": taken["photo"], "settings": {"style": "splines", "page.size": "a6"}}
            assert client.post("/api/drawing", json=wish).status_code == 201
            shown = client.get(f"/api/photo/{taken['photo']}.jpg").content
            assert kept() == [], "while it is looked at"
    finally:
        code, said = server.close()
    assert code == 0 or code == 130, said
    assert kept() == []
    assert list((tmp_path / "tmp").iterdir()) == []
    assert list((tmp_path / "cwd").iterdir()) == []
    assert [path for path in (tmp_path / "home").rglob("*") if path.is_file()] == []
    assert taken["photo"] not in said
    assert away(heard) == []
    # The test can find what it looks for.
    (tmp_path / "cwd" / "copy").write_bytes(b"x" + photo)
    (tmp_path / "cwd" / "shown").write_bytes(shown)
    np.save(tmp_path / "cwd" / "pixels.npy", load_photo(photo).rgb)
    assert len(kept()) == 3


def test_the_watch_hears_connections(tmp_path, monkeypatch):
    heard = watched(tmp_path, monkeypatch)
    code = "import socket; s = socket.socket(); s.settimeout(1); s.connect_ex(('127.0.0.1', 9))"
    subprocess.run([sys.executable, "-c", code], check=True)
    assert away(heard) == ["socket.connect 127.0.0.1"]
    code = "import socket; socket.getaddrinfo('192.0.2.1', 80); socket.getaddrinfo('localhost', 80)"
    subprocess.run([sys.executable, "-c", code], check=True)
    assert away(heard) == ["socket.connect 127.0.0.1", "socket.getaddrinfo 192.0.2.1"]


def test_drawing_calls_nobody_and_leaves_nothing(tmp_path, monkeypatch):
    heard = watched(tmp_path, monkeypatch)
    (tmp_path / "tmp").mkdir()
    monkeypatch.setenv("TMPDIR", str(tmp_path / "tmp"))
    photo = tmp_path / "face.jpg"
    photo.write_bytes(studios.face_jpeg())
    words = ["draw", photo, "-o", tmp_path / "face.svg", "--style", "splines"]
    subprocess.run([sys.executable, "-m", "limner", *map(str, words)], check=True, capture_output=True)
    assert away(heard) == []
    assert list((tmp_path / "tmp").iterdir()) == []
    assert {path.name for path in Path(tmp_path).iterdir() if path.is_file()} <= {"face.jpg", "face.svg"}
