"""Search for faces: brute force on small trees, a toy model with a known answer, and the reference's detections."""

import dataclasses
import itertools
import json

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from PIL import Image

import fmp_toy
from limner.vision.landmarks.fmp.inference import Detection, SearchSettings, search, search_level, suppress
from limner.vision.landmarks.fmp.matching import Forest
from limner.vision.landmarks.fmp.matlab import import_matlab
from limner.vision.landmarks.fmp.model import Component
from limner.vision.landmarks.fmp.pyramid import PAD, pyramid
from limner.vision.landmarks.fmp.response import responses

PICTURE = fmp_toy.texture()
TOY = fmp_toy.model_of(PICTURE)
MODELS = ("face_p146_small", "face_p99")
IMAGES = ("astronaut", "cc0_001", "cc0_016", "cc0_050", "cc0_057", "cc0_071", "london_006", "london_086")


@pytest.fixture(scope="session")
def authors(shared):
    return {name: import_matlab(shared / f"data/zhu-ramanan/{name}.mat") for name in MODELS}


def random_tree(rng, parts):
    parents = [-1, *(int(rng.integers(0, i)) for i in range(1, parts))]
    springs = np.stack([rng.uniform(0.01, 0.4, parts), rng.normal(0, 0.3, parts)] * 2, axis=1)
    springs[0] = 0
    anchors = rng.integers(-2, 3, (parts, 2))
    anchors[0] = 0
    return Component(0.0, float(rng.normal()), parents, np.arange(parts), springs, anchors, np.arange(parts))


def score_of(tree, scores, cells):
    total = tree.bias + sum(scores[i, y, x] for i, (x, y) in enumerate(cells))
    for i in range(1, len(cells)):
        dx, dy = np.array(cells[tree.parents[i]]) + tree.anchors[i] - cells[i]
        ax, bx, ay, by = tree.springs[i]
        total -= ax * dx**2 + bx * dx + ay * dy**2 + by * dy
    return total


@given(seed=st.integers(0, 2**32 - 1), parts=st.integers(1, 3))
@settings(max_examples=25, deadline=None)
def test_matching_finds_the_best_of_all_configurations(seed, parts):
    rng = np.random.default_rng(seed)
    tree, scores = random_tree(rng, parts), rng.normal(size=(parts, 3, 4))
    match = Forest([tree]).match(scores.copy())
    every = [(x, y) for x in range(4) for y in range(3)]
    for root in every:
        best = max(score_of(tree, scores, (root, *rest)) for rest in itertools.product(every, repeat=parts - 1))
        assert match.roots[0, root[1], root[0]] == pytest.approx(best, abs=1e-12)
    places = match.places(0, np.array(every))
    for root, cells in zip(every, places, strict=True):
        assert score_of(tree, scores, cells) == pytest.approx(match.roots[0, root[1], root[0]], abs=1e-12)


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=20, deadline=None)
def test_trees_matched_together_are_matched_as_alone(seed):
    rng = np.random.default_rng(seed)
    trees = [random_tree(rng, n) for n in (5, 1, 8)]
    scores = [rng.normal(size=(len(tree.parents), 6, 5)) for tree in trees]
    together = Forest(trees).match(np.concatenate(scores))
    for k, tree in enumerate(trees):
        alone = Forest([tree]).match(scores[k].copy())
        np.testing.assert_allclose(together.roots[k], alone.roots[0], atol=1e-12)
        roots = np.array([[0, 0], [4, 5], [2, 3]])
        assert np.array_equal(together.places(k, roots), alone.places(0, roots))


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=20, deadline=None)
def test_places_of_one_root_are_those_among_many(seed):
    rng = np.random.default_rng(seed)
    match = Forest([random_tree(rng, 6)]).match(rng.normal(size=(6, 7, 9)))
    roots = np.stack(np.meshgrid(np.arange(9), np.arange(7)), axis=-1).reshape(-1, 2)
    alone = [match.places(0, root[None])[0] for root in roots]
    assert np.array_equal(match.places(0, roots), alone)


@given(seed=st.integers(0, 2**32 - 1), rows=st.integers(3, 12), cols=st.integers(3, 12))
@settings(max_examples=20, deadline=None)
def test_responses_are_correlations(seed, rows, cols):
    rng = np.random.default_rng(seed)
    features, filters = rng.normal(size=(rows, cols, 32)), rng.normal(size=(3, 5, 5, 32))
    found = responses(features, filters)
    assert found.shape == (3, max(rows - 4, 0), max(cols - 4, 0))
    for f, y, x in np.ndindex(found.shape):
        assert found[f, y, x] == pytest.approx((filters[f] * features[y : y + 5, x : x + 5]).sum(), abs=1e-10)


