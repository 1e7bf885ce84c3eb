"""A photo goes in; how soon the studio's server answers, shows, redraws, and what memory it needs, come out."""

from __future__ import annotations

import http.client
import itertools
import json
import re
import signal
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from limner.errors import LimnerError, MissingExtra
from limner.evaluate.speed import Row, framed
from limner.types import Photo

SIZE_PX = (640, 800)
PATIENCE_S = 120.0

SLIDERS: dict[str, tuple[tuple[str, tuple[Any, ...]], ...]] = {
    "detail": (("portrait.detail", (0.5, 0.8, 1.2, 1.6, 2.0)),),
    "hair": (("portrait.hair_apart", (0.03, 0.05, 0.07, 0.1, 0.12)),),
    "smoothness": (("clean.tolerance_mm", (0.05, 0.1, 0.2, 0.3, 0.45)),),
    "shading": (("tone.level", ("light", "medium", "light", "medium", "light")), ("tone.closest", (0.03, 0.035, 0.04))),
    "detail, Gabor": (("style", ("gabor",)), ("gabor.high", (1.5, 1.6, 1.9, 2.0, 2.1))),
    "budget in points": (("select.points", (200, 260, 320, 380, 440)),),
    "budget in minutes": (("select.minutes", (0.4, 0.5, 0.6, 0.7, 0.8)),),
}
"""What is moved, and where to."""


def measure_studio(photo: Photo, runs: int = 10, photos: int = 200) -> Iterator[Row]:
    """Time a studio of its own, as its page sees it; without the time the page takes to show.

    Args:
        photo: with a face; it is cut and scaled to 640x800.
        runs: of each slider.
        photos: how many go through it while its memory is looked at.

    Yields:
        One row after the other, as they are ready.

    Raises:
        MissingExtra: the extra ``studio`` is not installed.
    """
    picture = _jpeg(framed(photo, SIZE_PX))
    began = time.perf_counter()
    with _Studio() as studio:
        studio.get("/")
        yield Row("start to first answer", 1000 * (time.perf_counter() - began), "ms", 1500.0)
        studio.get("/api/options")
        began = time.perf_counter()
        name = studio.post(picture)
        with studio.live() as live:
            _drawn(live, 1, name, {})
            yield Row("photo to first drawing", 1000 * (time.perf_counter() - began), "ms", 2000.0)
            yield from _sliders(live, name, runs)
        yield from _memory(studio, photo, photos)


def _sliders(live: Any, name: str, runs: int) -> Iterator[Row]:
    rev, everything = itertools.count(2), []
    for label, moved in SLIDERS.items():
        took, cpu = [], []
        for run in range(runs):
            settings = {path: values[run % len(values)] for path, values in moved}
            began = time.perf_counter()
            cpu.append(1000 * _drawn(live, next(rev), name, settings)["cpu_s"])
            took.append(1000 * (time.perf_counter() - began))
            _quiet(live)
        everything += took
        yield Row(f"slider to preview, {label}", statistics.median(took), "ms", 300.0)
        yield Row(f"slider to preview, {label}, CPU of computing", statistics.median(cpu), "ms")
    yield Row("slider to preview, all", statistics.median(everything), "ms", 300.0)
    yield Row("slider to preview, all, 95 of 100", float(np.quantile(everything, 0.95)), "ms", 450.0)


def _drawn(live: Any, rev: int, name: str, settings: dict[str, Any]) -> dict[str, Any]:
    """The report of a wish's first preview."""
    live.send(json.dumps({"rev": rev, "photo": name, "settings": settings}))
    while True:
        said, _ = _heard(live)
        if said["type"] == "error":
            raise LimnerError(f"studio: {said['error']}")
        if said["type"] == "preview" and said["rev"] == rev:
            report: dict[str, Any] = said["report"]
            return report


def _quiet(live: Any) -> None:
    """Until the final drawing has come too, as when somebody looks at it."""
    while not _heard(live)[0].get("final"):
        pass


def _heard(live: Any) -> tuple[dict[str, Any], bytes]:
    said = json.loads(live.recv(timeout=PATIENCE_S))
    return said, live.recv(timeout=PATIENCE_S) if said.get("frame") else b""


