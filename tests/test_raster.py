"""Filters of whole pictures: one result, however many threads take part."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from scipy.ndimage import correlate, distance_transform_edt

from limner.vision import raster
from limner.vision.edges.bank import TILE_PX, correlated
from limner.vision.edges.ridges import Wave, find_ridges, gabor_kernel

RNG = np.random.default_rng(5)
GREY = RNG.random((301, 407)).astype(np.float32)
KERNEL = RNG.random((13, 13)).astype(np.float32)
FILTERS = {
    "distance_to_zero": lambda: raster.distance_to_zero((GREY > 0.002).astype(np.uint8)),
    "blurred": lambda: raster.blurred(GREY, 2.0),
    "widely_blurred": lambda: raster.widely_blurred(GREY, 20.0),
    "resized": lambda: raster.resized(GREY, (512, 333)),
    "filtered": lambda: raster.filtered(GREY, KERNEL),
    "correlated": lambda: correlated(np.tile(GREY, (2, 2)), [KERNEL, KERNEL.T]),
    "find_ridges": lambda: find_ridges(GREY, Wave(6.0, 2.0, 0.3, np.pi), 8, 0.7).strength,
}


@pytest.fixture
def threads():
    before = cv2.getNumThreads()
    yield cv2.setNumThreads
    cv2.setNumThreads(before)


@pytest.mark.parametrize("name", FILTERS)
def test_one_result_however_many_threads(name, threads):
    results = []
    for count in (1, 2, 3, 8):
        threads(count)
        results.append(FILTERS[name]().tobytes())
    assert len(set(results)) == 1


@pytest.mark.parametrize("share", [0.5, 0.01, 0.0005])
def test_distances_are_those_of_scipy(share):
    mask = (RNG.random((250, 333)) >= share).astype(np.uint8)
    assert np.array_equal(raster.distance_to_zero(mask), distance_transform_edt(mask).astype(np.float32))


def test_where_nothing_is_near_it_is_far():
    assert (raster.distance_to_zero(np.ones((40, 30), np.uint8)) >= 1000).all()


@pytest.mark.parametrize("shape", [(1, 1), (1, 700), (40, 30), (350, 351), (2 * TILE_PX + 1, 123)])
@pytest.mark.parametrize("side", [1, 3, 35, 101])
def test_a_bank_answers_as_its_filters_one_by_one(shape, side):
    picture = RNG.random(shape, np.float32)
    kernels = [kernel / np.abs(kernel).sum() for kernel in RNG.random((3, side, side), np.float32) - np.float32(0.5)]
    answers = correlated(picture, kernels)
    assert answers.shape == (3, *shape)
    for kernel, answer in zip(kernels, answers, strict=True):
        expected = correlate(picture.astype(float), kernel.astype(float), mode="nearest")
        np.testing.assert_allclose(answer, expected, rtol=0, atol=2e-6)
        np.testing.assert_allclose(answer, raster.filtered(picture, kernel), rtol=0, atol=2e-6)


def test_ridges_are_those_of_the_plain_way():
    """The strongest answer and its neighbours, looked up one pixel after the other."""
    wave, count = Wave(6.0, 2.0, 0.3, np.pi), 8
    grey = raster.blurred(GREY[:60, :50], 1.0)
    answers = np.stack([raster.filtered(grey, gabor_kernel(wave, np.pi * k / count)) for k in range(count)])
    ridges = find_ridges(grey, wave, count, 0.7)
    for row, column in np.ndindex(grey.shape):
        line = answers[:, row, column].astype(float)
        best = int(line.argmax())
        before, here, after = (line[(best + step) % count] for step in (-1, 0, 1))
        offset = np.clip((before - after) / (2 * min(before - 2 * here + after, -1e-9)), -0.5, 0.5)
        strength = here - (before - after) * offset / 4 - 0.7 * max(line[(best + count // 2) % count], 0)
        assert ridges.strength[row, column] == pytest.approx(max(strength, 0), abs=1e-5)
        turn = np.pi * (best + offset) / count + np.pi / 2
        assert abs(np.angle(np.exp(2j * (ridges.angle_rad[row, column] - turn)))) < 1e-2
    assert 0 <= ridges.angle_rad.min() < ridges.angle_rad.max() < np.pi
