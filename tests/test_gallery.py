"""A gallery shows each photo beside its drawings, and refuses what it cannot draw in one line."""

from __future__ import annotations

import json

import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image

import limner
from limner.cli import limner as command
from limner.evaluate.gallery import gallery
from limner.pipeline import Settings
from limner.vision.landmarks.detectors import DETECTORS
from portraits import astronaut

PHOTO, FACE = astronaut()


@pytest.fixture(autouse=True)
def face_found(monkeypatch):
    monkeypatch.setitem(DETECTORS, "fmp", DETECTORS["fmp"]._replace(detect=lambda photo, settings: (FACE,)))


def test_each_row_is_the_photo_and_its_drawings():
    (row,) = gallery([PHOTO], ["splines", "portrait"], Settings())
    assert [tile.title for tile in row] == ["photo", "splines", "portrait"]
    photo, splines, portrait = (tile.rgb for tile in row)
    assert photo.shape == splines.shape == portrait.shape
    assert (portrait < 128).mean() > (splines < 128).mean() > 0


def test_the_command_writes_one_sheet(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Image.fromarray(PHOTO.rgb).save("a.png")
    args = ["evaluate", "gallery", "a.png", "a.png", "--styles", "splines", "--width", "80", "--json"]
    ran = CliRunner().invoke(command, args, catch_exceptions=False)
    assert json.loads(ran.stdout) == {"out": ["gallery.png"], "photos": 2, "styles": ["splines"]}
    with Image.open("gallery.png") as sheet:
        assert sheet.width > 4 * 80
        assert np.asarray(sheet.convert("L")).std() > 5


def test_an_unknown_style_is_refused(tmp_path):
    with pytest.raises(limner.BadInput, match="oil"):
        next(gallery([PHOTO], ["oil"], Settings()))
