"""``limner face --refine`` and what drawing makes of refined landmarks."""

from __future__ import annotations

import json

import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image

import limner
from limner import storage
from limner.cli import limner as command
from limner.pipeline import refine_face, refinements
from portraits import astronaut


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """The astronaut's photo, and her landmarks a little off in a file."""
    folder = tmp_path_factory.mktemp("astronaut")
    photo, face = astronaut()
    points = face.points_px + np.array([2.0, -1.5])
    off = limner.Face(points, face.box_px)
    Image.fromarray(photo.rgb).save(folder / "photo.png")
    (folder / "face.json").write_text(json.dumps({"faces": [storage.to_fields(off)]}))
    return folder / "photo.png", folder / "face.json", off


def face(files, *arguments):
    photo, landmarks, _ = files
    line = ["face", str(photo), "--landmarks", str(landmarks), *map(str, arguments)]
    return CliRunner().invoke(command, line, catch_exceptions=True)


def points(ran):
    assert ran.exit_code == 0, ran.output
    return np.array(json.loads(ran.stdout)["faces"][0]["points_px"])


def test_landmarks_from_a_file_stay_unless_asked(files):
    assert np.array_equal(points(face(files, "--json")), files[2].points_px)
    assert np.array_equal(points(face(files, "--refine", "none", "--json")), files[2].points_px)
    assert not np.array_equal(points(face(files, "--refine", "best", "--json")), files[2].points_px)


def test_a_sequence_moves_what_each_of_it_moves(files):
    moved = (points(face(files, "--refine", "brows,jaw-spline", "--json")) != files[2].points_px).any(axis=1)
    assert not moved[27:].any()
    assert moved[:17].any()
    assert moved[17:27].any()


def test_the_sheet_of_candidates_is_a_picture(files, tmp_path):
    ran = face(files, "--refine-compare", tmp_path / "sheet.png")
    assert ran.exit_code == 0
    assert "landmarks as they were found" in ran.stderr
    with Image.open(tmp_path / "sheet.png") as sheet:
        assert sheet.size[0] > 1000


def test_the_move_is_told(files):
    assert "best: landmarks moved by" in face(files, "--refine", "best").stderr


@pytest.mark.parametrize("names", ["bets", "brows;jaw-spline"])
def test_an_unknown_correction_is_refused(files, names):
    ran = face(files, "--refine", names)
    assert isinstance(ran.exception, limner.BadInput)
    assert "choose from best, jaw-gradient" in str(ran.exception)


def test_draw_refines_a_found_face_but_not_a_given_one():
    photo, known = astronaut()
    off = limner.Face(known.points_px + np.array([2.0, -1.5]), known.box_px)
    assert limner.draw(photo, face=off).face == off
    assert limner.refine_face(photo, off) != off


def test_auto_is_best_except_for_a_file():
    assert refinements(limner.Settings()) == "best"
    assert refinements(limner.Settings().assign("detect.detector", "file")) == "none"
    assert refinements(limner.Settings(refine="brows")) == "brows"
    photo, known = astronaut()
    assert refine_face(photo, known, limner.Settings(refine="none")) is known
