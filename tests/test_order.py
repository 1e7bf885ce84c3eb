"""Ordering changes the sequence and direction of strokes and nothing else, and never lengthens the travel."""

import itertools

import numpy as np
import pytest
from hypothesis import given, strategies as st

from drawings import drawings, of, segments
from limner.drawing.measure import measure, travel_hops_mm
from limner.drawing.order import OrderSettings, order
from limner.drawing.tour import Tour

PASSES = st.sampled_from([0, 1, 20]).map(lambda passes: OrderSettings(passes=passes))


@given(drawings(), PASSES)
def test_every_segment_stays_and_the_travel_never_grows(drawing, how):
    ordered = order(drawing, how)
    assert segments(ordered.lines_mm) == segments(drawing.lines_mm)
    assert measure(ordered).travel_mm <= measure(drawing).travel_mm + 1e-9
    assert measure(ordered).ink_mm == pytest.approx(measure(drawing).ink_mm)
    assert (ordered.page, ordered.pen) == (drawing.page, drawing.pen)


@given(drawings())
def test_region_and_weight_go_with_their_stroke(drawing):
    ordered = order(drawing, OrderSettings())

    def described(d):
        return sorted(
            (segments([line]), region, weight)
            for line, region, weight in zip(d.lines_mm, d.region, d.weight.tolist(), strict=True)
        )

    assert described(ordered) == described(drawing)


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
    """2-opt with Or-opt ends about 5 % above the shortest tour, which for n random places is .7124 sqrt(n area)."""
    rng = np.random.default_rng(7)
    drawing = of(*([place, place + np.array([0.01, 0])] for place in rng.uniform(0, 100, (300, 2))))
    shortest = 0.7124 * np.sqrt(300 * 100 * 100)
    assert measure(order(drawing, OrderSettings())).travel_mm < 1.15 * shortest
    assert measure(order(drawing, OrderSettings(passes=1))).travel_mm < 1.3 * shortest


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


@given(st.integers(1, 12), st.data())
def test_reversing_a_run_keeps_the_tour_consistent(n, data):
    rng = np.random.default_rng(n)
    lines = [rng.uniform(0, 9, (2, 2)) for _ in range(n)]
    tour = Tour.of(lines, np.zeros(2))
    for _ in range(5):
        i, j = sorted(data.draw(st.tuples(st.integers(1, n), st.integers(1, n))))
        tour.reverse(i, j)
    for place, (stroke, flipped) in enumerate(zip(tour.stroke, tour.flipped, strict=True), 1):
        line = lines[stroke][::-1] if flipped else lines[stroke]
        assert tour.begin[place] == complex(*line[0])
        assert tour.end[place] == complex(*line[-1])
    assert sorted(tour.stroke.tolist()) == list(range(n))
