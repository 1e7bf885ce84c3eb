"""A photo with its face goes in; what limner and others make of it, in how much time, comes out side by side."""

from __future__ import annotations

import subprocess
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from limner import pipeline
from limner.drawing.compose import ComposeSettings, compose, page_from_photo
from limner.drawing.measure import measure
from limner.evaluate.strokes import through_vpype, vpype_program
from limner.targets.svg_read import read_svg
from limner.types import Drawing, Face, Floats, Page, Pen, Photo, Strokes
from limner.vision.likeness.model import shipped_likeness

_FEWEST_PX = 10
_TOLERANCE_PX = 1.0


@dataclass(frozen=True)
class Peer:
    """One way from a photo to strokes.

    Attributes:
        name: of it.
        seconds: from the loaded photo to the ordered drawing; processes that it starts included.
        strokes, points: of the drawing on A5.
        ink_mm, travel_mm: pen-down and pen-up length.
        likeness: how much of the person is in it, 0 to 1, by limner's own measure; None where not to be had.
    """

    name: str
    seconds: float
    strokes: int
    points: int
    ink_mm: float
    travel_mm: float
    likeness: float | None


def peers(photo: Photo) -> Iterator[Peer]:
    """limner, and of the others those whose programs are installed.

    Args:
        photo: with a face.
    """
    portrait = pipeline.draw(photo)
    start = time.perf_counter()
    portrait = pipeline.draw(photo)
    yield _peer("limner", time.perf_counter() - start, portrait.drawing, portrait.likeness)
    if program := vpype_program():
        yield _canny(photo, portrait.face)
        yield from _hatched(photo, program)


def _canny(photo: Photo, face: Face) -> Peer:
    start = time.perf_counter()
    strokes = canny_contours(photo)
    drawing = through_vpype(compose(strokes, Page(), ComposeSettings(), Pen()))
    seconds = time.perf_counter() - start
    affine = page_from_photo(strokes, Page(), ComposeSettings(), Pen())
    scale = float(affine[0, 0])
    ink = tuple(_to_photo(line, affine, drawing.page.height_mm) for line in drawing.lines_mm)
    likeness = shipped_likeness().likeness(photo, face, ink, drawing.pen.width_mm / scale)
    return _peer("OpenCV Canny, findContours, vpype linemerge linesort", seconds, drawing, likeness)


def _to_photo(line: Floats, affine: Floats, height_mm: float) -> Floats:
    place: Floats = ([0, height_mm] + line * [1, -1] - affine[:, 2]) / affine[0, 0]
    return place


def canny_contours(photo: Photo) -> Strokes:
    """What tutorials do: blur, Canny about the median grey, contours of the edges, the short ones left out."""
    grey = cv2.GaussianBlur(cv2.cvtColor(photo.rgb, cv2.COLOR_RGB2GRAY), (5, 5), 0)
    middle = float(np.median(grey))
    edges = cv2.Canny(grey, 0.67 * middle, min(255.0, 1.33 * middle))
    found, _ = cv2.findContours(edges, cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE)
    kept = [cv2.approxPolyDP(line, _TOLERANCE_PX, False)[:, 0] for line in found if len(line) >= _FEWEST_PX]
    lines = tuple(line.astype(np.float64) for line in kept)
    return Strokes(lines, ("face",) * len(lines), np.ones(len(lines)), photo.size_px)


def _hatched(photo: Photo, program: str) -> Iterator[Peer]:
    """The plug-in ``hatched``, which shades whole pictures, where vpype has it."""
    with tempfile.TemporaryDirectory() as folder:
        given, made = Path(folder) / "photo.png", Path(folder) / "made.svg"
        cv2.imwrite(str(given), photo.rgb[..., ::-1])
        start = time.perf_counter()
        command = [program, "hatched", str(given), "linemerge", "linesort", "write", "--page-size", "a5", str(made)]
        if subprocess.run(command, capture_output=True).returncode == 0:
            yield _peer("vpype hatched linemerge linesort", time.perf_counter() - start, read_svg(made), None)


def _peer(name: str, seconds: float, drawing: Drawing, likeness: float | None) -> Peer:
    costs = measure(drawing)
    return Peer(name, seconds, costs.strokes, costs.points, costs.ink_mm, costs.travel_mm, likeness)