def test_the_toy_is_found_where_it_is():
    (found,) = search(PICTURE, TOY, SearchSettings(dtype=np.float64))
    assert np.array_equal(found.cells, fmp_toy.CELLS)
    assert found.score == pytest.approx(4, abs=1e-9)
    assert (found.level, found.scale_px, found.component) == (TOY.interval + 1, 4.0, 0)
    # A cell x of the padded map starts at pixel 4 (x - PAD + 1); five cells are 20 pixels, their middle 9.5 further.
    np.testing.assert_allclose(found.points_px, 4 * (fmp_toy.CELLS - PAD + 1) + 9.5)
    np.testing.assert_allclose(found.part_boxes[:, :2], 4 * (fmp_toy.CELLS - PAD + 1))


@pytest.mark.parametrize(("right", "down"), [(3, 5), (0, 7), (11, 2)])
def test_a_face_shifted_by_whole_cells_is_found_shifted_by_just_that(right, down):
    first, second = (
        search(fmp_toy.on_grey(PICTURE, top, left, 240, 240), TOY)[0]
        for top, left in ((24, 24), (24 + 4 * down, 24 + 4 * right))
    )
    assert np.array_equal(second.points_px - first.points_px, np.full((4, 2), [4 * right, 4 * down]))
    assert second.score == pytest.approx(first.score, abs=1e-4)


def test_a_face_at_double_size_is_found_at_double_coordinates():
    double = np.kron(PICTURE, np.ones((2, 2, 1)))
    (small,), (large,) = (search(picture, TOY, SearchSettings(threshold=2.0))[:1] for picture in (PICTURE, double))
    assert large.scale_px == pytest.approx(2 * small.scale_px)
    assert np.abs((large.points_px + 0.5) / 2 - 0.5 - small.points_px).max() <= 1.0  # 5 taps smooth and shift by 1/2


def test_two_faces_are_both_found_best_first():
    canvas = fmp_toy.on_grey(PICTURE, 4, 4, 128, 260)
    canvas[4:124, 136:256] = PICTURE
    canvas[4:124, 136:256] += np.random.default_rng(0).normal(0, 12, PICTURE.shape)
    found = search(canvas, TOY, SearchSettings(threshold=2.5))
    assert len(found) >= 2
    assert found[0].score > found[1].score > 2.5
    assert abs(found[0].points_px[:, 0].mean() - found[1].points_px[:, 0].mean()) == pytest.approx(132, abs=4)


@pytest.mark.parametrize("size", [(1, 1), (5, 300), (19, 19), (24, 24), (30, 20)])
def test_pictures_smaller_than_the_smallest_face(size):
    assert search(np.full((*size, 3), 80.0), TOY) == []


def test_a_higher_threshold_finds_a_part_of_what_a_lower_finds():
    level = next(pyramid(PICTURE, TOY.interval, dtype=np.float32))
    low, high = ({tuple(map(tuple, d.cells)) for d in search_level(level, TOY, t)} for t in (-1.0, 1.0))
    assert high < low


def test_only_the_wanted_sizes_are_searched():
    assert search(PICTURE, TOY, SearchSettings(scale_range_px=(4.5, 100))) == []
    assert len(search(PICTURE, TOY, SearchSettings(scale_range_px=(3.9, 4.1)))) == 1


def test_unused_filters_change_nothing():
    pool = np.concatenate([np.ones((2, 5, 5, 32)), TOY.filters, np.ones((1, 5, 5, 32))])
    part = dataclasses.replace(TOY.components[0], filters=TOY.components[0].filters + 2)
    (a,), (b,) = search(PICTURE, TOY), search(PICTURE, dataclasses.replace(TOY, filters=pool, components=(part,)))
    assert np.array_equal(a.cells, b.cells)
    assert a.score == pytest.approx(b.score, abs=1e-5)


def detections(seed, count):
    rng = np.random.default_rng(seed)
    cells = rng.integers(0, 40, (count, 1, 2)) + rng.integers(0, 12, (count, 5, 2))
    scale = rng.uniform(2, 8, count)
    points = np.zeros((5, 2))
    return [
        Detection(float(s), 0, 6, float(k), c, points)
        for s, k, c in zip(rng.normal(size=count), scale, cells, strict=True)
    ]


def around(detection, size):
    boxes = detection.part_boxes
    low, high = boxes[:, :2].min(0).clip(0), np.minimum(boxes[:, 2:].max(0), (size[1] - 1, size[0] - 1))
    return low, high


def shares(a, b, size):
    (a0, a1), (b0, b1) = around(a, size), around(b, size)
    common = np.clip(np.minimum(a1, b1) - np.maximum(a0, b0) + 1, 0, None).prod()
    smaller = min(np.clip(high - low + 1, 0, None).prod() for low, high in ((a0, a1), (b0, b1)))
    return common / smaller if smaller else 0.0


