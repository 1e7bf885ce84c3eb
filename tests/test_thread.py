"""One line through all dots, the same dots, without crossings; a corner that is rounded brings none."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from shapely.geometry import LineString

from limner.drawing.thread import CURVE_POINTS, ThreadSettings, opened, rounded, thread
from limner.drawing.uncross import uncrossed
from limner.types import Drawing

SEEDS = st.integers(0, 10_000)


def dots(points):
    return Drawing(tuple(p[None] for p in points), ("face",) * len(points), np.ones(len(points)))


def in_any_order(points):
    return sorted(map(tuple, points.tolist()))


def clouds(seed, count, crowd):
    """Dots all over the page and crowds of them, as where a face is dark."""
    rng = np.random.default_rng(seed)
    near = rng.normal(0, 3, (crowd, 2)) + rng.uniform(40, 110, (1, 2))
    return np.concatenate([rng.uniform(10, 138, (count, 2)), near])


@given(SEEDS, st.integers(1, 60), st.integers(0, 60), st.integers(0, 3))
@settings(max_examples=40)
def test_one_line_through_all_dots_that_never_crosses_itself(seed, count, crowd, kicks):
    points = clouds(seed, count, crowd)
    (line,) = thread(dots(points), ThreadSettings(kicks=kicks)).lines_mm
    assert in_any_order(line) == in_any_order(points)
    assert len(line) == 1 or LineString(line).is_simple


@given(SEEDS, st.integers(2, 80))
@settings(max_examples=40)
def test_crossings_are_undone_and_the_line_gets_shorter(seed, count):
    tangled = clouds(seed, count, 0)
    line = uncrossed(tangled)
    assert in_any_order(line) == in_any_order(tangled)
    assert (line[[0, -1]] == tangled[[0, -1]]).all()
    assert LineString(line).is_simple
    assert LineString(line).length <= LineString(tangled).length + 1e-9


def test_the_test_sees_crossings():
    assert not LineString(clouds(0, 50, 0)).is_simple


@given(SEEDS, st.integers(3, 80))
@settings(max_examples=15)
def test_rounded_corners_do_not_cross(seed, count):
    line = uncrossed(clouds(seed, count, count))
    curve = rounded(line)
    assert len(curve) == CURVE_POINTS * (len(line) - 2) + 2
    assert LineString(curve).is_simple
    assert LineString(curve).length <= LineString(line).length


def test_a_corner_within_a_corner_stays_within():
    nested = np.array([[0, 0], [50, 100], [100, 0], [90, 0], [50, 95], [10, 0]], float)
    assert LineString(nested).is_simple
    assert LineString(rounded(nested)).is_simple
    # As deep a cut without a look at the others would cross.
    assert np.hypot(*(rounded(nested) - [50, 100]).T).min() < 6


@pytest.mark.parametrize("count", [1, 2, 3])
def test_few_dots(count):
    points = clouds(1, count, 0)
    for smooth in (False, True):
        (line,) = thread(dots(points), ThreadSettings(smooth=smooth)).lines_mm
        assert len(line) == (1 if count < 2 else count if count < 3 or not smooth else CURVE_POINTS + 2)


def test_the_longest_hop_is_not_drawn():
    ring = clouds(3, 40, 0)
    line = opened(ring)
    hops = np.hypot(*(np.roll(ring, -1, axis=0) - ring).T)
    assert in_any_order(line) == in_any_order(ring)
    assert LineString(line).length == pytest.approx(hops.sum() - hops.max())


def test_dots_on_one_spot_become_one_point():
    points = np.array([[20.0, 20], [20, 20], [30, 20], [30, 30], [30, 30]])
    assert len(thread(dots(points), ThreadSettings()).lines_mm[0]) == 3


def test_a_strong_tour():
    """Within 6 % of the length that the shortest tour of many random points tends to, 0.7124 sqrt(n A).

    The border adds to it (Johnson, McGeoch & Rothberg 1996): 0.33 / n of it besides 0.55 sqrt(A) for a square.
    """
    rng = np.random.default_rng(0)
    points = rng.uniform(10, 130, (1000, 2))
    shortest = 0.7124 * np.sqrt(1000 * 120**2) * (1 + 0.33 / 1000) + 0.55 * np.sqrt(120**2) / 2
    (line,) = thread(dots(points), ThreadSettings()).lines_mm
    assert LineString(line).length < 1.06 * shortest
