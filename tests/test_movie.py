"""A film ends with the drawing itself, shows each stroke when the pen draws it, and opens in independent readers."""

from __future__ import annotations

import io
from xml.etree import ElementTree

import cv2
import numpy as np
import pytest
from PIL import Image

from drawings import of
from limner.errors import BadInput
from limner.motion.machine import load_machine
from limner.motion.pen import plan
from limner.targets.animation import HOLD_PART, stroke_times, to_animated_svg
from limner.targets.image import to_rgb
from limner.targets.movie import HOLD_S, LONGEST_PX, frames, to_gif, to_mp4

DRAWING = of([[30, 30], [120, 30], [120, 180]], [[40, 60]], [[40, 100], [90, 150]])
PATH = plan(DRAWING, load_machine("axidraw"))


def ink(picture):
    return int((np.asarray(picture.convert("L") if isinstance(picture, Image.Image) else picture[..., 1]) < 100).sum())


def test_it_ends_with_the_whole_drawing_and_only_gains_ink():
    pictures = list(frames(DRAWING, PATH, 1.0, 20))
    assert len(pictures) == 20
    want = to_rgb(DRAWING, LONGEST_PX / DRAWING.page.height_mm)
    assert np.abs(pictures[-1].astype(int) - want).mean() < 1
    amounts = [(picture.max(axis=2) < 100).sum() for picture in pictures]
    assert (np.diff(amounts) >= 0).all()
    assert amounts[0] == 0


def test_a_stroke_is_there_when_the_pen_has_drawn_it():
    begin, end = stroke_times(PATH, 3)
    assert (begin <= end).all()
    assert (begin[1:] > end[:-1]).all()
    half = (begin[0] + end[0]) / 2 / PATH.t_s[-1]
    pictures = list(frames(DRAWING, PATH, 10, 20))
    drawn = pictures[round(half * (len(pictures) - 1))]
    length = (drawn.max(axis=2) < 100).sum() / (pictures[-1].max(axis=2) < 100).sum()
    assert 0.3 < length < 0.5  # 120 of 311 mm


def test_gif():
    film = Image.open(io.BytesIO(to_gif(DRAWING, PATH, 1.0)))
    assert film.info["loop"] == 0
    total = 0
    for k in range(film.n_frames):
        film.seek(k)
        total += film.info["duration"]
    assert total == pytest.approx(1000 + HOLD_S * 1000, abs=100)
    assert ink(film) == pytest.approx(ink(list(frames(DRAWING, PATH, 1.0, 20))[-1]), rel=0.05)
    assert to_gif(DRAWING, PATH, 1.0) == to_gif(DRAWING, PATH, 1.0)


def test_mp4(tmp_path):
    (tmp_path / "a.mp4").write_bytes(to_mp4(DRAWING, PATH, 1.0))
    film = cv2.VideoCapture(str(tmp_path / "a.mp4"))
    count = int(film.get(cv2.CAP_PROP_FRAME_COUNT))
    assert count / film.get(cv2.CAP_PROP_FPS) == pytest.approx(1 + HOLD_S, abs=0.1)
    pictures = [film.read()[1] for _ in range(count)]
    film.release()
    assert ink(pictures[-1]) == pytest.approx(ink(list(frames(DRAWING, PATH, 1.0, 30))[-1]), rel=0.1)
    assert ink(pictures[0]) < 200


def test_animated_svg():
    root = ElementTree.fromstring(to_animated_svg(DRAWING, PATH, 10.0))
    name = "{http://www.w3.org/2000/svg}"
    paths = root.findall(f".//{name}path")
    assert len(paths) == 3
    begin, end = stroke_times(PATH, 3)
    for k, path in enumerate(paths):
        moves = {a.get("attributeName"): a for a in path.findall(f"{name}animate")}
        assert moves["visibility"].get("dur") == f"{10 / (1 - HOLD_PART):.6g}s"
        if k == 1:
            assert "stroke-dashoffset" not in moves, "a dot has no length to grow"
            continue
        times = [float(t) for t in moves["stroke-dashoffset"].get("keyTimes").split(";")]
        assert times == sorted(times)
        assert times[1] == pytest.approx(begin[k] / PATH.t_s[-1] * (1 - HOLD_PART), abs=1e-5)
        assert times[2] == pytest.approx(end[k] / PATH.t_s[-1] * (1 - HOLD_PART), abs=1e-5)


@pytest.mark.parametrize("make", [to_gif, to_mp4, to_animated_svg])
def test_degenerate_drawings_have_a_film(make):
    for drawing in (of(), of([[5, 5]]), of([[5, 5], [5, 5]])):
        assert make(drawing, plan(drawing, load_machine("grbl")), 0.2)


@pytest.mark.parametrize("seconds", [0, -1, float("nan"), 1e9])
def test_its_length_is_checked(seconds):
    for make in (to_gif, to_mp4, to_animated_svg):
        with pytest.raises(BadInput, match="movie"):
            make(DRAWING, PATH, seconds)
