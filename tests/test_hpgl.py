"""HP-GL says what the drawing is: replayed by our reader, and drawn by Debian's hp2xx."""

from __future__ import annotations

import contextlib
import shutil
import subprocess

import numpy as np
import pytest
from hypothesis import given, strategies as st
from PIL import Image

from drawings import drawings, of
from limner.errors import BadInput
from limner.targets.hpgl import POINTS_PER_WORD, UNITS_PER_MM, to_hpgl, to_units
from limner.targets.hpgl_read import read_hpgl
from limner.targets.image import to_rgb


@given(drawings())
def test_replayed_it_is_the_drawing(drawing):
    data = to_hpgl(drawing)
    back = read_hpgl(data, drawing.page)
    assert back.page == drawing.page
    assert len(back.lines_mm) == len(drawing.lines_mm)
    for got, line in zip(back.lines_mm, drawing.lines_mm, strict=True):
        assert np.array_equal(got * UNITS_PER_MM, to_units(line))
        assert np.abs(got[[0, -1]] - line[[0, -1]]).max() <= 0.5 / UNITS_PER_MM + 1e-9
    assert to_hpgl(back) == data


def test_as_it_stands():
    drawing = of([[10, 20], [30, 20.001], [30, 20]], [[5, 5]])
    assert to_hpgl(drawing) == b"IN;SP1;PA;\nPU400,800;\nPD1200,800;\nPU200,200;\nPD;\nPU0,0;SP0;\n"


def test_long_lines_are_said_in_several_words():
    line = np.cumsum(np.ones((500, 2)), axis=0)
    words = to_hpgl(of(line)).decode().split(";")
    assert max(len(word.split(",")) for word in words) <= 2 * POINTS_PER_WORD
    assert np.array_equal(read_hpgl(to_hpgl(of(line))).lines_mm[0], line)


def test_another_makes_hpgl():
    text = b'IN;IP;CO "a drawing; PD9,9";SP 1;pu 40 40;PD80,40,80,80PR;PD40,0;PU;LBno PD1,2;\x03PA40,40;VS10;PD;PU;SP;'
    got = read_hpgl(text)
    assert [line.tolist() for line in got.lines_mm] == [[[1, 1], [2, 1], [2, 2], [3, 2]], [[1, 1]]]
    assert (got.page.width_mm, got.page.height_mm) == (105, 148)


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"\x00\x01", "byte 0"),
        (b"IN;PD1,2,3;", "pairs"),
        (b"IN;SC0,1,0,1;", "scaling"),
        (b"IN;PE<=;", "no HP-GL|encoded"),
        (b"LBendless", "no HP-GL|byte"),
    ],
)
def test_what_is_not_understood_is_named(data, words):
    with pytest.raises(BadInput, match=words):
        read_hpgl(data)


@given(st.binary(max_size=200))
def test_any_bytes_are_read_or_refused(data):
    with contextlib.suppress(BadInput):
        read_hpgl(data)


def test_hp2xx_draws_the_same(tmp_path):
    if shutil.which("hp2xx") is None:
        pytest.skip("needs hp2xx; run: apt-get install hp2xx")
    turns = np.linspace(0, 6 * np.pi, 200)
    spiral = 60 + (turns * 2)[:, None] * np.stack([np.cos(turns), np.sin(turns)], axis=1)
    drawing = of([[20, 20], [120, 20], [120, 190], [20, 20]], spiral)
    (tmp_path / "a.hpgl").write_bytes(to_hpgl(drawing))
    # True size, 5 pixels per mm, pen of 0.5 mm, in a frame of the drawing's own extent.
    size = ["-t", "-d", "127", "-p", "5", "-c", "1"]
    command = ["hp2xx", "-q", "-m", "pbm", *size, "-f", str(tmp_path / "a.pbm"), str(tmp_path / "a.hpgl")]
    subprocess.run(command, check=True, capture_output=True)
    with Image.open(tmp_path / "a.pbm") as picture:
        theirs = np.asarray(picture.convert("L")) < 128
    ours = to_rgb(drawing, 5.0)[..., 0] < 128
    rows, columns = np.flatnonzero(theirs.any(axis=1)), np.flatnonzero(theirs.any(axis=0))
    theirs = theirs[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    rows, columns = np.flatnonzero(ours.any(axis=1)), np.flatnonzero(ours.any(axis=0))
    ours = ours[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    assert np.abs(np.subtract(theirs.shape, ours.shape)).max() <= 4
    height, width = np.minimum(theirs.shape, ours.shape)
    near = to_near(theirs[:height, :width]), to_near(ours[:height, :width])
    assert near[0][ours[:height, :width]].mean() > 0.99
    assert near[1][theirs[:height, :width]].mean() > 0.99


def to_near(mask):
    """The mask, grown by 3 pixels (0.6 mm) each way."""
    import cv2

    return cv2.dilate(mask.astype(np.uint8), np.ones((7, 7), np.uint8)) > 0
