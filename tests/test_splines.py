"""Splines: they interpolate, end straight, and smooth between the points and the straight line."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, strategies as st

from limner.errors import BadInput
from limner.vision.splines import natural_spline, smoothing_spline

POINTS = st.integers(2, 20).flatmap(
    lambda n: st.lists(st.tuples(st.floats(-500, 500), st.floats(-500, 500)), min_size=n, max_size=n).map(np.array)
)


@given(POINTS)
def test_p_1_goes_through_every_point(points):
    spline = smoothing_spline(points, 1.0)
    assert np.allclose(spline.at(spline.places), points, atol=1e-9)


@given(POINTS)
def test_p_0_is_the_straight_line_of_least_squares(points):
    spline = smoothing_spline(points, 0.0)
    t = np.linspace(spline.places[0], spline.places[-1], 50)
    design = np.stack([np.ones(len(points)), spline.places], axis=1)
    coefficients = np.linalg.lstsq(design, points, rcond=None)[0]
    assert np.allclose(spline.at(t), np.stack([np.ones(50), t], axis=1) @ coefficients, atol=1e-6)


@given(POINTS, st.floats(0, 1))
def test_the_ends_are_natural_and_the_curve_is_smooth(points, p):
    spline = smoothing_spline(points, p)
    assert not spline.bends[[0, -1]].any()
    eps = 1e-5
    inner = spline.places[1:-1]
    left = (spline.at(inner) - spline.at(inner - eps)) / eps
    right = (spline.at(inner + eps) - spline.at(inner)) / eps
    assert np.allclose(left, right, atol=1e-3 * (1 + np.abs(spline.bends).max()))


@given(POINTS.filter(lambda points: len(points) > 2), st.lists(st.floats(0.1, 3), min_size=20, max_size=20))
def test_interpolation_agrees_with_scipy(points, steps):
    interpolate = pytest.importorskip("scipy.interpolate")
    places = np.cumsum(steps[: len(points)])
    t = np.linspace(places[0], places[-1], 101)
    theirs = interpolate.CubicSpline(places, points, bc_type="natural")(t)
    assert np.allclose(natural_spline(points, places).at(t), theirs, atol=1e-6)


@pytest.mark.parametrize("p", [0.2, 6 / 7, 0.99])
def test_smoothing_agrees_with_scipy(p):
    interpolate = pytest.importorskip("scipy.interpolate")
    random = np.random.default_rng(0)
    places, weights = np.cumsum(random.uniform(0.5, 2, 17)), random.uniform(0.5, 2, 17)
    points = random.normal(size=(17, 2))
    theirs = interpolate.make_smoothing_spline(places, points, w=weights, lam=(1 - p) / p)
    t = np.linspace(places[0], places[-1], 101)
    assert np.allclose(smoothing_spline(points, p, places, weights).at(t), theirs(t), atol=1e-6)


@given(POINTS, st.tuples(st.floats(-600, 600), st.floats(-600, 600)))
def test_nearest_is_on_the_curve_and_no_sample_is_nearer(points, query):
    spline = natural_spline(points)
    query = np.array([query])
    nearest = spline.nearest(query)
    line = spline.at(np.linspace(spline.places[0], spline.places[-1], 2000))
    least = np.hypot(*(line - query).T).min()
    assert np.hypot(*(nearest - query).T) <= least + 0.02 * np.ptp(points, axis=0).max() + 1e-6
    assert np.hypot(*(line - nearest).T).min() <= 0.02 * np.ptp(line, axis=0).max() + 1e-6


def test_a_point_of_the_curve_is_its_own_nearest():
    random = np.random.default_rng(1)
    spline = natural_spline(random.normal(size=(9, 2)))
    points = spline.at(random.uniform(0, 8, 40))
    assert np.allclose(spline.nearest(points), points, atol=1e-3)


def test_the_line_has_short_steps_and_keeps_its_ends():
    points = np.array([[0, 0], [10, 5], [20, 0], [40, 3]], float)
    line = natural_spline(points).line(0.5)
    assert np.hypot(*np.diff(line, axis=0).T).max() <= 0.5 + 1e-9
    assert np.allclose(line[[0, -1]], points[[0, -1]])


@pytest.mark.parametrize(("points", "p"), [(np.zeros((1, 2)), 1.0), (np.zeros((5, 2)), 1.5), (np.zeros((5, 2)), -0.1)])
def test_bad_input_is_named(points, p):
    with pytest.raises(BadInput, match="expected two points or more, and p from 0 to 1"):
        smoothing_spline(points, p)


def test_coinciding_points_give_numbers():
    assert np.isfinite(natural_spline(np.zeros((17, 2))).line(1.0)).all()