def _memory(studio: _Studio, photo: Photo, photos: int) -> Iterator[Row]:
    """What it grows by from the first quarter of the photos to the last; each is another one, and is drawn."""
    seen, rev = [], itertools.count(1)
    with studio.live() as live:
        for i in range(photos):
            # Sides that differ, so that nothing fits where it was before.
            picture = framed(photo, (SIZE_PX[0] - 4 * (i % 20), SIZE_PX[1] - 6 * (i % 17)))
            _drawn(live, next(rev), studio.post(_jpeg(picture)), {})
            _quiet(live)
            seen.append(studio.memory_mb())
    quarter = max(1, photos // 4)
    if seen and seen[0]:
        yield Row(f"memory of all processes, most over {photos} photos", max(seen), "MB")
        grown = statistics.median(seen[-quarter:]) - statistics.median(seen[quarter : 2 * quarter])
        yield Row(f"memory, growth from the second quarter of {photos} photos to the last", grown, "MB", 20.0)


def _jpeg(photo: Photo) -> bytes:
    return cv2.imencode(".jpg", photo.rgb[..., ::-1])[1].tobytes()


class _Studio:
    """``limner studio`` in processes of its own, entered with its token."""

    def __enter__(self) -> _Studio:
        command = [sys.executable, "-m", "limner", "studio", "--no-browser", "--json"]
        self._process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line:
            raise LimnerError("studio: it did not start; try limner studio")
        url = json.loads(line)["url"]
        found = re.fullmatch(r"http://([^/:]+):(\d+)(/.*)", url)
        assert found is not None
        self._host, self._port = found[1], int(found[2])
        self._cookie = self._asked("GET", found[3])[0].getheader("set-cookie", "").partition(";")[0]
        return self

    def __exit__(self, *_: object) -> None:
        self._process.send_signal(signal.SIGINT)
        try:
            self._process.wait(20)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        if self._process.stdout is not None:
            self._process.stdout.close()

    def _asked(self, method: str, path: str, body: bytes | None = None) -> tuple[http.client.HTTPResponse, bytes]:
        link = http.client.HTTPConnection(self._host, self._port, timeout=PATIENCE_S)
        try:
            link.request(method, path, body, {"Cookie": self._cookie} if hasattr(self, "_cookie") else {})
            answer = link.getresponse()
            return answer, answer.read()
        finally:
            link.close()

    def get(self, path: str) -> bytes:
        """What is there."""
        return self._asked("GET", path)[1]

    def post(self, photo: bytes) -> str:
        """Hand over a photo; its name."""
        answer, data = self._asked("POST", "/api/photo", photo)
        told = json.loads(data)
        if answer.status != 200 or not told["faces"]:
            raise LimnerError(f"studio: {told.get('error', 'no photo')}")
        return str(told["photo"])

    @contextmanager
    def live(self) -> Iterator[Any]:
        """Its live socket."""
        try:
            from websockets.sync.client import connect
            from websockets.typing import Origin
        except ImportError as error:
            raise MissingExtra("measuring the studio", "studio") from error
        base = f"{self._host}:{self._port}"
        headers = {"Cookie": self._cookie}
        with connect(
            f"ws://{base}/ws",
            origin=Origin(f"http://{base}"),
            additional_headers=headers,
            proxy=None,
            open_timeout=PATIENCE_S,
        ) as socket:
            yield socket

    def memory_mb(self) -> float:
        """Of the server and its computing processes; 0 where the system does not tell it as Linux does."""
        tasks = Path(f"/proc/{self._process.pid}/task")
        if not tasks.is_dir():
            return 0.0
        children = {child for path in tasks.glob("*/children") for child in _told(path).split()}
        return sum(_resident_mb(pid) for pid in [str(self._process.pid), *children])


def _resident_mb(pid: str) -> float:
    found = re.search(r"VmRSS:\s+(\d+) kB", _told(Path(f"/proc/{pid}/status")))
    return int(found[1]) / 1024 if found else 0.0


def _told(path: Path) -> str:
    """What the system tells of a process or thread; nothing when it has just ended."""
    try:
        return path.read_text()
    except OSError:
        return ""
