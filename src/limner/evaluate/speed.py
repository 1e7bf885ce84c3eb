"""A photo goes in; how long each stage takes and how much memory the command needs come out."""

from __future__ import annotations

import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import cv2
import numpy as np

from limner import pipeline
from limner.evaluate import machines
from limner.pipeline import Settings
from limner.types import Face, Photo
from limner.vision.cartoon.film import cartoon_frames
from limner.vision.landmarks.fmp.inference import SearchSettings, search
from limner.vision.landmarks.fmp.matlab import import_matlab
from limner.vision.lines import MEASURED, PICTURES

SMALL_PX = (640, 480)
LARGE_PX = (4000, 3000)
TALL_PX = (640, 800)
TALL_PX = (640, 800)


@dataclass(frozen=True)
class Row:
    """One figure: the median of several runs, beside the most it should be (None where nothing was promised)."""

    name: str
    value: float
    unit: str
    goal: float | None = None

    @property
    def reached(self) -> bool:
        """Whether the figure keeps what was promised."""
        return self.goal is None or self.value <= self.goal


CURVE_PX = ((640, 480), (1200, 900), (2000, 1500), (2828, 2121), LARGE_PX)
"""Photos of 0.3 to 12 megapixels."""

_AUTHORS = {"face_p146_small": 5.3, "face_p99": 4.9}
"""CPU seconds that the software of Zhu & Ramanan takes for 640x480 with each of its models."""

_SHARE = 0.2
"""Of that time, what ours may take."""


def measure_speed(photo: Photo, runs: int = 5, models: Path | None = None) -> Iterator[Row]:
    """Time ``draw`` warm and in this process, then the command in processes of its own.

    Args:
        photo: with a face; it is cut and scaled to 640x480 and to 12 megapixels.
        runs: of each figure, after one that is not counted.
        models: folder of the authors' face models (.mat), which are then timed too.

    Yields:
        One row after the other, as they are ready.

    Raises:
        BadInput: a model in the folder cannot be read.
        MissingExtra: models are given, but scipy, which reads them, is missing.
    """
    small, large = framed(photo, SMALL_PX), framed(photo, LARGE_PX)
    face = pipeline.find_faces(small)[0]
    yield Row("refine landmarks", _median_ms(partial(pipeline.refine_face, small, face), runs), "ms", 40.0)
    for style, goal in (("portrait", 500.0), ("canny", 150.0), ("gabor", 300.0)):
        settings = Settings(style=style)
        median = _median_ms(partial(pipeline.draw, small, settings, face=face), runs)
        yield Row(f"draw, face given, {style}, 640x480", median, "ms", goal)
    yield from _tonal(framed(photo, TALL_PX), runs)
    yield from _pictures(photo, small, runs)
    for name, picture in (("640x480", small), ("12 megapixels", large)):
        goal = 250.0 if picture is small else 600.0
        yield Row(f"find faces, {name}", _median_ms(partial(pipeline.find_faces, picture), runs), "ms", goal)
        yield Row(f"draw, {name}", _median_ms(partial(pipeline.draw, picture), runs), "ms")
    yield Row("limner --help, a process of its own", _median_ms(lambda: _run("--help"), runs), "ms", 400.0)
    yield from _plotters(small, face)
    yield from _curve(photo)
    yield from _authors(small, models, runs)


def _tonal(photo: Photo, runs: int) -> Iterator[Row]:
    """The styles that are made to measure, at 3000 points."""
    face = pipeline.find_faces(photo)[0]
    for style in MEASURED:
        settings = pipeline.changed(Settings(style=style), {"points": 3000})
        median = _median_ms(partial(pipeline.draw, photo, settings, face=face), runs, time.process_time)
        yield Row(f"draw, face given, {style}, 3000 points, 640x800, CPU", median, "ms", 5000.0)


