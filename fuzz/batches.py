"""Bytes of what a batch meets go in: what it kept of a run before, tiles of its contact sheet, addresses of photos."""

from __future__ import annotations

import contextlib
import hashlib
import io
import sqlite3
import zipfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from fuzz.contract import file_of
from limner.batch import remote, state, tile
from limner.batch.engine import Engine
from limner.batch.names import drawing_name
from limner.batch.run import Order, draw_all
from limner.batch.sheet import to_html
from limner.batch.state import State
from limner.batch.summary import Summary
from limner.batch.work import Recipe
from limner.errors import LimnerError
from limner.pipeline import Settings

PHOTO, CONTENT = "a.jpg", b"no picture"
DIGEST = hashlib.sha256(CONTENT).hexdigest()
SCHEMES = ("memory", "zip", "data", "nowhere")
"""Kinds of addresses that lead to no file of this computer and to no other one."""

MOST_BYTES = 10_000


def kept(data: bytes) -> None:
    """The file of a run before; another run begins."""
    with file_of(data, state.NAME) as path:
        _drawn(path.parent)


def rows(data: bytes) -> None:
    """What was kept of a photo: its figures in the first line, its tile in the others."""
    figures, _, pictured = data.partition(b"\n")
    with file_of(CONTENT, PHOTO) as path:
        folder = path.parent
        with State.opened(folder):
            pass
        values = (hashlib.sha256(DIGEST.encode()).hexdigest(), _order(folder).mark(), _text(figures), pictured)
        with contextlib.closing(sqlite3.connect(folder / state.NAME)) as base, base:
            base.execute("INSERT INTO done VALUES (?, ?, ?, ?)", values)
        _drawn(folder)


def _text(figures: bytes) -> str | bytes:
    """As text; as bytes where it is none, which SQLite lets stand there too."""
    try:
        return figures.decode()
    except UnicodeDecodeError:
        return figures


def _order(folder: Path) -> Order:
    return Order(Recipe(Settings(), formats=()), folder, str(folder), tiles=1)


def _drawn(folder: Path) -> None:
    (folder / PHOTO).write_bytes(CONTENT)
    summary = Summary(room=5)
    with ThreadPoolExecutor(1) as executor, State.opened(folder) as known:
        for told in draw_all([str(folder / PHOTO)], Engine(executor, 1), _order(folder), known):
            summary.add(told)
    assert summary.photos == 1
    _shown(to_html(summary, folder, str(folder)))


def _shown(page: bytes) -> None:
    """The page runs no program but its own, whatever it was made of."""
    assert page.count(b"<script") == page.count(b"</script") == 1
    assert page.count(b"<svg") <= 1


def tiles(data: bytes) -> None:
    """A tile; and a drawing of which one is made."""
    assert tile.unpacked(tile.tile_of_svg(data))
    tile.unpacked(data)


def urls(data: bytes) -> None:
    """Addresses of photos, one on each line."""
    for url in data.decode("utf-8", "replace").splitlines()[:5]:
        drawing_name(url, DIGEST)
        schemes = [part.partition("://")[0] for part in url.split("::")]
        if remote.is_url(url) and set(schemes) <= set(SCHEMES):
            _fetched(url)


def _fetched(url: str) -> None:
    remote.write("memory://photos/a.jpg", CONTENT)
    remote.write("memory://photos.zip", PACKED)
    for reach in (remote.stamp, lambda url: remote.read(url, MOST_BYTES), lambda url: list(remote.listed(url, [""]))):
        with contextlib.suppress(LimnerError):
            reach(url)


def _packed() -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as archive:
        archive.writestr(PHOTO, CONTENT)
    return out.getvalue()


PACKED = _packed()

HARNESSES = {"batch-state": kept, "batch-rows": rows, "tile": tiles, "urls": urls}
