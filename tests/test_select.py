"""A budget of points is never exceeded, is well used, and more of it never loses weight."""

import itertools

import numpy as np
import pytest
from hypothesis import given, strategies as st

from drawings import drawings, of
from limner import geometry
from limner.drawing.coarsen import coarsenings, drop_errors
from limner.drawing.select import SelectSettings, select

BUDGETS = st.integers(2, 60)


@given(drawings(), BUDGETS, st.floats(0, 0.1), st.floats(0, 1))
def test_the_budget_is_a_hard_bound(drawing, points, coarsest, shape_value):
    chosen = select(drawing, SelectSettings(points=points, coarsest=coarsest, shape_value=shape_value))
    assert chosen.points <= points
    assert chosen.lines_mm or not drawing.lines_mm


@given(drawings(), BUDGETS)
def test_more_points_never_lose_weight(drawing, points):
    some = select(drawing, SelectSettings(points=points))
    more = select(drawing, SelectSettings(points=points + 1))
    assert more.weight.sum() >= some.weight.sum() - 1e-9
    assert more.weight.sum() <= drawing.weight.sum() + 1e-9


@given(drawings(), BUDGETS)
def test_every_point_was_there_before_in_the_same_stroke_and_order(drawing, points):
    chosen = select(drawing, SelectSettings(points=points))
    remaining = iter(zip(drawing.lines_mm, drawing.region, strict=True))
    for line, region in zip(chosen.lines_mm, chosen.region, strict=True):
        assert any(region == other and is_subsequence(line, whole) for whole, other in remaining)


def is_subsequence(line, whole):
    rest = iter(whole.tolist())
    return all(any(point == other for other in rest) for point in line.tolist())


@given(drawings(), BUDGETS, st.sampled_from([0.0, 0.004, 0.05]))
def test_whole_strokes_move_no_farther_than_the_coarsest(drawing, points, coarsest):
    chosen = select(drawing, SelectSettings(points=points, coarsest=coarsest))
    if not drawing.lines_mm:
        return
    allowed = coarsest * np.ptp(np.concatenate(drawing.lines_mm), axis=0).max()
    for line, weight in zip(chosen.lines_mm, chosen.weight.tolist(), strict=True):
        sources = [
            whole
            for whole, w in zip(drawing.lines_mm, drawing.weight.tolist(), strict=True)
            if w == weight and (whole[0] == line[0]).all() and (whole[-1] == line[-1]).all()
        ]
        assert not sources or min(error(whole, line) for whole in sources) <= allowed + 1e-9 or is_part(line, sources)


def error(whole, line):
    ends = line if len(line) > 1 else np.repeat(line, 2, axis=0)
    found = [geometry.distance_to_segments(whole, a, b) for a, b in itertools.pairwise(ends)]
    return float(np.min(found, axis=0).max())


def is_part(line, sources):
    return any(geometry.length(line) < geometry.length(whole) / 1.0001 for whole in sources)


@given(drawings())
def test_a_drawing_within_the_budget_is_left_alone(drawing):
    assert select(drawing, SelectSettings(points=max(2, drawing.points))) == drawing
    assert select(drawing, SelectSettings()) == drawing


@given(drawings(), BUDGETS)
def test_the_same_drawing_gives_the_same_choice(drawing, points):
    assert select(drawing, SelectSettings(points=points)) == select(drawing, SelectSettings(points=points))


def wave(x0, n=60, height=3.0):
    x = np.linspace(0, 40, n)
    return np.stack([x + x0, 100 + height * np.sin(x / 3)], axis=1)


def test_the_weightier_stroke_comes_first():
    drawing = of(wave(0), wave(60), [[0, 0], [140, 200]], weights=[1, 50, 0.1])
    chosen = select(drawing, SelectSettings(points=8))
    assert (chosen.lines_mm[0] >= [60, 0]).all()
    assert chosen.weight.sum() == 50


def test_shapes_are_coarsened_before_strokes_are_dropped():
    drawing = of(*(wave(x, height=1.0) + np.array([0, y]) for x in (0, 50, 100) for y in (0, 40, 80)))
    chosen = select(drawing, SelectSettings(points=drawing.points // 4))
    assert len(chosen.lines_mm) == 9


def test_the_budget_is_used():
    rng = np.random.default_rng(0)
    drawing = of(*(wave(x, 40) + rng.normal(0, 0.2, (40, 2)) for x in range(30)), weights=range(30))
    for points in range(40, 1200, 90):
        assert select(drawing, SelectSettings(points=points)).points >= points - 4


def test_what_does_not_fit_is_drawn_in_part():
    drawing = of(wave(0), weights=[10])
    chosen = select(drawing, SelectSettings(points=4, coarsest=0))
    assert chosen.points == 4
    share = geometry.length(chosen.lines_mm[0]) / geometry.length(wave(0))
    assert chosen.weight[0] == pytest.approx(10 * share)
    parts = [geometry.length(wave(0)[i : i + 4]) for i in range(57)]
    assert geometry.length(chosen.lines_mm[0]) == pytest.approx(max(parts))


def test_a_small_ring_stays_a_ring():
    t = np.linspace(0, 2 * np.pi, 20)
    ring = np.stack([70 + 0.3 * np.cos(t), 100 + 0.3 * np.sin(t)], axis=1)
    ring[-1] = ring[0]
    chosen = select(of(ring, wave(0), wave(0) + 10, weights=[100, 1, 1]), SelectSettings(points=20))
    assert any(geometry.is_closed(line) and len(line) >= 4 for line in chosen.lines_mm)


@given(drawings(least=1), st.floats(0, 3))
def test_errors_say_what_simplifying_drops(drawing, tolerance):
    for line in drawing.lines_mm:
        kept = line[drop_errors(line) > tolerance]
        assert (kept == geometry.simplify(line, tolerance)).all()


@given(drawings(least=1), st.floats(0, 5), st.floats(0, 1))
def test_versions_grow_in_points_and_value_ever_more_slowly(drawing, coarsest, shape_value):
    for line in drawing.lines_mm:
        versions = coarsenings(line, coarsest, shape_value)
        sizes = np.array([len(version) for version in versions.lines])
        values = np.array(versions.values)
        assert values[-1] == 1
        assert (values >= 1 - shape_value - 1e-12).all()
        assert (np.diff(sizes) > 0).all()
        gains = np.diff(values, prepend=0) / np.diff(sizes, prepend=0)
        assert (np.diff(gains) <= 1e-12).all()
