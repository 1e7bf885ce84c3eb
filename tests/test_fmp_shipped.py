"""The face model that ships: it finds whom it should, nobody where there is nobody, and says where it comes from."""

import importlib.resources as resources

import cv2
import numpy as np
import pytest

from limner.evaluate.false_alarms import count_false_alarms, pictures_without_face
from limner.evaluate.landmarks import INNER, evaluate_landmarks
from limner.types import Photo
from limner.vision.landmarks.fmp.dataset import read_folder
from limner.vision.landmarks.fmp.detector import FmpSettings, detect
from limner.vision.landmarks.fmp.examples import silent
from limner.vision.landmarks.fmp.model import default_model
from limner.vision.landmarks.fmp.scenes import read_image, sample_pictures, textures

PACKAGE = resources.files("limner.vision.landmarks.fmp")


def shipped(photo):
    return detect(photo, FmpSettings())


@pytest.fixture(scope="module")
def astronaut():
    data = pytest.importorskip("skimage.data", reason="needs scikit-image: pip install 'limner[demo]'")
    return Photo(data.astronaut())


def test_finds_the_astronaut_and_nothing_else(astronaut):
    (face,) = shipped(astronaut)
    assert face.frontal
    # Her outer eye corners, nose tip and mouth corners, by eye [px].
    by_eye = {36: (192, 101), 45: (259, 103), 30: (222, 126), 48: (204, 141), 54: (245, 141)}
    for mark, place in by_eye.items():
        assert np.hypot(*(face.points_px[mark] - place)) < 0.1 * face.outer_eye_px


@pytest.mark.parametrize("scale", [0.6, 1.0, 2.0])
def test_the_size_of_the_photo_does_not_matter(astronaut, scale):
    size = (int(512 * scale), int(512 * scale))
    rgb = cv2.resize(astronaut.rgb, size, interpolation=cv2.INTER_AREA if scale < 1 else cv2.INTER_CUBIC)
    (face,) = shipped(Photo(rgb))
    (same,) = shipped(astronaut)
    off = np.hypot(*(face.points_px / scale - same.points_px).T).mean() / same.outer_eye_px
    assert off < 0.03


def test_a_mirrored_photo_gives_mirrored_landmarks(astronaut):
    from limner.vision.landmarks.mirror import MIRROR

    (face,) = shipped(Photo(astronaut.rgb[:, ::-1]))
    (same,) = shipped(astronaut)
    back = (face.points_px * [-1, 1] + [511, 0])[MIRROR]
    assert np.hypot(*(back - same.points_px).T).mean() / same.outer_eye_px < 0.04


def test_sees_no_face_where_there_is_none():
    pictures = [*textures(6, 12345, 300), *sample_pictures()[:4]]
    assert count_false_alarms(shipped, pictures, "shipped", silent).found == ()


def test_a_photo_without_a_face_has_none():
    assert shipped(Photo(np.full((200, 300, 3), 128, np.uint8))) == ()


def test_is_small_and_says_where_it_comes_from():
    assert len((PACKAGE / "frontal.npz").read_bytes()) <= 4 * 2**20
    card = (PACKAGE / "MODEL_CARD.md").read_text()
    for needed in ("DeBruine", "CC BY 4.0", "limner train fmp"):
        assert needed in card
    faces = default_model().meta["faces"]
    assert faces == {"london/images": 78, "london/smiling": 78, "canada/images": 30, "inter-faces-cc0/images": 58}
    for reached in default_model().meta["rounds"]:
        assert 0 <= reached["gap"] <= default_model().meta["settings"]["gap"]


def check(samples, most_percent):
    report = evaluate_landmarks("shared", samples, shipped)
    assert report.found == len(samples)
    assert report.wrong == 0
    assert report.error_percent() < most_percent


@pytest.mark.parametrize("folder", ["london", "canada"])
def test_finds_a_sample_of_the_people_it_learned_from(shared, folder):
    samples, _ = read_folder(shared / "data" / folder)
    check(samples[3::25], 3.5)


@pytest.mark.slow
@pytest.mark.parametrize("folder", ["london", "canada"])
def test_finds_everybody_it_learned_from(shared, folder):
    check(read_folder(shared / "data" / folder)[0], 3.0)


@pytest.mark.slow
def test_finds_people_of_all_kinds(shared):
    """Free portraits with glasses, beards, hats, turned heads, which it learned from; labels by a face mesh."""
    samples, _ = read_folder(shared / "data" / "inter-faces-cc0")
    samples = [sample for sample in samples if abs(sample.yaw_deg) <= 30]
    report = evaluate_landmarks("inter-faces", samples, shipped)
    assert report.found >= 0.9 * len(samples)
    assert report.wrong == 0
    assert report.error_percent(INNER) <= 6


@pytest.mark.slow
def test_finds_one_face_in_each_demo_photo(shared):
    paths = sorted((shared / "data" / "demo").glob("*_*.*g"))
    found = {path.stem: len(shipped(Photo(read_image(path)))) for path in paths}
    assert len(found) == 18
    assert set(found.values()) == {1}


@pytest.mark.parametrize("tilt_deg", [-25, -12, 12, 25])
def test_a_tilted_face_has_the_landmarks_of_the_upright_one(astronaut, tilt_deg):
    turn = cv2.getRotationMatrix2D((255.5, 255.5), tilt_deg, 1.0)
    (same,) = shipped(astronaut)
    (face,) = shipped(Photo(cv2.warpAffine(astronaut.rgb, turn, (512, 512), borderMode=cv2.BORDER_REPLICATE)))
    back = (face.points_px - turn[:, 2]) @ np.linalg.inv(turn[:, :2]).T
    assert np.hypot(*(back - same.points_px).T).mean() / same.outer_eye_px < 0.04


@pytest.mark.slow
def test_sees_no_face_in_all_the_pictures_without_one():
    pictures = pictures_without_face()
    assert len(pictures) >= 200
    assert count_false_alarms(shipped, pictures[::6], "shipped", silent).found == ()
