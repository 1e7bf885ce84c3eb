"""The quick search: it finds what the search everywhere finds, in the same cells; its parts are exactly parts."""

import threading

import cv2
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import fmp_toy
from limner.vision.landmarks.fmp import quick
from limner.vision.landmarks.fmp.coarse import Proposal, Templates, _correlate, distinct
from limner.vision.landmarks.fmp.hog import hog, hog_part
from limner.vision.landmarks.fmp.inference import SearchSettings, search
from limner.vision.landmarks.fmp.matlab import import_matlab
from limner.vision.landmarks.fmp.model import default_model
from limner.vision.landmarks.fmp.pyramid import level_of, padded_size, part_of, scaled_pictures
from limner.vision.landmarks.fmp.quick import search_quickly
from limner.vision.photo import load_photo

MODEL, _ = fmp_toy.face_model()
FACE = fmp_toy.face_picture()


@given(st.integers(0, 2**32 - 1), st.sampled_from([3, 4, 8]))
@settings(max_examples=40, deadline=None)
def test_a_part_of_a_hog_map_is_a_part_of_the_whole(seed, cell_px):
    rng = np.random.default_rng(seed)
    picture = rng.uniform(0, 255, (*rng.integers(3 * cell_px, 100, 2), 3)).round()
    whole = hog(picture, cell_px)
    low = [int(rng.integers(0, n)) for n in whole.shape[:2]]
    high = [int(rng.integers(k + 1, n + 1)) for k, n in zip(low, whole.shape[:2], strict=True)]
    part = hog_part(picture, tuple(low), tuple(high), cell_px)
    np.testing.assert_allclose(part, whole[low[0] : high[0], low[1] : high[1]], rtol=0, atol=1e-12)


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=40, deadline=None)
def test_a_part_of_a_level_is_a_part_of_the_whole(seed):
    rng = np.random.default_rng(seed)
    picture = rng.uniform(0, 255, (*rng.integers(40, 120, 2), 3)).round()
    for scaled in scaled_pictures(picture, 3, [0, 1, 3]):
        whole, size = level_of(scaled, 3, 4, np.float64), padded_size(scaled, 4)
        assert whole.features.shape[:2] == tuple(size[::-1])
        low = np.array([rng.integers(0, n - 1) for n in size])
        high = np.array([rng.integers(k + 1, n + 1) for k, n in zip(low, size, strict=True)])
        part = part_of(scaled, 3, 4, np.float64, (low, high))
        np.testing.assert_allclose(
            part.features, whole.features[low[1] : high[1], low[0] : high[0]], rtol=0, atol=1e-12
        )
        assert (part.index, part.scale_px) == (whole.index, whole.scale_px)
        np.testing.assert_allclose(part.centres_px(np.array([2, 1])), whole.centres_px(low + np.array([2, 1])))


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=20, deadline=None)
def test_templates_are_correlated(seed):
    rng = np.random.default_rng(seed)
    features, weights = rng.normal(size=(*rng.integers(4, 80, 2), 32)), rng.normal(size=(2, *rng.integers(1, 5, 2), 32))
    found = _correlate(features, weights)
    for _ in range(5):
        k, y, x = (int(rng.integers(n)) for n in found.shape)
        window = features[y : y + weights.shape[1], x : x + weights.shape[2]]
        assert found[k, y, x] == pytest.approx((weights[k] * window).sum(), abs=1e-9)


def test_a_template_holds_all_parts_where_they_rest():
    templates = Templates.of(MODEL, np.dtype(np.float64))
    np.testing.assert_allclose(templates.weights.sum(axis=(1, 2))[0], MODEL.filters.sum(axis=(0, 1, 2)), atol=1e-9)
    rest = MODEL.components[0].rest_cells
    np.testing.assert_array_equal(templates.boxes[0], [*rest.min(axis=0), *(rest.max(axis=0) + 5)])


def test_a_face_is_the_first_proposal():
    canvas = fmp_toy.on_grey(FACE, 40, 56, 320, 400)
    (scaled,) = scaled_pictures(canvas, 5, [0])
    proposals = Templates.of(MODEL, np.dtype(np.float64)).propose(scaled)
    (found,) = search(canvas, MODEL, SearchSettings(dtype=np.float64))
    assert np.abs(np.array(proposals[0].root_px) - found.points_px[0]).max() <= 8
    assert np.abs(np.array(proposals[0].box_px) - found.box).max() <= 12
    assert proposals[0].score > 2 * proposals[1].score


def test_of_proposals_on_each_other_the_best_stays():
    def at(score, x):
        return Proposal(score, 0, 0, (x, 50.0), (x, 0.0, x + 100.0, 100.0))

    proposals = [at(1.0, 0.0), at(3.0, 10.0), at(2.0, 200.0), at(0.5, 60.0)]
    assert [proposal.score for proposal in distinct(proposals, 9)] == [3.0, 2.0, 0.5]
    assert [proposal.score for proposal in distinct(proposals, 2)] == [3.0, 2.0]
    assert distinct([], 5) == []


def what(found):
    return [(each.component, each.level, each.cells.tolist()) for each in found]


