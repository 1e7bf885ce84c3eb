"""The pyramid: the reference's numbers, where pixels and cells lie, and which levels are computed."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from limner.vision.landmarks.fmp.pyramid import (
    FILTER,
    PAD,
    level_count,
    padded,
    pyramid,
    reduce,
    resize,
    scaled_pictures,
)

TOLERANCES = [(np.float64, 1e-12), (np.float32, 1e-4)]


@pytest.fixture(scope="module")
def synthetic(shared):
    return np.load(shared / "reference/fmp/intermediate_synthetic.npz")


@pytest.fixture(scope="module")
def astronaut(shared):
    return np.load(shared / "reference/fmp/intermediate_astronaut_crop.npz")


@pytest.mark.parametrize(("dtype", "tolerance"), TOLERANCES)
@pytest.mark.parametrize(("name", "octaves"), [("rs_0871", -1 / 5), ("rs_0758", -2 / 5)])
def test_resize_agrees_with_the_reference(synthetic, name, octaves, dtype, tolerance):
    found = resize(synthetic["syn"].astype(dtype), 2**octaves)
    assert found.dtype == dtype
    np.testing.assert_allclose(found, synthetic[name], rtol=0, atol=tolerance)


@pytest.mark.parametrize(("dtype", "tolerance"), TOLERANCES)
@pytest.mark.parametrize(("source", "name"), [("syn", "rd"), ("syn_even", "rd_even")])
def test_reduce_agrees_with_the_reference(synthetic, source, name, dtype, tolerance):
    found = reduce(synthetic[source].astype(dtype))
    assert found.dtype == dtype
    np.testing.assert_allclose(found, synthetic[name], rtol=0, atol=tolerance)


def test_levels_agree_with_the_reference(astronaut):
    levels = {level.index: level for level in pyramid(astronaut["crop"], 5)}
    assert sorted(levels) == list(range(6, len(astronaut["psizes"]) + 1))
    for index, level in levels.items():
        assert level.features.shape == tuple(astronaut["psizes"][index - 1])
        assert level.scale_px == pytest.approx(astronaut["pscale"][index - 1, 0], rel=1e-12)
    np.testing.assert_allclose(levels[6].features, astronaut["pf_a"], rtol=0, atol=1e-12)
    np.testing.assert_allclose(levels[9].features, astronaut["pf_b"], rtol=0, atol=1e-12)


@given(st.integers(20, 90), st.integers(20, 90), st.floats(0.5, 1), st.sampled_from([np.float64, np.float32]))
@settings(max_examples=40, deadline=None)
def test_resize_keeps_the_mean_and_constant_pictures(height, width, scale, dtype):
    rng = np.random.default_rng(0)
    picture = rng.uniform(0, 255, (height, width, 3)).astype(dtype)
    # A share below a thousandth of a pixel is dropped, of a pixel that is averaged over at least one.
    assert resize(picture, scale).mean() == pytest.approx(picture.mean(), rel=3e-3)
    np.testing.assert_allclose(resize(np.full_like(picture, 50), scale), 50, rtol=3e-3)


@given(st.integers(2, 60), st.integers(2, 60), st.sampled_from([np.float64, np.float32]))
@settings(max_examples=40, deadline=None)
def test_reduce_halves_and_keeps_constant_pictures(height, width, dtype):
    found = reduce(np.full((height, width, 3), 50, dtype))
    assert found.shape == (height // 2, width // 2, 3)
    np.testing.assert_allclose(found, 50, rtol=1e-6)


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_pixels_of_scaled_pictures_lie_where_they_say(dtype):
    y, x = np.mgrid[:301.0, :437.0]
    ramp = np.stack([x, y, x], axis=2).astype(dtype)
    for scaled in scaled_pictures(ramp, 5, range(20)):
        height, width = scaled.image.shape[:2]
        centre_x = scaled.corner_px[0] + (np.arange(width) + 0.5) * scaled.pixel_px[0]
        centre_y = scaled.corner_px[1] + (np.arange(height) + 0.5) * scaled.pixel_px[1]
        inner = slice(3, -3)
        np.testing.assert_allclose(scaled.image[height // 2, inner, 0], centre_x[inner], atol=0.09)
        np.testing.assert_allclose(scaled.image[inner, width // 2, 1], centre_y[inner], atol=0.09)


def test_centre_of_a_filter_at_full_size():
    level = next(pyramid(np.zeros((100, 80, 3)), 5))
    # The first cell of the map covers pixels 4 to 7, five cells 4 to 23: their middle is 13.5.
    np.testing.assert_allclose(level.centres_px(np.array([PAD, PAD])), [13.5, 13.5])
    np.testing.assert_allclose(level.centres_px(np.array([PAD + 2, PAD + 1])), [21.5, 17.5])


def test_only_the_wanted_levels_are_computed():
    picture = np.random.default_rng(0).uniform(0, 255, (130, 150, 3))
    every = {level.index: level for level in pyramid(picture, 4)}
    some = {level.index: level for level in pyramid(picture, 4, scale_range_px=(5.0, 11.0))}
    assert sorted(some) == sorted(index for index, level in every.items() if 5 <= level.scale_px <= 11)
    for index, level in some.items():
        assert np.array_equal(level.features, every[index].features)


@pytest.mark.parametrize("size", [(19, 200), (200, 19), (1, 1), (5, 5)])
def test_a_picture_smaller_than_a_filter_has_no_level(size):
    assert level_count(size, 5) == 0
    assert not list(pyramid(np.zeros((*size, 3)), 5))


@given(st.integers(20, 400), st.integers(20, 400), st.integers(1, 10))
def test_the_last_level_is_the_last_that_holds_a_filter(height, width, interval):
    count = level_count((height, width), interval)
    assert min(height, width) * 2 ** (-(count - 1) / interval) >= FILTER * 4 * (1 - 1e-9)
    assert min(height, width) * 2 ** (-count / interval) < FILTER * 4 * (1 + 1e-9)


def test_the_frame_is_marked_in_the_last_channel():
    found = padded(np.ones((3, 2, 32)))
    assert found.shape == (3 + 2 * PAD, 2 + 2 * PAD, 32)
    assert found.sum() == 3 * 2 * 32 + (11 * 10 - 3 * 2)
    assert found[0, 0, 31] == 1
    assert found[0, 0, :31].sum() == 0