def _pictures(photo: Photo, small: Photo, runs: int) -> Iterator[Row]:
    """The styles that have a picture in colours, and a frame of a film."""
    frame = partial(_one_frame, small)
    yield Row("limner film, a frame of 640x480", _median_ms(frame, runs), "ms", 100.0)
    tall = framed(photo, TALL_PX)
    face = pipeline.find_faces(tall)[0]
    for style in PICTURES:
        portrait = pipeline.draw(tall, face=face, style=style)
        yield Row(f"picture, {style}, 640x800", _median_ms(portrait.picture, runs), "ms", 5000.0)
        work = partial(pipeline.draw, tall, Settings(style=style), face=face)
        yield Row(f"draw, face given, {style}, 640x800", _median_ms(work, runs), "ms", 5000.0)


def _one_frame(photo: Photo) -> None:
    for _ in cartoon_frames(iter([photo.rgb]), Settings().cartoon.abstraction):
        pass


def _plotters(photo: Photo, face: Face) -> Iterator[Row]:
    """The planner's own time, and what it says of a portrait of 600 points."""
    yield Row(f"plan {machines.STROKES} strokes, CPU", 1000 * machines.planning_cpu_s(), "ms", 1000.0)
    for name, seconds in machines.drawing_s(pipeline.draw(photo, face=face, points=600).drawing):
        yield Row(f"{name} draws a portrait of 600 points", seconds, "s", 180.0)


def _curve(photo: Photo) -> Iterator[Row]:
    """Time and memory of the command, from small photos to large ones."""
    for size in CURVE_PX:
        name = f"limner draw, {size[0] * size[1] / 1e6:.1f}-megapixel JPEG, a process of its own"
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "photo.jpg"
            cv2.imwrite(str(path), cv2.cvtColor(framed(photo, size).rgb, cv2.COLOR_RGB2BGR))
            seconds, peak_mb = _command(path)
        yield Row(name, seconds * 1000, "ms")
        yield Row(f"{name}: peak memory", peak_mb, "MB", 600.0)


def _authors(photo: Photo, folder: Path | None, runs: int) -> Iterator[Row]:
    """CPU time of the search everywhere with the models of Zhu & Ramanan that are in the folder."""
    for name, seconds in _AUTHORS.items():
        path = folder / f"{name}.mat" if folder else None
        if path is None or not path.is_file():
            continue
        find = partial(search, photo.rgb, import_matlab(path), SearchSettings(threshold=-0.65, interval=5))
        goal = 1000 * seconds * _SHARE
        yield Row(f"{name}, everywhere, 640x480, CPU", _median_ms(find, runs, time.process_time), "ms", goal)


def framed(photo: Photo, size_px: tuple[int, int]) -> Photo:
    """The middle of a photo at another size, cut to its aspect."""
    width, height = photo.size_px
    scale = min(width / size_px[0], height / size_px[1])
    cut_w, cut_h = round(size_px[0] * scale), round(size_px[1] * scale)
    # The face of a portrait is in its upper half, so what is cut off is cut off below.
    x = (width - cut_w) // 2
    return Photo(
        np.asarray(cv2.resize(photo.rgb[:cut_h, x : x + cut_w], size_px, interpolation=cv2.INTER_AREA), np.uint8)
    )


def _median_ms(work: Callable[[], object], runs: int, clock: Callable[[], float] = time.perf_counter) -> float:
    work()
    times = []
    for _ in range(runs):
        start = clock()
        work()
        times.append(clock() - start)
    return 1000 * statistics.median(times)


def _run(*arguments: str) -> None:
    subprocess.run([sys.executable, "-m", "limner", *arguments], check=True, capture_output=True)


# Run in a process of its own, so that its children are the one command alone.
_WATCH = """
import resource, subprocess, sys, time
start = time.perf_counter()
subprocess.run([sys.executable, "-m", "limner", "draw", *sys.argv[1:]], check=True, capture_output=True)
peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
print(time.perf_counter() - start, peak / (2**20 if sys.platform == "darwin" else 2**10))
"""


def _command(photo: Path) -> tuple[float, float]:
    """Seconds and peak MB of ``limner draw``."""
    arguments = [sys.executable, "-c", _WATCH, str(photo), "-o", str(photo.with_suffix(".svg"))]
    done = subprocess.run(arguments, check=True, capture_output=True, text=True)
    seconds, peak_mb = map(float, done.stdout.split())
    return seconds, peak_mb
