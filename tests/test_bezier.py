"""Curves stay within the tolerance of their line both ways, with few knots; points along them stand where they bend."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from drawings import lines
from limner import bezier, geometry

PLACES = st.tuples(st.floats(0, 40), st.floats(0, 40))
TOLERANCES = st.sampled_from([0.05, 0.15, 0.6])


def farthest(points, line):
    """The largest distance of any of the points to a polyline."""
    ends = line if len(line) > 1 else np.repeat(line, 2, axis=0)
    found = np.full(len(points), np.inf)
    for a, b in itertools.pairwise(ends):
        found = np.minimum(found, geometry.distance_to_segments(points, a, b))
    return found.max()


def dense(curves, count=400):
    return bezier.at(curves, np.linspace(0, 1, count)).reshape(-1, 2)


def wave(seed):
    """A smooth line of chance, finely sampled."""
    rng = np.random.default_rng(seed)
    t = np.linspace(0, 1, 300)
    swings = [rng.normal(0, 6 / k, (2, 2)) for k in (1, 2, 3)]
    x, y = (
        sum(s[a, 0] * np.sin(2 * np.pi * k * t) + s[a, 1] * np.cos(2 * np.pi * k * t) for k, s in enumerate(swings, 1))
        for a in (0, 1)
    )
    return np.stack([x + 30 * t, y], axis=1)


def check(line, tolerance):
    curves = bezier.fit(line, tolerance)
    assert (curves[0, 0] == line[0]).all()
    assert (curves[-1, 3] == line[-1]).all()
    assert (curves[1:, 0] == curves[:-1, 3]).all()
    assert farthest(geometry.resample(line, 0.05), dense(curves)) <= tolerance * 1.001
    assert farthest(dense(curves, 100), line) <= tolerance * 1.001
    assert len(curves) + 1 <= max(len(geometry.simplify(line, tolerance)), 2)
    return curves


@settings(max_examples=25)
@given(lines(PLACES), TOLERANCES)
def test_any_line_is_followed_within_the_tolerance(line, tolerance):
    check(line, tolerance)


@settings(max_examples=8)
@given(st.integers(0, 10_000), TOLERANCES)
def test_smooth_lines_are_followed_within_the_tolerance(seed, tolerance):
    check(wave(seed), tolerance)


def test_smooth_lines_need_a_third_of_the_points_of_a_polyline():
    knots = points = 0
    for seed in range(8):
        knots += len(check(wave(seed), 0.15)) + 1
        points += len(geometry.simplify(wave(seed), 0.15))
    assert 3 * knots <= points


def test_a_circle_is_a_few_smooth_curves():
    t = np.linspace(0, 2 * np.pi, 200)
    ring = 10 * np.stack([np.cos(t), np.sin(t)], axis=1)
    ring[-1] = ring[0]
    curves = check(ring, 0.15)
    assert len(curves) <= 5
    assert np.hypot(*dense(curves).T) == pytest.approx(10, abs=0.15)
    for one, other in zip(curves, np.roll(curves, -1, axis=0), strict=True):
        leaving, entering = one[3] - one[2], other[1] - other[0]
        cross = leaving[0] * entering[1] - leaving[1] * entering[0]
        assert abs(cross) < 1e-6 * np.hypot(*leaving) * np.hypot(*entering)
        assert leaving @ entering > 0


def test_corners_stay():
    curves = bezier.fit(np.array([[0, 0], [10, 0], [10, 10.0]]), 0.15)
    assert bezier.are_straight(curves).all()
    assert curves[:, 3].tolist() == [[10, 0], [10, 10]]
    arc = wave(3)
    bent = np.concatenate([arc, arc[-1] + np.linspace([0, 0.1], [-4, 12], 50)])
    corner = int(np.argmin(np.hypot(*(bezier.fit(bent, 0.15)[:, 3] - arc[-1]).T)))
    assert bezier.fit(bent, 0.15)[corner, 3] == pytest.approx(arc[-1], abs=0.15)


def test_a_dot_and_a_line_of_two_points():
    assert bezier.fit(np.array([[3.0, 4]]), 0.15).tolist() == [[[3, 4]] * 4]
    assert bezier.fit(np.array([[3.0, 4], [3, 4]]), 0.15).tolist() == [[[3, 4]] * 4]
    assert bezier.fit(np.array([[0.0, 0], [3, 3]]), 0.15).tolist() == [[[0, 0], [1, 1], [2, 2], [3, 3]]]
    assert bezier.flatten(bezier.fit(np.array([[3.0, 4]]), 0.15), 0.1).tolist() == [[3, 4]]


@settings(max_examples=8)
@given(st.integers(0, 10_000), st.sampled_from([0.01, 0.1, 0.5]))
def test_chords_stay_near_their_curve_and_knots_are_kept(seed, chord_error):
    curves = bezier.fit(wave(seed), 0.1)
    flat = bezier.flatten(curves, chord_error)
    assert farthest(dense(curves, 100), flat) <= chord_error * 1.05
    assert {tuple(p) for p in curves[:, 3].round(9)} <= {tuple(p) for p in flat.round(9)}


def test_points_stand_where_the_curve_bends():
    curve = np.array([[[0, 0], [20, 0], [30, 0], [30, 10.0]]])
    points = bezier.flatten(curve, 0.02)
    gaps = np.hypot(*np.diff(points, axis=0).T)
    assert gaps[0] > 3 * gaps.min()
    even = bezier.at(curve[0], np.linspace(0, 1, len(points)))
    assert farthest(dense(curve), points) < farthest(dense(curve), even)