@given(seed=st.integers(0, 2**32 - 1), count=st.integers(0, 25), overlap=st.sampled_from([0.0, 0.3, 0.9]))
@settings(max_examples=60, deadline=None)
def test_of_overlapping_detections_the_best_stays(seed, count, overlap):
    size, found = (150, 200), detections(seed, count)
    kept = suppress(found, size, overlap)
    assert [k.score for k in kept] == sorted((k.score for k in kept), reverse=True)
    assert bool(kept) == bool(found)
    for a, b in itertools.combinations(kept, 2):
        assert shares(a, b, size) <= overlap + 1e-9
    for lost in set(map(id, found)) - set(map(id, kept)):
        (worse,) = (d for d in found if id(d) == lost)
        assert any(k.score >= worse.score and shares(k, worse, size) > overlap - 1e-9 for k in kept)
    assert [id(k) for k in suppress(kept, size, overlap)] == [id(k) for k in kept]
    assert [id(k) for k in suppress(found[::-1], size, overlap)] == [id(k) for k in kept]


@pytest.fixture(scope="module")
def level_6(shared):
    return np.load(shared / "reference/fmp/intermediate_astronaut_crop.npz")


@pytest.mark.parametrize(("dtype", "tolerance"), [(np.float64, 1e-12), (np.float32, 1e-5)])
def test_responses_agree_with_the_reference(authors, level_6, dtype, tolerance):
    found = responses(level_6["pf_a"].astype(dtype), authors["face_p146_small"].filters)
    for k in (1, 73, 146):
        np.testing.assert_allclose(found[k - 1], level_6[f"resp_f{k}"], rtol=0, atol=tolerance)
    sums = np.stack([found.min((1, 2)), found.max((1, 2)), found.astype(np.float64).sum((1, 2))], axis=1)
    np.testing.assert_allclose(sums, level_6["resp_sum"], rtol=0, atol=1e4 * tolerance)


@pytest.mark.parametrize(("dtype", "tolerance"), [(np.float64, 1e-12), (np.float32, 2e-5)])
def test_root_scores_agree_with_the_reference(authors, level_6, dtype, tolerance):
    model = authors["face_p146_small"]
    component = model.components[6]
    fits = responses(level_6["pf_a"].astype(dtype), model.filters[component.filters])
    np.testing.assert_allclose(Forest([component]).match(fits).roots[0], level_6["root_c7"], rtol=0, atol=tolerance)


def cases():
    """Two pairs of model and picture always, all with the slow tests."""
    for model, image in itertools.product(MODELS, IMAGES):
        quick = (model, image) in (("face_p146_small", "astronaut"), ("face_p99", "london_086"))
        yield pytest.param(model, image, id=f"{model}-{image}", marks=() if quick else pytest.mark.slow)


@pytest.mark.parametrize(("model", "image"), list(cases()))
def test_detections_agree_with_the_reference(authors, shared, model, image):
    folder = shared / "reference/fmp"
    expected = json.loads((folder / f"{model}__{image}.json").read_text())
    picture = np.asarray(Image.open(folder / expected["image"]).convert("RGB"))
    levels = pyramid(picture, expected["interval"])
    every = [found for level in levels for found in search_level(level, authors[model], expected["threshold"])]
    assert len(every) == expected["n_above_threshold_before_nms"]
    assert sum(found.score for found in every) == pytest.approx(expected["sum_of_their_scores"], rel=1e-9)
    kept = suppress(every, picture.shape[:2], expected["nms_overlap"])
    check(kept, expected, 1e-9, np.array([found.part_boxes + 1 for found in kept]))


def check(kept, expected, tolerance, boxes):
    wanted = expected["detections"]
    assert [(found.component + 1, found.level) for found in kept] == [(d["component"], d["level"]) for d in wanted]
    for found, box, reference in zip(kept, boxes, wanted, strict=True):
        assert found.score == pytest.approx(reference["score"], rel=tolerance)
        np.testing.assert_allclose(box, reference["part_boxes_xyxy_1based"], rtol=0, atol=1e-6)


def test_single_precision_agrees_with_the_reference(authors, shared):
    folder, model = shared / "reference/fmp", authors["face_p146_small"]
    expected = json.loads((folder / "face_p146_small__astronaut.json").read_text())
    picture = np.asarray(Image.open(folder / expected["image"]).convert("RGB"))
    kept = search(picture, model, SearchSettings(threshold=expected["threshold"], interval=expected["interval"]))
    check(kept, expected, 1e-4, np.array([found.part_boxes + 1 for found in kept]))