def same(picture, model, **changes):
    """The faces, which both searches find in the same cells with the same scores."""
    # Sorted by place: of equal scores either may come first.
    everywhere, quickly = (
        sorted(find(picture, model, SearchSettings(**changes)), key=lambda each: tuple(each.box))
        for find in (search, search_quickly)
    )
    assert what(quickly) == what(everywhere)
    for a, b in zip(everywhere, quickly, strict=True):
        assert b.score == pytest.approx(a.score, abs=1e-4)
        np.testing.assert_allclose(b.points_px, a.points_px, atol=1e-6)
    return quickly


@given(st.integers(0, 2**32 - 1), st.floats(1.0, 2.2), st.integers(1, 2))
@settings(max_examples=12, deadline=None)
def test_both_searches_find_the_same(seed, scale, count):
    rng = np.random.default_rng(seed)
    face = cv2.resize(FACE, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    side = len(face)
    canvas = rng.normal(127, 15, (side + 60, count * (side + 40), 3)).clip(0, 255)
    for k in range(count):
        y, x = int(rng.integers(0, 60)), k * (side + 40) + int(rng.integers(0, 40))
        canvas[y : y + side, x : x + side] = face
    assert len(same(canvas, MODEL)) == count


def test_a_search_for_one_ends_at_a_face_of_the_whole_search():
    side = len(FACE)
    canvas = np.full((side + 60, 2 * side + 80, 3), 127.0)
    for x in (20, side + 60):
        canvas[30 : 30 + side, x : x + side] = FACE
    every = search_quickly(canvas, MODEL)
    (first,) = search_quickly(canvas, MODEL, most=1)
    assert len(every) == 2
    assert any(np.array_equal(first.points_px, face.points_px) and first.score == face.score for face in every)


def test_where_no_face_is_none_is_found():
    assert search_quickly(fmp_toy.texture(300, 300), MODEL) == []
    assert search_quickly(np.full((400, 300, 3), 127.0), MODEL) == []


@pytest.mark.parametrize("size", [(1, 1), (5, 300), (19, 19), (24, 24), (30, 20)])
def test_pictures_smaller_than_the_smallest_face(size):
    assert search_quickly(np.full((*size, 3), 80.0), MODEL) == []


def test_a_part_far_from_its_place_is_reached():
    # A picture pulled apart: the right half's parts are farther from rest than the first window goes.
    soft = fmp_toy.face_model(threshold=0.5)[0]
    pulled = np.concatenate([FACE[:, :80], np.full((160, 48, 3), 127.0), FACE[:, 80:]], axis=1)
    same(np.pad(pulled, ((40, 40), (40, 40), (0, 0)), constant_values=127), soft, scale_range_px=(3.9, 4.1))


@pytest.mark.parametrize("find", [search, search_quickly])
def test_the_number_of_cores_changes_nothing(find, monkeypatch):
    canvas = np.concatenate([fmp_toy.on_grey(FACE, 20, 20, 220, 220)] * 3, axis=1)
    alike = find(canvas, MODEL)
    assert len(alike) == 3
    for cores in (1, 3):
        monkeypatch.setattr("limner.vision.landmarks.fmp.threads.cores", lambda cores=cores: cores)
        assert what(find(canvas, MODEL)) == what(alike)


def test_the_search_needs_no_thread_but_its_own(monkeypatch):
    started, ours = [], threading.current_thread()
    start = threading.Thread.start

    def noted(thread):
        # What another test has left behind may start threads too.
        if threading.current_thread() is ours:
            started.append(thread)
        start(thread)

    monkeypatch.setattr(threading.Thread, "start", noted)
    canvas = fmp_toy.on_grey(FACE, 20, 20, 220, 220)
    assert len(search_quickly(canvas, MODEL)) == 1
    assert not started
    assert len(search(canvas, MODEL)) == 1  # the whole search shares its levels out
    assert started


def test_the_search_ends_when_several_places_in_a_row_hold_no_face(monkeypatch):
    looked = []
    climb = quick._Places._climb
    monkeypatch.setattr(quick._Places, "_climb", lambda self, *args: looked.append(args) or climb(self, *args))
    search_quickly(fmp_toy.texture(700, 700), MODEL)
    assert len(looked) == quick._PATIENCE


def working_copy(path, model):
    """The photo as the detector looks for large faces in it."""
    photo = load_photo(path)
    scale = model.smallest_face_px / (0.2 * min(photo.size_px))
    return cv2.resize(photo.rgb.astype(np.float32), None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)


def photos():
    """A few photos always, more with the slow tests."""
    quick = ("london/images/029_03.jpg", "canada/images/070f.jpg", "demo/cc0_037.jpg", "demo/pd_grace_hopper.jpg")
    more = ("london/images/082_03.jpg", "london/smiling/112_08.jpg", "canada/images/113m.jpg", "demo/cc0_046.jpg")
    yield from quick
    yield from (pytest.param(name, marks=pytest.mark.slow) for name in more)


@pytest.mark.parametrize("name", list(photos()))
def test_both_searches_find_the_same_in_photos(shared, name):
    model = default_model()
    assert same(working_copy(shared / "data" / name, model), model)


def test_both_searches_find_the_same_with_the_authors_model(shared):
    model = import_matlab(shared / "data/zhu-ramanan/face_p146_small.mat")
    picture = working_copy(shared / "data/london/images/029_03.jpg", model)
    (face,) = same(picture, model, threshold=-0.65, interval=5)
    assert model.components[face.component].yaw_deg == 0
