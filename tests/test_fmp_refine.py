"""Landmarks between the cells: the optimum of parabolas and springs, and faces that lie between cells."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import fmp_toy
from limner.vision.landmarks.fmp.inference import search
from limner.vision.landmarks.fmp.refine import between_cells, refine
from test_fmp_inference import random_tree


def paraboloids(rng, cells, shape):
    """Fits that are parabolas along each axis around the cells, and the same as a function of real places."""
    slope, bend = rng.normal(0, 0.02, cells.shape), -rng.uniform(0.05, 0.2, cells.shape)
    y, x = np.mgrid[: shape[0], : shape[1]]
    away = np.stack([x, y], axis=-1) - cells[:, None, None]
    fits = (slope[:, None, None] * away + bend[:, None, None] * away**2 / 2).sum(-1)
    return fits, lambda places: (slope * (places - cells) + bend * (places - cells) ** 2 / 2).sum()


@given(seed=st.integers(0, 2**32 - 1), parts=st.integers(1, 9))
@settings(max_examples=50, deadline=None)
def test_the_result_is_the_optimum_of_parabolas_and_springs(seed, parts):
    rng = np.random.default_rng(seed)
    tree = random_tree(rng, parts)
    springs = tree.springs * [0.2, 0.01, 0.2, 0.01]
    cells = np.full((parts, 2), 10)
    for i in range(1, parts):
        cells[i] = cells[tree.parents[i]] + tree.anchors[i]
    tree = dataclasses.replace(tree, springs=springs)
    cells += 10 - cells.min(axis=0)
    fits, fit = paraboloids(rng, cells, cells.max(axis=0)[::-1] + 10)

    def total(places):
        child, parent = np.arange(1, parts), tree.parents[1:]
        d = places[parent] + tree.anchors[1:] - places[child]
        return fit(places) - (springs[1:, ::2] * d**2 + springs[1:, 1::2] * d).sum()

    found = between_cells(cells, fits, tree)
    assert total(found) >= total(cells) - 1e-12
    if (np.abs(found - cells) < 1).all():
        for _ in range(20):
            assert total(found) >= total(found + rng.normal(0, 0.05, cells.shape)) - 1e-5


def test_parts_on_the_border_and_flat_fits_stay_finite():
    tree = random_tree(np.random.default_rng(0), 3)
    cells = np.array([[0, 0], [4, 3], [0, 3]])
    found = between_cells(cells, np.zeros((3, 4, 5)), tree)
    assert (np.abs(found - cells) <= 1).all()
    assert np.array_equal(
        between_cells(np.array([[2, 1]]), np.zeros((1, 4, 5)), random_tree(np.random.default_rng(0), 1)), [[2, 1]]
    )


@pytest.mark.parametrize(("right", "down"), [(0, 0), (1, 3), (2, 2), (3, 1)])
def test_a_face_between_cells_is_placed_there(right, down):
    model, cells = fmp_toy.face_model()
    canvas = fmp_toy.on_grey(fmp_toy.face_picture(), 28 + down, 32 + right, 240, 240).astype(np.float32)
    truth = 4 * (cells - 3) + 9.5 + [32 + right, 28 + down]
    found = search(canvas, model)[0]
    once, thrice = (refine(canvas, found, model, sizes) for sizes in (1, 3))
    errors = [np.hypot(*(points - truth).T).mean() for points in (found.points_px, once, thrice)]
    shift = np.hypot(*(np.array([right, down]) - np.round(np.array([right, down]) / 4) * 4))
    assert errors[0] == pytest.approx(shift, abs=0.8)
    assert errors[1] < 1.0
    assert errors[2] < 1.0


def test_a_face_that_reaches_out_of_the_picture_is_refined():
    model, cells = fmp_toy.face_model()
    cut = fmp_toy.face_picture()[:, 12:].astype(np.float32)
    found = search(cut, model)[0]
    points = refine(cut, found, model, 3)
    assert np.abs(points - (4 * (cells - 3) + 9.5 - [12, 0])).mean() < 2
