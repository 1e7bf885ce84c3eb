"""Ordering changes the sequence and direction of strokes and nothing else, and never lengthens the travel."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from drawings import drawings, of, segments
from limner.drawing.measure import measure, travel_hops_mm
from limner.drawing.neighbours import nearest
from limner.drawing.order import AUDIENCE, OrderSettings, order
from limner.drawing.start import greedy_tour
from limner.drawing.tour import Tour, shake
from limner.types import REGIONS

HOWS = st.sampled_from([OrderSettings(kicks=0), OrderSettings(), OrderSettings(by="given")])
ALL_HOWS = HOWS | st.just(OrderSettings(by="audience"))


@given(drawings(), HOWS)
def test_the_travel_never_grows(drawing, how):
    assert measure(order(drawing, how)).travel_mm <= measure(drawing).travel_mm + 1e-9


@given(drawings(), ALL_HOWS)
def test_every_segment_stays(drawing, how):
    ordered = order(drawing, how)
    assert segments(ordered.lines_mm) == segments(drawing.lines_mm)
    assert measure(ordered).ink_mm == pytest.approx(measure(drawing).ink_mm)
    assert (ordered.page, ordered.pen) == (drawing.page, drawing.pen)


@given(drawings(), ALL_HOWS)
def test_region_and_weight_go_with_their_stroke(drawing, how):
    ordered = order(drawing, how)

    def described(d):
        return sorted(
            (segments([line]), region, weight)
            for line, region, weight in zip(d.lines_mm, d.region, d.weight.tolist(), strict=True)
        )

    assert described(ordered) == described(drawing)


@settings(max_examples=30)
@given(drawings())
def test_the_same_drawing_gives_the_same_order(drawing):
    assert order(drawing, OrderSettings()) == order(drawing, OrderSettings())


def test_few_strokes_come_near_the_best_order_there_is():
    rng = np.random.default_rng(3)
    ratios = []
    for _ in range(40):
        drawing = of(*rng.uniform(0, 100, (4, 2, 2)))
        best = min(
            travel_hops_mm([line[::-1] if flip else line for line, flip in zip(lines, flips, strict=True)]).sum()
            for lines in itertools.permutations(drawing.lines_mm)
            for flips in itertools.product([False, True], repeat=4)
        )
        ratios.append(measure(order(drawing, OrderSettings())).travel_mm / best)
    assert min(ratios) >= 1 - 1e-9
    assert np.mean(ratios) < 1.02


def test_scattered_strokes_travel_like_a_good_tour():
    """The shortest tour through 300 random places is about .75 sqrt(n area) long (Johnson & McGeoch 1996)."""
    rng = np.random.default_rng(7)
    drawing = of(*([place, place + np.array([0.01, 0])] for place in rng.uniform(0, 100, (300, 2))))
    shortest = 0.75 * np.sqrt(300 * 100 * 100)
    assert measure(order(drawing, OrderSettings())).travel_mm < 1.05 * shortest
    assert measure(order(drawing, OrderSettings(kicks=0))).travel_mm < 1.15 * shortest


def test_a_broken_line_is_drawn_from_one_end_to_the_other():
    pieces = [[[x, 0], [x + 5, 0]] for x in (0, 10, 20, 30)]
    drawing = order(of(pieces[2][::-1], pieces[0], pieces[3][::-1], pieces[1]), OrderSettings())
    assert measure(drawing).travel_mm == pytest.approx(5 * 3 + 35)


def test_a_closed_stroke_begins_where_it_is_near():
    square = [[90.0, 90], [90, 10], [10, 10], [10, 90], [90, 90]]
    drawing = order(of(square), OrderSettings())
    assert drawing.lines_mm[0][0].tolist() == drawing.lines_mm[0][-1].tolist() == [10, 10]
    assert segments(drawing.lines_mm) == segments(of(square).lines_mm)


def test_a_good_order_is_not_made_worse():
    lines = [[[x, 1], [x + 1, 1]] for x in range(0, 50, 2)]
    assert measure(order(of(*lines), OrderSettings())).travel_mm <= measure(of(*lines)).travel_mm


def test_an_audience_sees_the_contour_then_the_features_then_the_hair():
    rng = np.random.default_rng(5)
    drawing = of(*rng.uniform(0, 100, (40, 2, 2)), regions=[REGIONS[i % 10] for i in range(40)])
    ordered = order(drawing, OrderSettings(by="audience"))
    act = [next(k for k, act in enumerate(AUDIENCE) if region in act) for region in ordered.region]
    assert act == sorted(act)
    assert {region for act in AUDIENCE for region in act} == set(REGIONS)
    shuffled = order(drawing, OrderSettings(by="travel"))
    assert measure(shuffled).travel_mm < measure(ordered).travel_mm


def test_one_act_has_the_shortest_way_too():
    drawing = of(*np.random.default_rng(5).uniform(0, 100, (40, 2, 2)), regions=["nose"] * 40)
    both = [measure(order(drawing, OrderSettings(by=by))).travel_mm for by in ("audience", "travel")]
    assert both[0] == pytest.approx(both[1], rel=0.02)


@given(drawings(least=1, most=30), st.integers(0, 300), st.integers(1, 10))
def test_what_a_tour_gains_is_what_it_is_shorter(drawing, kicks, longest):
    ends = np.array([[0.0, 0], [0, 0], *(line[k] for line in drawing.lines_mm for k in (0, -1))])
    row = greedy_tour(ends)
    tour = Tour(ends, row, longest)
    before = tour.length()
    gained = tour.settle(row[1:]) + shake(tour, kicks)
    assert gained >= 0
    assert tour.length() == pytest.approx(before - gained, abs=1e-6)
    assert sorted(tour.row) == list(range(len(ends) + 2))
    assert [a ^ 1 for a in tour.row[::2]] == tour.row[1::2]
    assert tour.row[:2] == [0, 1]
    assert tour.row[-2:] == [len(ends), len(ends) + 1]
    assert (tour.over, tour.gap) == hops_of(tour)


def hops_of(tour):
    """Of every end where its hop leads to and how far that is, read off the row; -1 and 0 where it has none."""
    over, gap = [-1] * len(tour.row), [0.0] * len(tour.row)
    for a, b in zip(tour.row[1:-1:2], tour.row[2::2], strict=True):
        over[a], over[b] = b, a
        gap[a] = gap[b] = abs(tour.where[a] - tour.where[b])
    return over, gap


@given(st.integers(0, 4))
def test_a_move_taken_back_leaves_no_trace(seed):
    ends = np.random.default_rng(seed).uniform(0, 9, (60, 2))
    tour = Tour(ends, list(range(60)), 99)
    before = [list(values) for values in (tour.row, tour.at, tour.over, tour.gap)]
    tour.remember = True
    assert tour.settle(tour.row[1:-1]) > 0
    assert tour.row != before[0]
    tour.back()
    assert [tour.row, tour.at, tour.over, tour.gap] == before


@settings(max_examples=20)
@given(st.integers(0, 999), st.integers(1, 9), st.sampled_from(["even", "clouds", "far", "grid"]))
def test_the_nearest_are_the_nearest(seed, count, kind):
    rng = np.random.default_rng(seed)
    points = {
        "even": rng.uniform(0, 100, (700, 2)),
        "clouds": rng.normal(0, 1, (700, 2)) ** 3,
        "far": np.concatenate([rng.uniform(0, 9, (500, 2)), [[5000, 5000.0]]]),
        "grid": np.stack(np.divmod(rng.permutation(700), 31), axis=1).astype(float),
    }[kind]
    gap = np.hypot(*(points[:, None] - points[None]).transpose(2, 0, 1))
    found = nearest(points, count)
    assert (found != np.arange(len(points))[:, None]).all()
    np.fill_diagonal(gap, np.inf)
    assert np.take_along_axis(gap, found, axis=1) == pytest.approx(np.sort(gap, axis=1)[:, :count])


def test_many_strokes_on_one_spot_are_ordered():
    drawing = of(*[[[5.0, 5], [5, 5 + k % 2]] for k in range(2000)])
    ordered = order(drawing, OrderSettings(kicks=0))
    assert segments(ordered.lines_mm) == segments(drawing.lines_mm)
    assert measure(ordered).travel_mm <= measure(drawing).travel_mm
