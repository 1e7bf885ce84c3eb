"""Faces in photos: any size of photo and face, in photo coordinates, with no more work than needed."""

import dataclasses
import itertools

import cv2
import numpy as np
import pytest
from hypothesis import given, strategies as st

import fmp_toy
from limner.errors import BadInput
from limner.types import Photo
from limner.vision.landmarks.fmp import detector
from limner.vision.landmarks.fmp.detector import FmpSettings, detect, looked_for
from limner.vision.landmarks.fmp.model import Component, save_model

MODEL, CELLS = fmp_toy.face_model()
POINTS = 4 * (CELLS - 3) + 9.5
FACE = fmp_toy.face_picture()


@pytest.fixture
def settings(tmp_path):
    save_model(MODEL, tmp_path / "toy.npz")
    return FmpSettings(model=str(tmp_path / "toy.npz"))


def photo_of(width, height, *places):
    """A photo with faces at (scale, x, y) each, and the landmarks of each."""
    canvas, truths = np.full((height, width, 3), 127, np.uint8), []
    for scale, x, y in places:
        face = np.kron(FACE, np.ones((scale, scale, 1)))
        canvas[y : y + face.shape[0], x : x + face.shape[1]] = face
        truths.append((POINTS + 0.5) * scale - 0.5 + [x, y])
    return Photo(canvas), truths


def error(face, truth):
    """Mean distance of the landmarks, as a share of the face's width."""
    return np.hypot(*(face.points_px - truth).T).mean() / np.ptp(truth[:, 0])


@pytest.mark.parametrize(
    ("width", "height", "scale", "x", "y"),
    [
        (200, 180, 1, 20, 10),
        (400, 360, 2, 40, 20),
        (800, 700, 4, 60, 33),
        (900, 1600, 3, 300, 900),
        (700, 240, 1, 500, 50),
    ],
)
def test_a_face_is_found_in_photo_coordinates(settings, width, height, scale, x, y):
    photo, (truth,) = photo_of(width, height, (scale, x, y))
    (face,) = detect(photo, settings)
    assert error(face, truth) < 0.012
    assert (face.detector, face.yaw_deg, face.frontal) == ("fmp", 0.0, True)
    assert face.score > MODEL.threshold
    low, high = truth.min(axis=0) - 10 * scale, truth.max(axis=0) + 10 * scale
    np.testing.assert_allclose(face.box_px, [*low, *high], atol=5 * scale)


def test_a_photo_at_double_size_gives_double_coordinates(settings):
    photo, _ = photo_of(400, 360, (2, 40, 20))
    larger = Photo(np.kron(photo.rgb, np.ones((2, 2, 1), np.uint8)))
    (small,), (large,) = detect(photo, settings), detect(larger, settings)
    np.testing.assert_allclose((large.points_px + 0.5) / 2 - 0.5, small.points_px, atol=0.2)


@pytest.mark.parametrize("refine", [0, 3])
def test_a_face_shifted_by_whole_cells_moves_by_just_that(settings, refine):
    # The photo is as large as it is searched: the smallest face is a fifth of the shorter side.
    side = round(MODEL.smallest_face_px / 0.2)
    (a, b) = (detect(photo_of(side, side, (1, 40 + k, 80))[0], settings.replace(refine=refine))[0] for k in (0, 32))
    np.testing.assert_allclose(b.points_px - a.points_px, np.tile([32, 0], (68, 1)), atol=1e-9 if refine == 0 else 0.02)


def test_small_faces_are_looked_for_only_where_there_is_no_large_one(settings):
    both, (large, _) = photo_of(900, 900, (2, 50, 60), (1, 700, 600))
    alone, (small,) = photo_of(900, 900, (1, 700, 600))
    (face,) = detect(both, settings)
    assert error(face, large) < 0.012
    (face,) = detect(alone, settings)
    assert error(face, small) < 0.012
    assert detect(alone, settings.replace(smallest=0.2)) == ()


def test_faces_below_the_models_smallest_are_found_enlarged(settings):
    half = np.asarray(Photo(FACE.astype(np.uint8)).rgb).reshape(80, 2, 80, 2, 3).mean(axis=(1, 3))
    photo = Photo(np.pad(half, ((30, 20), (10, 40), (0, 0)), constant_values=127).astype(np.uint8))
    (face,) = detect(photo, settings.replace(threshold=-0.75))
    assert error(face, (POINTS + 0.5) / 2 - 0.5 + [10, 30]) < 0.03


def test_several_faces_come_largest_first(settings):
    photo, (first, second) = photo_of(1000, 700, (1, 30, 40), (2, 400, 100))
    found = detect(photo, settings)
    assert len(found) == 2
    assert error(found[0], second) < 0.012
    assert error(found[1], first) < 0.012


@pytest.mark.parametrize("size", [(1, 1), (39, 200), (300, 20), (40, 40), (41, 4000)])
def test_photos_with_no_room_for_a_face(settings, size):
    assert detect(Photo(np.full((*size, 3), 90, np.uint8)), settings) == ()


def test_the_same_photo_gives_the_same_faces(settings):
    photo, _ = photo_of(400, 360, (2, 40, 20))
    assert detect(photo, settings) == detect(photo, settings)


def test_double_precision_agrees(settings):
    photo, _ = photo_of(400, 360, (2, 40, 20))
    (single,), (double,) = (detect(photo, settings.replace(precision=p)) for p in ("float32", "float64"))
    np.testing.assert_allclose(single.points_px, double.points_px, atol=1e-2)


