"""What drawing costs, counted by hand."""

import numpy as np
import pytest
from hypothesis import given

from drawings import drawings, of
from limner.drawing.measure import Measures, measure


def test_by_hand():
    drawing = of([[0, 3], [4, 3]], [[4, 3], [4, 6]], [[8, 6]], [[8, 10], [9, 10], [9, 9], [8, 10]])
    got = measure(drawing)
    assert (got.strokes, got.points, got.lifts) == (4, 9, 3)
    assert got.ink_mm == pytest.approx(4 + 3 + 2 + np.sqrt(2))
    assert got.travel_mm == pytest.approx(3 + 0 + 4 + 4 + np.hypot(8, 10))


def test_nothing_costs_nothing():
    assert measure(of()) == Measures(strokes=0, points=0, ink_mm=0, travel_mm=0, lifts=0)


@given(drawings(least=1))
def test_bounds(drawing):
    got = measure(drawing)
    assert 1 <= got.lifts <= got.strokes <= got.points
    assert got.travel_mm >= 0
    first, last = drawing.lines_mm[0][0], drawing.lines_mm[-1][-1]
    assert got.travel_mm >= np.hypot(*first) + np.hypot(*last) - 1e-9
