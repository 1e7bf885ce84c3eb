"""Filters of whole pictures: one result, however many threads take part."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from scipy.ndimage import distance_transform_edt

from limner.vision import raster

RNG = np.random.default_rng(5)
GREY = RNG.random((301, 407)).astype(np.float32)
KERNEL = RNG.random((13, 13)).astype(np.float32)
FILTERS = {
    "distance_to_zero": lambda: raster.distance_to_zero((GREY > 0.002).astype(np.uint8)),
    "blurred": lambda: raster.blurred(GREY, 2.0),
    "widely_blurred": lambda: raster.widely_blurred(GREY, 20.0),
    "resized": lambda: raster.resized(GREY, (512, 333)),
    "filtered": lambda: raster.filtered(GREY, KERNEL),
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
