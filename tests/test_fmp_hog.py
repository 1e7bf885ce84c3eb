"""HOG: the reference's numbers, and what must hold for any picture."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from hypothesis.extra import numpy as hnp

from limner.vision.landmarks.fmp.hog import CHANNELS, half_down, hog

pictures = hnp.arrays(np.uint8, st.tuples(st.integers(12, 40), st.integers(12, 40), st.just(3)))


@pytest.mark.parametrize("cell_px", [2, 4, 8])
@pytest.mark.parametrize(("dtype", "tolerance"), [(np.float64, 1e-12), (np.float32, 1e-6)])
def test_agrees_with_the_reference(shared, cell_px, dtype, tolerance):
    reference = np.load(shared / "reference/fmp/intermediate_synthetic.npz")
    found = hog(reference["syn"], cell_px, dtype)
    assert found.dtype == dtype
    np.testing.assert_allclose(found, reference[f"feat_sbin{cell_px}"], rtol=0, atol=tolerance)


@given(pictures, st.sampled_from([2, 4]))
@settings(max_examples=25, deadline=None)
def test_shape_and_range(picture, cell_px):
    found = hog(picture, cell_px)
    assert found.shape == (*(max(half_down(n / cell_px) - 2, 0) for n in picture.shape[:2]), CHANNELS)
    assert found.min(initial=0) >= 0
    assert found[..., :27].max(initial=0) <= 0.4  # half of four values clipped at 0.2
    assert not found[..., 31].any()
    assert np.array_equal(found, hog(picture, cell_px))


@given(pictures)
@settings(max_examples=25, deadline=None)
def test_energy_of_all_signed_bins_is_that_of_the_texture_channels(picture):
    found = hog(picture)
    np.testing.assert_allclose(found[..., :18].sum(-1) / 0.5, found[..., 27:31].sum(-1) / 0.2357, atol=1e-9)


@pytest.mark.parametrize("axis", [0, 1])
def test_shifting_by_whole_cells_shifts_the_map(axis):
    picture = np.random.default_rng(0).integers(0, 256, (64, 72, 3))
    shift = 3
    whole = hog(picture)
    part = hog(np.take(picture, np.arange(4 * shift, picture.shape[axis]), axis))
    inner = np.take(whole, np.arange(shift + 1, whole.shape[axis] - 1), axis)
    np.testing.assert_allclose(np.take(part, np.arange(1, part.shape[axis] - 1), axis), inner, atol=1e-12)


def test_a_mirrored_picture_has_mirrored_features():
    picture = np.random.default_rng(1).normal(128, 40, (40, 48, 3))  # no two directions tie
    bins = [(9 - k) % 18 for k in range(18)]
    found, mirrored = hog(picture), hog(picture[:, ::-1])[:, ::-1]
    np.testing.assert_allclose(mirrored[..., :18], found[..., bins], atol=1e-12)
    np.testing.assert_allclose(mirrored[..., 27:31], found[..., [29, 30, 27, 28]], atol=1e-12)


def test_a_flat_picture_has_no_features():
    assert not hog(np.full((40, 40, 3), 99.0)).any()


@pytest.mark.parametrize("size", [(1, 1), (3, 50), (9, 9), (10, 200)])
def test_too_small_for_a_cell_with_neighbours_is_empty(size):
    assert hog(np.zeros((*size, 3))).size == 0


@pytest.mark.parametrize(("x", "nearest"), [(2.5, 2), (3.5, 3), (2.51, 3), (2.49, 2), (0.5, 0), (4.0, 4)])
def test_half_goes_down(x, nearest):
    assert half_down(x) == nearest
