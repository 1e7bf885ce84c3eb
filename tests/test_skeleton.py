import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from hypothesis.extra.numpy import arrays
from scipy import ndimage

from limner.vision.skeleton import skeletonize

MASKS = arrays(bool, st.tuples(st.integers(1, 14), st.integers(1, 14)))
EIGHT = np.ones((3, 3))


def pieces_and_holes(mask):
    return ndimage.label(mask, EIGHT)[1], ndimage.label(~np.pad(mask, 1))[1] - 1


def has_block(mask):
    return bool((mask[1:, 1:] & mask[1:, :-1] & mask[:-1, 1:] & mask[:-1, :-1]).any())


def smooth_blobs(seed, size, sigma, share):
    noise = ndimage.gaussian_filter(np.random.default_rng(seed).normal(size=size), sigma)
    return noise > np.quantile(noise, 1 - share)


@settings(max_examples=400, deadline=None)
@given(MASKS)
def test_no_block_and_no_piece_lost_whatever_the_mask(mask):
    skeleton = skeletonize(mask)
    assert not has_block(skeleton)
    assert pieces_and_holes(skeleton)[0] == pieces_and_holes(mask)[0]


@pytest.mark.parametrize("share", [0.1, 0.3, 0.5, 0.7, 0.9])
@pytest.mark.parametrize("sigma", [1, 2, 5])
def test_pieces_and_holes_of_blobs_are_kept(share, sigma):
    for seed in range(5):
        mask = smooth_blobs(seed, (90, 120), sigma, share)
        skeleton = skeletonize(mask)
        assert pieces_and_holes(skeleton) == pieces_and_holes(mask)
        assert not has_block(skeleton)


@settings(max_examples=200, deadline=None)
@given(MASKS)
def test_what_is_thin_stays_and_the_same_mask_gives_the_same_skeleton(mask):
    skeleton = skeletonize(mask)
    np.testing.assert_array_equal(skeletonize(skeleton), skeleton)
    np.testing.assert_array_equal(skeletonize(mask), skeleton)


def test_it_runs_in_the_middle_like_that_of_scikit_image():
    morphology = pytest.importorskip("skimage.morphology")
    noise = ndimage.gaussian_filter(np.random.default_rng(3).normal(size=(200, 200)), 8)
    mask = np.abs(noise) < 0.1 * noise.std()  # lines a few pixels wide
    ours, theirs = skeletonize(mask), morphology.skeletonize(mask)
    near_theirs = ndimage.distance_transform_edt(~theirs)[ours]
    near_ours = ndimage.distance_transform_edt(~ours)[theirs]
    assert np.quantile(near_theirs, 0.95) <= 1.5
    assert np.quantile(near_ours, 0.95) <= 1.5


@pytest.mark.parametrize("thickness", [1, 2, 3, 5, 9])
def test_a_bar_becomes_its_middle_line(thickness):
    mask = np.zeros((40, 100), bool)
    mask[20 - thickness // 2 : 20 - thickness // 2 + thickness, 10:90] = True
    rows, columns = np.nonzero(skeletonize(mask))
    inner = (columns > 20) & (columns < 80)
    assert np.abs(rows[inner] - (20 + (0.5 if thickness % 2 == 0 else 0) - (thickness % 2 == 0))).max() <= 0.5
    assert np.bincount(columns[inner])[21:80].max() == 1
    assert len(set(columns)) > 80 - 2 * thickness


def test_a_block_with_an_arm_at_each_corner_is_opened_without_cutting_any():
    mask = np.zeros((8, 8), bool)
    mask[[1, 2, 3, 4, 5, 6], [1, 2, 3, 4, 5, 6]] = True
    mask[[6, 5, 4, 3, 2, 1], [1, 2, 3, 4, 5, 6]] = True
    skeleton = skeletonize(mask)
    assert not has_block(skeleton)
    assert pieces_and_holes(skeleton) == (1, 0)
    assert all(skeleton[corner] for corner in ((1, 1), (1, 6), (6, 1), (6, 6)))


@pytest.mark.parametrize("shape", [(1, 1), (1, 40), (40, 1), (40, 40), (480, 640)])
def test_white_and_black_masks(shape):
    white = skeletonize(np.ones(shape, bool))
    assert 1 <= white.sum() <= max(shape)
    assert not skeletonize(np.zeros(shape, bool)).any()


def test_the_mask_handed_in_is_left_alone():
    mask = smooth_blobs(0, (30, 30), 2, 0.5)
    before = mask.copy()
    skeletonize(mask)
    np.testing.assert_array_equal(mask, before)
