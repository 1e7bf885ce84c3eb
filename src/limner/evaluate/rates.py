"""A photo goes in; how many such photos a minute ``limner batch`` draws, and what it costs beside drawing, come out."""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from limner.errors import CannotDraw
from limner.types import Photo

_PATIENCE_S = 60.0

_WITHOUT_PROFILER = {"DASK_DISTRIBUTED__WORKER__PROFILE__ENABLED": "False"}
"""What Dask's workers are told at their start: their profiler looks on a hundred times a second."""


@dataclass(frozen=True)
class Rate:
    """A way to draw many photos.

    Attributes:
        name: of it.
        per_minute: photos, once all processes run.
        cpu_s: time of a core that drawing one takes, which a busy machine changes little.
        peak_mb: memory of the worker that needed most.
    """

    name: str
    per_minute: float
    cpu_s: float
    peak_mb: float


@dataclass(frozen=True)
class Overhead:
    """What a batch costs beside drawing, measured on tiny pictures without a face.

    Attributes:
        photos: how many.
        ms_each: CPU time of the process that gives them out, for each.
        restart_s: CPU time of a run that finds all of them done.
    """

    photos: int
    ms_each: float
    restart_s: float


def rates(photo: Photo, count: int) -> Iterator[Rate]:
    """Draw photos like this one, all a little different, by one and two workers and by a local Dask cluster of two.

    Args:
        photo: with a face.
        count: how many.
    """
    with tempfile.TemporaryDirectory() as folder:
        photos = _put(photo, count, Path(folder) / "in")
        for name, extra in (("1 worker", ["--workers", "1"]), ("2 workers", ["--workers", "2"])):
            yield _rate(name, photos, Path(folder) / name, extra)
        with local_cluster(2, Path(folder)) as address:
            yield _rate("Dask cluster of 2 here", photos, Path(folder) / "cluster", ["--scheduler", address])


def overhead(count: int) -> Overhead:
    """Run over tiny pictures, and again."""
    with tempfile.TemporaryDirectory() as folder:
        photos = Path(folder) / "in"
        photos.mkdir()
        for k in range(count):
            picture = np.random.default_rng(k).integers(0, 256, (16, 16, 3), np.uint8)
            cv2.imwrite(str(photos / f"{k:06}.png"), picture)
        first = run_batch(photos, Path(folder) / "out", "--workers", "1")
        again = run_batch(photos, Path(folder) / "out", "--workers", "1")
    # Starting costs the same in both.
    return Overhead(count, 1000 * (first["cpu_s"] - again["cpu_s"]) / count, again["cpu_s"])


def run_batch(photos: Path, out: Path, *extra: str) -> dict[str, Any]:
    """The report of ``limner batch`` over a folder."""
    command = [sys.executable, "-m", "limner", "batch", str(photos), "-o", str(out), "--json", "--sheet", "0", *extra]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    report: dict[str, Any] = json.loads(done.stdout)
    return report


@contextlib.contextmanager
def local_cluster(workers: int, folder: Path) -> Iterator[str]:
    """The address of a Dask scheduler with so many workers of one thread, all on this machine and all there.

    Raises:
        CannotDraw: it does not come up.
    """
    file = folder / "scheduler.json"
    here = ["--host", "127.0.0.1", "--no-dashboard"]
    scheduler = [*_dask("scheduler"), *here, "--port", "0", "--scheduler-file", str(file)]
    worker = [
        *_dask("worker"),
        *here,
        "--scheduler-file",
        str(file),
        "--nthreads",
        "1",
        "--local-directory",
        str(folder),
    ]
    with contextlib.ExitStack() as running:
        running.enter_context(_ended(scheduler))
        for _ in range(workers):
            running.enter_context(_ended(worker))
        address = _address(file)
        _wait_for(address, workers)
        yield address


def _dask(part: str) -> list[str]:
    return [sys.executable, "-m", f"distributed.cli.dask_{part}"]


@contextlib.contextmanager
def _ended(command: list[str]) -> Iterator[None]:
    process = subprocess.Popen(
        command, env=os.environ | _WITHOUT_PROFILER, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    try:
        yield
    finally:
        process.terminate()
        process.wait()


def _address(file: Path) -> str:
    end = time.monotonic() + _PATIENCE_S
    while time.monotonic() < end:
        with contextlib.suppress(OSError, ValueError):
            return str(json.loads(file.read_text())["address"])
        time.sleep(0.1)
    raise CannotDraw(f"the local Dask cluster did not start within {_PATIENCE_S:.0f} s")


# A batch that begins before the last worker has come is not one by all of them. In a process of its own, since it needs
# what only the cluster needs.
_WAIT = """
import sys
from distributed import Client
seconds = float(sys.argv[3])
Client(sys.argv[1], timeout=seconds).wait_for_workers(int(sys.argv[2]), timeout=seconds)
"""


def _wait_for(address: str, workers: int) -> None:
    arguments = [address, str(workers), str(_PATIENCE_S)]
    done = subprocess.run([sys.executable, "-c", _WAIT, *arguments], capture_output=True, check=False)
    if done.returncode:
        raise CannotDraw(f"the local Dask cluster's workers did not start within {_PATIENCE_S:.0f} s")


def _rate(name: str, photos: Path, out: Path, extra: list[str]) -> Rate:
    report = run_batch(photos, out, *extra)
    each = report["draw_cpu_s"] / max(report["drawn"], 1)
    return Rate(name, report["steady_per_minute"], each, report["peak_mb"])


def _put(photo: Photo, count: int, folder: Path) -> Path:
    folder.mkdir()
    for k in range(count):
        darker = (photo.rgb * (1 - 0.2 * k / max(count, 1))).astype(np.uint8)
        cv2.imwrite(str(folder / f"{k:04}.jpg"), darker[..., ::-1])
    return folder
