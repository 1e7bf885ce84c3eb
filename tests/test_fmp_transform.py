"""The distance transform: brute force, the reference's numbers, and infinite scores."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from limner.vision.landmarks.fmp.matching import Forest
from limner.vision.landmarks.fmp.model import Component
from limner.vision.landmarks.fmp.transform import spread


def by_force(score, a, shift, slope=(0, 0)):
    rows, cols = score.shape
    y, x = np.mgrid[:rows, :cols]
    result = np.empty_like(score)
    for py in range(rows):
        for px in range(cols):
            cost = a[0] * (px + shift[0] - x) ** 2 + a[1] * (py + shift[1] - y) ** 2
            result[py, px] = (score + slope[0] * x + slope[1] * y - cost).max()
    return result


@given(
    rows=st.integers(1, 9),
    cols=st.integers(1, 9),
    count=st.integers(1, 4),
    rough=st.sampled_from([0.01, 0.3, 5.0]),
    seed=st.integers(0, 2**32 - 1),
)
@settings(max_examples=150, deadline=None)
def test_agrees_with_brute_force(rows, cols, count, rough, seed):
    rng = np.random.default_rng(seed)
    scores = rng.normal(0, rough, (count, rows, cols))
    stiffness, shift = rng.uniform(0.01, 0.5, (count, 2)), rng.integers(-5, 6, (count, 2))
    slope = rng.normal(0, 0.2, (count, 2))
    maps, _ = spread(scores, stiffness, shift, slope)
    for found, *given_part in zip(maps, scores, stiffness, shift, slope, strict=True):
        np.testing.assert_allclose(found, by_force(*given_part), rtol=0, atol=1e-12)


@given(seed=st.integers(0, 2**32 - 1), share=st.sampled_from([0.3, 0.9, 1.0]))
@settings(max_examples=60, deadline=None)
def test_forbidden_cells_are_never_chosen(seed, share):
    rng = np.random.default_rng(seed)
    score = np.where(rng.uniform(size=(6, 7)) < share, -np.inf, rng.normal(size=(6, 7)))
    a, k = np.array([0.02, 0.3]), np.array([2, -3])
    (found,), _ = spread(score[None], a[None], k[None], np.zeros((1, 2)))
    np.testing.assert_allclose(found, by_force(score, a, k), rtol=0, atol=1e-12)


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=40, deadline=None)
def test_a_constant_adds_and_more_score_never_gives_less(seed):
    rng = np.random.default_rng(seed)
    score, a, k = rng.normal(size=(2, 5, 8)), rng.uniform(0.01, 0.2, (2, 2)), rng.integers(-2, 3, (2, 2))
    flat = np.zeros((2, 2))
    base = np.array(spread(score, a, k, flat)[0])
    np.testing.assert_allclose(np.array(spread(score + 3, a, k, flat)[0]), base + 3, atol=1e-12)
    assert (np.array(spread(score + rng.uniform(0, 1, score.shape), a, k, flat)[0]) >= base - 1e-12).all()


def two_parts(spring, anchor):
    return Component(0.0, 0.0, [-1, 0], [0, 1], [[0] * 4, spring], [[0, 0], anchor], [0, 1])


def message(score, spring, anchor):
    """What the root hears from its only child, and where the child is for each root cell."""
    match = Forest([two_parts(spring, anchor)]).match(np.stack([np.zeros_like(score), score]))
    rows, cols = score.shape
    cells = np.stack(np.meshgrid(np.arange(cols), np.arange(rows)), axis=-1).reshape(-1, 2)
    return match.roots[0], match.places(0, cells)[:, 1].reshape(rows, cols, 2)


@pytest.mark.parametrize(("dtype", "tolerance"), [(np.float64, 1e-12), (np.float32, 1e-5)])
def test_real_weights_agree_with_the_reference(shared, dtype, tolerance):
    reference = np.load(shared / "reference/fmp/intermediate_astronaut_crop.npz")
    anchor = reference["dt_anchor"][0, :2].astype(int) - 1
    best, place = message(reference["dt_in"].astype(dtype), reference["dt_w"][0], anchor)
    np.testing.assert_allclose(best, reference["dt_M"], rtol=0, atol=tolerance)
    if dtype == np.float64:
        assert np.array_equal(place + 1, np.stack([reference["dt_Ix"], reference["dt_Iy"]], axis=-1))


def test_other_sizes_and_steps_agree_with_the_reference(shared):
    reference = np.load(shared / "reference/fmp/intermediate_astronaut_crop.npz")
    score, start = reference["dts_in"], reference["dts_start"][0].astype(int) - 1  # 1, 1 is no shift there
    room = np.full((40, 40), -np.inf)
    room[: score.shape[0], : score.shape[1]] = score
    best, place = message(room, reference["dts_w"][0], start)
    for name, step in (("dts", 1), ("dts2", 2)):
        expected = reference[f"{name}_M"]
        rows, cols = (slice(0, step * n, step) for n in expected.shape)
        np.testing.assert_allclose(best[rows, cols], expected, rtol=0, atol=1e-12)
        argmax = np.stack([reference[f"{name}_Ix"], reference[f"{name}_Iy"]], axis=-1)
        assert np.array_equal(place[rows, cols] + 1, argmax)


@given(
    bx=st.floats(-0.6, 0.6), by=st.floats(-0.6, 0.6), seed=st.integers(0, 2**32 - 1),
    anchor=st.tuples(st.integers(-4, 4), st.integers(-4, 4)),
)  # fmt: skip
@settings(max_examples=80, deadline=None)
def test_springs_with_linear_terms_agree_with_brute_force(bx, by, seed, anchor):
    rng = np.random.default_rng(seed)
    score, (ax, ay) = rng.normal(0, 0.5, (6, 7)), rng.uniform(0.01, 0.3, 2)
    best, place = message(score, (ax, bx, ay, by), anchor)
    y, x = np.mgrid[:6, :7]
    for py in range(6):
        for px in range(7):
            dx, dy = px + anchor[0] - x, py + anchor[1] - y
            value = score - (ax * dx**2 + bx * dx + ay * dy**2 + by * dy)
            assert best[py, px] == pytest.approx(value.max(), abs=1e-12)
            assert value[place[py, px, 1], place[py, px, 0]] == pytest.approx(value.max(), abs=1e-12)
