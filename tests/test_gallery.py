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


def test_a_webp_shows_the_same_in_less_room(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Image.fromarray(PHOTO.rgb).save("a.png")
    for out in ("sheet.png", "sheet.webp", "again.webp"):
        args = ["evaluate", "gallery", "a.png", "--styles", "splines", "--width", "120", "-o", out]
        assert CliRunner().invoke(command, args, catch_exceptions=False).exit_code == 0
    one, other = (np.asarray(Image.open(name).convert("L"), float) for name in ("sheet.png", "sheet.webp"))
    assert one.shape == other.shape
    assert np.abs(one - other).mean() < 4
    assert (tmp_path / "sheet.webp").stat().st_size < 0.5 * (tmp_path / "sheet.png").stat().st_size
    assert (tmp_path / "sheet.webp").read_bytes() == (tmp_path / "again.webp").read_bytes()
    refused = CliRunner().invoke(command, ["evaluate", "gallery", "a.png", "-o", "sheet.bmp"])
    assert isinstance(refused.exception, limner.BadInput)
    assert ".png or .webp" in str(refused.exception)