@pytest.mark.parametrize("size", [(3000, 4000), (480, 640), (100, 100)])
def test_the_searched_picture_is_no_larger_than_needed(settings, size, monkeypatch):
    searched = []
    monkeypatch.setattr(detector, "search_quickly", lambda picture, *_, **__: searched.append(picture.shape[:2]) or [])
    detect(Photo(np.zeros((*size, 3), np.uint8)), settings.replace(smallest=0.05, tilt=0))
    sides = [min(shape) for shape in searched]
    assert sides == sorted(sides)
    assert sides[0] <= MODEL.smallest_face_px / 0.2 + 1
    assert sides[-1] <= MODEL.smallest_face_px / 0.05 + 1
    assert sides[-1] / min(size) <= MODEL.smallest_face_px / 40 * 1.01


def test_every_size_is_looked_for_once():
    photo = Photo(np.zeros((1000, 1400, 3), np.uint8))
    ranges = list(detector._ranges_px(photo, FmpSettings(smallest=0.03)))
    assert ranges[0] == (200, np.inf)
    assert ranges[-1][0] == 40
    assert all(small == above for (small, _), (_, above) in itertools.pairwise(ranges))
    assert list(detector._ranges_px(photo, FmpSettings(smallest=1.0))) == [(1000, np.inf)]
    assert list(detector._ranges_px(Photo(np.zeros((39, 500, 3), np.uint8)), FmpSettings())) == []


def test_a_model_without_a_face_is_refused(tmp_path, settings):
    save_model(fmp_toy.model_of(fmp_toy.texture()), tmp_path / "four.npz")
    with pytest.raises(BadInput, match="4 parts"):
        detect(photo_of(200, 180)[0], settings.replace(model=str(tmp_path / "four.npz")))


def test_what_was_looked_for_is_told(settings, tmp_path):
    photo = photo_of(640, 480)[0]
    assert looked_for(photo, settings) == "frontal faces of 48 px or more with a score of at least 1.5"
    assert "100 x 30 px" in looked_for(photo_of(100, 30)[0], settings)
    turned = dataclasses.replace(MODEL.components[0], yaw_deg=-15.0)
    assert isinstance(turned, Component)
    save_model(dataclasses.replace(MODEL, components=(*MODEL.components, turned)), tmp_path / "two.npz")
    assert "turned -15 to +0 degrees" in looked_for(photo, settings.replace(model=str(tmp_path / "two.npz")))


def test_real_faces_are_found_with_the_authors_model(shared):
    from limner.vision.photo import load_photo

    settings = FmpSettings(model=str(shared / "data/zhu-ramanan/face_p146_small.mat"))
    (face,) = detect(load_photo(shared / "data/demo/pd_grace_hopper.jpg"), settings)
    # Eyes, nose tip and chin as seen in the photo.
    for landmark, place in ((36, (207, 193)), (45, (318, 186)), (30, (263, 234)), (8, (264, 332))):
        assert np.hypot(*(face.points_px[landmark] - place)) < 12


@pytest.mark.parametrize("angle_deg", [20, -20])
def test_tilted_faces_are_found_where_no_upright_one_is(settings, angle_deg):
    upright, (truth,) = photo_of(640, 480, (2, 150, 80))
    turn = cv2.getRotationMatrix2D((320, 240), angle_deg, 1.0)
    tilted = Photo(cv2.warpAffine(upright.rgb, turn, (640, 480), borderValue=(127, 127, 127)))
    (face,) = detect(tilted, settings)
    assert error(face, truth @ turn[:, :2].T + turn[:, 2]) < 0.015
    assert detect(tilted, settings.replace(tilt=0)) == ()


def test_the_search_everywhere_agrees(settings):
    photo, (truth,) = photo_of(400, 360, (2, 40, 20))
    (face,) = detect(photo, settings.replace(exact=True))
    np.testing.assert_allclose(face.points_px, detect(photo, settings)[0].points_px, atol=1e-4)
    assert error(face, truth) < 0.012


def test_tiles_find_what_the_whole_photo_does(settings, monkeypatch):
    photo, truths = photo_of(2400, 500, (1, 30, 40), (1, 1120, 100), (2, 2000, 60))
    whole = detect(photo, settings)
    monkeypatch.setattr(detector, "_TILE_PX", 100_000)
    tiled = detect(photo, settings)
    assert len(whole) == len(tiled) == 3
    for truth in truths:
        assert min(error(face, truth) for face in tiled) < 0.02


def test_memory_is_bounded_by_tiles():
    photo = Photo(np.zeros((600, 9000, 3), np.uint8))
    sizes = [copy.picture.shape[:2] for copy in detector._copies(photo, 2.0, 200)]
    assert len(sizes) > 1
    assert max(h * w for h, w in sizes) <= detector._TILE_PX * 1.01


@given(st.integers(1, 5000), st.floats(2.5, 4000), st.floats(0.1, 0.5))
def test_pieces_cover_all_and_share_enough(length, side, share):
    shared = share * side
    pieces = list(detector._cuts(length, side, shared))
    assert pieces[0][0] == 0
    assert pieces[-1][1] == length
    for (_, end), (start, _) in itertools.pairwise(pieces):
        assert end - start >= shared - 1e-6
    assert all(end - start <= side + 2 for start, end in pieces)
