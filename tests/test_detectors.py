"""The registry of detectors, and the choice of the face to draw."""

import numpy as np
import pytest

from limner.errors import BadInput, NoFace
from limner.settings import read_toml, write_toml
from limner.storage import save
from limner.types import Face, Photo
from limner.vision.landmarks import DETECTORS, DetectSettings, choose, detect

PHOTO = Photo(np.zeros((300, 400, 3), np.uint8))
FACES = tuple(Face(np.random.default_rng(k).uniform(0, 90, (68, 2)), [0, 0, 90, 90 - k]) for k in range(2))
FROM_FILE = DetectSettings(detector="file", file="face.json")


def test_every_detector_can_be_chosen_and_no_other():
    (choices,) = (about.choices for path, about, _ in DetectSettings.walk() if path == "detector")
    assert set(choices) == set(DETECTORS)


def test_settings_survive_toml():
    settings = DetectSettings().assign("fmp.refine", "1").assign("file", "me.pts")
    assert read_toml(DetectSettings, write_toml(settings)) == settings


def test_the_file_detector_reads_its_file(tmp_path):
    save(FACES[0], tmp_path / "face.json")
    assert detect(PHOTO, FROM_FILE.replace(file=str(tmp_path / "face.json"))) == FACES[:1]
    with pytest.raises(BadInput, match="no file given"):
        detect(PHOTO, DetectSettings(detector="file"))


def test_faces_are_counted_from_one():
    assert choose(FACES, 1, PHOTO, FROM_FILE) is FACES[0]
    assert choose(FACES, 2, PHOTO, FROM_FILE) is FACES[1]


@pytest.mark.parametrize("number", [0, -1])
def test_there_is_no_face_zero(number):
    with pytest.raises(BadInput, match=f"face {number}: expected 1"):
        choose(FACES, number, PHOTO, FROM_FILE)


def test_a_face_too_many_says_how_many_there_are():
    with pytest.raises(NoFace, match=r"no face 3: 2 faces were found.*--face 1 to 2"):
        choose(FACES, 3, PHOTO, FROM_FILE)
    with pytest.raises(NoFace, match="no face 2: 1 face was found"):
        choose(FACES[:1], 2, PHOTO, FROM_FILE)


def test_no_face_says_what_was_looked_for_and_what_helps(shared):
    fmp = DetectSettings().fmp.replace(model=str(shared / "data/zhu-ramanan/face_p146_small.mat"))
    settings = DetectSettings(fmp=fmp)
    assert detect(PHOTO, settings) == ()
    with pytest.raises(NoFace) as caught:
        choose((), 1, PHOTO, settings)
    assert "turned -90 to +90 degrees" in str(caught.value)
    assert "40 px or more" in str(caught.value)
    assert "--crop x,y,w,h" in str(caught.value)
    assert "\n" not in str(caught.value)
