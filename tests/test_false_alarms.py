"""Pictures without a face: enough of them, always the same, and a detector's every find among them is counted."""

import numpy as np
import pytest

from limner.evaluate import false_alarms
from limner.evaluate.false_alarms import CHANGES, EMPTY_PARTS, count_false_alarms, pictures_without_face
from limner.evaluate.made_pictures import KINDS, made_picture
from limner.types import Face
from limner.vision.landmarks import mediapipe
from limner.vision.landmarks.fmp.scenes import SAMPLE_PICTURES
from limner.vision.landmarks.mediapipe import MediapipeSettings

FACE = Face(np.random.default_rng(0).uniform(0, 90, (68, 2)), [0, 0, 90, 90], 1.5)


def silent(*told):
    pass


@pytest.fixture(scope="module")
def pictures():
    pytest.importorskip("skimage", reason="needs scikit-image: pip install 'limner[demo]'")
    return pictures_without_face()


def test_there_are_more_than_two_hundred_and_each_is_another(pictures):
    assert len(pictures) >= 200
    assert len({picture.name for picture in pictures}) == len(pictures)
    seen = set()
    for picture in pictures:
        image = picture.read()
        assert image.dtype == np.uint8
        assert image.shape[2] == 3
        assert 100 <= max(image.shape[:2]) <= 480
        seen.add(image.tobytes())
    # Parts of a picture that is black for the most part may be the same.
    assert len(seen) > len(pictures) - 8
    assert all(len(picture.faces_px) == 0 for picture in pictures)


def test_the_seed_decides(pictures):
    chosen = [k for k, picture in enumerate(pictures) if "coffee" in picture.name or "made 3" in picture.name]
    again, others = pictures_without_face(), pictures_without_face(seed=1)
    for k in chosen:
        image = pictures[k].read()
        assert np.array_equal(image, again[k].read())
        other = others[k].read()
        assert (image.shape == other.shape and np.array_equal(image, other)) == (pictures[k].name == "coffee.png")


def test_who_is_to_be_seen_in_a_sample_picture_is_cut_off(pictures):
    names = {picture.name for picture in pictures}
    assert set(SAMPLE_PICTURES) <= names
    for name in EMPTY_PARTS:
        (whole,) = (picture.read() for picture in pictures if picture.name == name)
        assert whole.shape[0] < 400


def test_parts_and_made_pictures_are_of_every_kind():
    rng, picture = np.random.default_rng(1), made_picture(0, np.random.default_rng(2), 200)
    for change in CHANGES:
        changed = change(picture, rng)
        assert changed.dtype == np.uint8
        assert changed.ndim == 3
        assert min(changed.shape[:2]) > 100
    for kind in range(len(KINDS)):
        made = made_picture(kind, np.random.default_rng(kind), 200)
        assert made.shape == (200, 200, 3)
        assert made.std() > 4


def test_every_find_is_counted_with_its_place(pictures):
    told = []
    few = pictures[:5]
    report = count_false_alarms(
        lambda photo: (FACE, FACE) if photo.size_px[0] == few[1].read().shape[1] else (),
        few,
        "x",
        lambda *a: told.append(a),
    )
    row = report.row()
    width = few[1].read().shape[1]
    hit = [picture.name for picture in few if picture.read().shape[1] == width]
    assert row["pictures"] == 5
    assert row["false_alarms"] == 2 * len(hit) == len(row["in"])
    assert {place["picture"] for place in row["in"]} == set(hit)
    assert {place["score"] for place in row["in"]} == {1.5}
    assert told[-1][:3] == ("x", 5, 5)
    assert count_false_alarms(lambda photo: (), few, "x", silent).row()["false_alarms"] == 0


def test_without_scikit_image_the_install_line_is_given(monkeypatch):
    monkeypatch.setattr(false_alarms.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(false_alarms.MissingExtra, match=r"pip install 'limner\[demo\]'"):
        pictures_without_face()


@pytest.mark.slow
def test_the_mesh_raises_no_false_alarm(pictures, shared):
    settings = MediapipeSettings(
        model=str(shared / "data/models/mediapipe/face_landmark.tflite"),
        boxes=str(next((shared / "data/models/yunet").glob("*.onnx"))),
    )
    report = count_false_alarms(lambda photo: mediapipe.detect(photo, settings, None), pictures, "mediapipe", silent)
    assert report.found == ()
