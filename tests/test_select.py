"""A budget of points is never exceeded, is well used, and more of it never loses weight."""

import itertools

import numpy as np
import pytest
from hypothesis import given, strategies as st

from drawings import drawings, of
from limner import geometry
from limner.drawing.coarsen import coarsenings, drop_errors
from limner.drawing.coverage import Coverage
from limner.drawing.measure import measure
from limner.drawing.select import CostModel, SelectSettings, TimeLimit, select
from limner.drawing.within import Clock, within_time
from limner.errors import CannotDraw

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


MODEL = CostModel(stroke_s=1.0, point_s=0.1, ink_s_per_mm=0.02, travel_s_per_mm=0.01)


def seconds(drawing, model=MODEL):
    """By the model, but with the travel that is really there."""
    told = measure(drawing)
    ink, travel = model.ink_s_per_mm * told.ink_mm, model.travel_s_per_mm * told.travel_mm
    return model.stroke_s * told.strokes + model.point_s * told.points + ink + travel


@given(drawings(), st.floats(0.5, 20), st.none() | BUDGETS)
def test_the_limit_of_time_is_a_hard_bound_too(drawing, limit, points):
    without_travel = CostModel(1.0, 0.1, 0.02)
    chosen = select(drawing, SelectSettings(points=points), TimeLimit(limit, without_travel))
    assert seconds(chosen, without_travel) <= limit + 1e-6
    assert points is None or chosen.points <= points


@given(drawings(), st.floats(0.5, 20))
def test_more_time_never_loses_weight(drawing, limit):
    some, more = (select(drawing, SelectSettings(), TimeLimit(time, MODEL)) for time in (limit, 1.2 * limit))
    assert more.weight.sum() >= some.weight.sum() - 1e-9


@given(drawings(least=1), st.floats(0.05, 1))
def test_minutes_are_never_exceeded(drawing, share):
    limit = share * seconds(drawing)
    clock = Clock(seconds, MODEL, "plotter")
    try:
        chosen, _ = within_time(drawing, SelectSettings(minutes=max(limit / 60, 0.01)), clock, lambda d: (d, None))
    except CannotDraw:
        return
    assert seconds(chosen) <= max(limit, 0.6) + 1e-6


def test_minutes_are_used():
    rng = np.random.default_rng(1)
    drawing = of(
        *(wave(x, 30) + np.array([0, rng.uniform(-90, 90)]) for x in rng.uniform(0, 100, 200)), weights=range(200)
    )
    clock = Clock(seconds, MODEL, "plotter")
    for minutes in (0.5, 2, 5):
        chosen, _ = within_time(drawing, SelectSettings(minutes=minutes), clock, lambda d: (d, None))
        assert 0.97 <= seconds(chosen) / 60 / minutes <= 1


def test_what_cannot_be_drawn_in_time_says_so():
    clock = Clock(lambda d: 600.0 * len(d.lines_mm), CostModel(600.0), "tortoise")
    with pytest.raises(CannotDraw, match="tortoise draws no stroke in 5 min"):
        within_time(of(wave(0)), SelectSettings(minutes=5), clock, lambda d: (d, None))


@given(drawings(least=1), st.randoms(use_true_random=False))
def test_the_worth_of_ink_grows_ever_more_slowly(drawing, random):
    """Monotone and submodular: what a stroke adds is never less than nothing and never more than it was before."""
    coverage = Coverage(drawing, 2.0)
    gains = [coverage.gain(i) for i in range(len(drawing.lines_mm))]
    total = 0.0
    for i in random.sample(range(len(gains)), len(gains)):
        now = [coverage.gain(k) for k in range(len(gains))]
        assert all(0 <= new <= old + 1e-9 * (1 + old) for new, old in zip(now, gains, strict=True))
        gains = now
        total += now[i]
        coverage.take(i)
        assert coverage.worth() == pytest.approx(total)


def test_a_lone_stroke_is_worth_its_weight_and_a_double_of_it_a_third():
    coverage = Coverage(of(wave(0), wave(0), wave(60), weights=[6, 6, 3]), 2.0)
    assert coverage.gain(0) == pytest.approx(6)
    assert coverage.gain(2) == pytest.approx(3)
    coverage.take(0)
    assert coverage.gain(1) == pytest.approx(6 / np.e)
    assert coverage.gain(2) == pytest.approx(3)


def test_what_is_not_there_yet_goes_before_a_second_line_beside_the_first():
    drawing = of(wave(0), wave(0) + np.array([0, 0.3]), wave(60), weights=[10, 9, 6])
    lines = select(drawing, SelectSettings(points=drawing.points * 2 // 3, coarsest=0)).lines_mm
    assert {float(line[0, 0]) for line in lines if len(line) > 40} == {0.0, 60.0}


def test_the_choice_keeps_its_bound():
    """What is taken and the first that did not fit are worth at least 1 - 1/e of the best choice, and mostly all."""
    rng = np.random.default_rng(2)
    shares = []
    for _ in range(30):
        starts = rng.uniform(0, 20, (9, 2))
        sizes = rng.integers(3, 9, 9).tolist()
        lines = [wave(0, n, 1.0) * [0.3, 1] + start for n, start in zip(sizes, starts, strict=True)]
        drawing = of(*lines, weights=rng.uniform(1, 5, 9))
        budget = 20
        chosen = select(drawing, SelectSettings(points=budget, coarsest=0, lift_points=0, nearness=0.1))
        cell = 0.1 * float(np.ptp(np.concatenate(lines), axis=0).max())
        whole = [i for i, line in enumerate(lines) if any(np.array_equal(line, other) for other in chosen.lines_mm)]
        best = max(worth(drawing, cell, some) for some in fitting(lines, budget))
        cut = [i for i in range(9) if i not in whole]
        with_next = max(worth(drawing, cell, [*whole, i]) for i in cut)
        assert with_next >= (1 - np.exp(-1)) * best
        shares.append(worth(drawing, cell, whole) / best)
    assert np.mean(shares) > 0.8


def worth(drawing, cell, some):
    coverage = Coverage(drawing, cell)
    for i in some:
        coverage.take(i)
    return coverage.worth()


def fitting(lines, budget):
    sizes = [len(line) for line in lines]
    for taken in itertools.product([0, 1], repeat=len(lines)):
        if np.dot(taken, sizes) <= budget:
            yield np.flatnonzero(taken).tolist()
