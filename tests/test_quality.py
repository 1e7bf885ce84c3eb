"""Good photos pass without a note, each kind of bad one is named, and the words say what helps."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from click.testing import CliRunner

import limner
from limner import storage
from limner.cli.draw import draw
from limner.errors import CannotDraw
from limner.types import Photo
from limner.vision.quality import photo_notes
from limner.vision.refine.shape import moved
from portraits import astronaut, face_of, london, resized

TEST_FACES = ("001_03.jpg", "011_03.jpg", "031_03.jpg", "064_03.jpg")


def spoilt(photo, change):
    """The photo with its grey levels, as numbers, changed."""
    return Photo(np.clip(change(photo.rgb.astype(np.float32)), 0, 255).astype(np.uint8))


def blurred(photo, face):
    return spoilt(photo, lambda rgb: cv2.GaussianBlur(rgb, (0, 0), 0.05 * face.outer_eye_px)), face


def dark(photo, face):
    return spoilt(photo, lambda rgb: 0.2 * rgb), face


def burnt(photo, face):
    columns, rows = face.points_px[19:48].astype(int).T
    bright = 255 / np.percentile(photo.rgb[rows, columns], 30)
    return spoilt(photo, lambda rgb: bright * rgb + 20), face


def hazy(photo, face):
    return spoilt(photo, lambda rgb: 200 + 0.15 * (rgb - 200)), face


def small(photo, face):
    return resized(photo, face, 30 / face.outer_eye_px)[:2]


def turned(photo, face):
    points = face.points_px.copy()
    points[27:36, 0] += 0.5 * face.outer_eye_px
    return photo, face_of(points)


def tilted(photo, face):
    middle = face.points_px[27]
    turn = np.asarray(cv2.getRotationMatrix2D(tuple(middle.tolist()), 40, 1.0))
    return Photo(cv2.warpAffine(photo.rgb, turn, photo.size_px)), face_of(moved(face.points_px, turn))


def cut_off(photo, face):
    x = int(face.points_px[45, 0])
    return Photo(photo.rgb[:, :x].copy()), face


def painted(marks, colour):
    def paint(photo, face):
        rgb, points, reach = photo.rgb.copy(), face.points_px[marks], 0.12 * face.outer_eye_px
        (x0, y0), (x1, y1) = (points.min(axis=0) - reach).astype(int), (points.max(axis=0) + reach).astype(int)
        rgb[y0:y1, x0:x1] = colour
        return Photo(rgb), face

    return paint


BAD = {
    "blurred": blurred,
    "too dark": dark,
    "burnt out": burnt,
    "low contrast": hazy,
    "too small": small,
    "turned away": turned,
    "tilted": tilted,
    "outside": cut_off,
    "mouth": painted(slice(48, 60), (190, 150, 130)),
    "eyes": painted(slice(36, 48), (15, 15, 15)),
    "nose and mouth": painted([*range(30, 36), *range(48, 60)], (200, 215, 235)),
}


@pytest.mark.parametrize("problem", BAD)
def test_a_bad_photo_is_named(problem):
    notes = photo_notes(*BAD[problem](*astronaut()))
    assert any(problem in note for note in notes), notes
    for note in notes:
        assert "; " in note  # what is wrong; what helps
        assert "\n" not in note


@pytest.mark.slow
@pytest.mark.parametrize("problem", BAD)
def test_it_is_named_on_other_faces(shared, problem):
    for name in TEST_FACES:
        assert any(problem in note for note in photo_notes(*BAD[problem](*london(shared, name)))), name


def test_a_good_photo_has_no_note():
    photo, face = astronaut()
    assert photo_notes(photo, face) == ()
    assert photo_notes(*resized(photo, face, 0.7)[:2]) == ()
    assert photo_notes(spoilt(photo, lambda rgb: 0.7 * rgb), face) == ()


@pytest.mark.parametrize(("folder", "images", "labels"), [
    ("london", "images", "landmarks.npz"),
    ("london", "smiling", "landmarks_smiling_machine.npz"),
    ("canada", "images", "landmarks.npz"),
])  # fmt: skip
def test_studio_photos_of_all_skins_have_no_note(shared, folder, images, labels):
    marks = np.load(shared / "data" / folder / labels)
    for name, points in list(zip(marks["names"], marks["ibug68"].astype(float), strict=True))[::6]:
        rgb = cv2.imread(str(shared / "data" / folder / images / str(name)))[:, :, ::-1]
        assert photo_notes(Photo(rgb), face_of(points)) == (), name


def test_varied_portraits_are_seldom_noted(shared):
    marks = np.load(shared / "data/inter-faces-cc0/landmarks_machine.npz")
    noted = []
    for name, points in list(zip(marks["names"], marks["ibug68"].astype(float), strict=True))[::3]:
        rgb = cv2.imread(str(shared / "data/inter-faces-cc0/images" / str(name)))[:, :, ::-1]
        noted += [note for note in photo_notes(Photo(rgb), face_of(points)) if "turned" not in note]
    assert len(noted) <= 1, noted


def test_a_bad_photo_is_drawn_with_a_note_or_refused(tmp_path):
    photo, face = blurred(*astronaut())
    cv2.imwrite(str(tmp_path / "soft.png"), photo.rgb[:, :, ::-1])
    storage.save(face, tmp_path / "face.json")
    arguments = [str(tmp_path / "soft.png"), "--landmarks", str(tmp_path / "face.json"), "-o", str(tmp_path / "a.svg")]
    ran = CliRunner().invoke(draw, arguments, catch_exceptions=False)
    assert ran.stderr.startswith("note: blurred")
    assert limner.read_svg(tmp_path / "a.svg").points > 20
    arguments[-1] = str(tmp_path / "b.svg")
    refused = CliRunner().invoke(draw, [*arguments, "--refuse-bad"])
    assert isinstance(refused.exception, CannotDraw)
    assert not (tmp_path / "b.svg").exists()
