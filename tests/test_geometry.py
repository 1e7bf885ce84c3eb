"""Polylines: simplification stays within its tolerance, resampling keeps ends and length."""

from __future__ import annotations

import itertools

import numpy as np
from hypothesis import given, strategies as st
from hypothesis.extra import numpy as hnp

from limner import geometry

LINE = hnp.arrays(np.float64, st.tuples(st.integers(1, 30), st.just(2)), elements=st.floats(-100, 100))


def distance_to_line(points, line):
    if len(line) == 1:
        return np.hypot(*(points - line[0]).T)
    return np.min([geometry.distance_to_segments(points, a, b) for a, b in itertools.pairwise(line)], axis=0)


@given(LINE, st.floats(0, 20))
def test_simplify_stays_within_its_tolerance(line, tolerance):
    simple = geometry.simplify(line, tolerance)
    assert (distance_to_line(line, simple) <= tolerance + 1e-9).all()
    assert (simple[0] == line[0]).all()
    assert (simple[-1] == line[-1]).all()
    assert {tuple(p) for p in simple} <= {tuple(p) for p in line}


@given(st.lists(LINE, max_size=6), st.floats(0, 5))
def test_many_lines_are_simplified_as_one_by_one(lines, tolerance):
    together = geometry.simplify_all(lines, tolerance)
    assert len(together) == len(lines)
    for line, simple in zip(lines, together, strict=True):
        np.testing.assert_array_equal(simple, line[douglas_peucker(line, 0, len(line) - 1, tolerance)])


def douglas_peucker(line, first, last, tolerance):
    """The vertices that stay, by the book."""
    if last - first < 2:
        return sorted({first, last})
    far = geometry.distance_to_segments(line[first + 1 : last], line[first], line[last])
    split = first + 1 + int(far.argmax())
    if far.max() <= tolerance:
        return [first, last]
    parts = (first, split), (split, last)
    return sorted({k for part in parts for k in douglas_peucker(line, *part, tolerance)})


@given(LINE, st.floats(0.5, 20))
def test_resample_keeps_ends_and_places_points_on_the_line(line, step):
    points = geometry.resample(line, step)
    assert np.allclose(points[0], line[0])
    assert np.allclose(points[-1], line[-1], atol=1e-6)
    assert np.hypot(*np.diff(points, axis=0).T).max(initial=0) <= step + 1e-9
    assert distance_to_line(points, line).max() < 1e-6


def test_every_point_may_be_held_against_every_segment():
    points, line = np.array([[0, 1], [5, 5], [2, -3.0]]), np.array([[0, 0], [4, 0], [4, 4.0]])
    table = geometry.distance_to_segments(points[:, None], line[:-1], line[1:])
    singly = [[geometry.distance_to_segments(p[None], a, b)[0] for a, b in itertools.pairwise(line)] for p in points]
    np.testing.assert_array_equal(table, singly)
    np.testing.assert_allclose(table, [[1, 4], [26**0.5, 2**0.5], [3, 13**0.5]])


def test_length_and_closed():
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1], [0, 0.0]])
    assert geometry.length(square) == 4
    assert geometry.total_length([square, square[:2]]) == 5
    assert geometry.is_closed(square)
    assert not geometry.is_closed(square[:4])
    assert geometry.length(square[:1]) == 0
