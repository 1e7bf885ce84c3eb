"""The benchmark of strokes compares what it says, and its parts agree with simpler ways to count."""

import numpy as np
import pytest

from limner import bezier
from limner.drawing.measure import measure
from limner.drawing.order import OrderSettings, order
from limner.evaluate import strokes
from limner.evaluate.strokes import measure_strokes, scattered, swing


def test_every_row_has_its_figure(monkeypatch):
    monkeypatch.setattr(strokes, "vpype_program", lambda: None)
    rows = {row.name: row for row in measure_strokes(scattered(12, seed=3), counts=(20,), kicks=5, smooth=2)}
    assert len(rows) == 8
    assert 1 <= rows["travel, 20 scattered strokes, x of the best known"].value < 1.2
    assert rows["curve and line apart at most, smooth lines"].reached
    assert rows["knots of curves, smooth lines, x of Douglas-Peucker's points"].reached
    assert not any("vpype" in name for name in rows)


def test_vpype_is_compared_where_it_is_installed(monkeypatch):
    monkeypatch.setattr(strokes, "vpype_program", lambda: "/somewhere/vpype")
    monkeypatch.setattr(strokes, "vpype_travel_mm", lambda drawing: 2 * measure(drawing).travel_mm)
    rows = {row.name: row.value for row in measure_strokes(scattered(12), counts=(), kicks=1, smooth=1)}
    ordered = measure(order(scattered(12), OrderSettings())).travel_mm
    assert rows["travel, portrait, x of vpype linemerge linesort"] == pytest.approx(
        ordered / measure(scattered(12)).travel_mm / 2
    )


def test_a_curve_that_leaves_its_line_is_found_out():
    line = swing(0)
    curves = bezier.fit(line, 0.15)
    assert strokes._apart(line, curves) <= 0.15
    assert strokes._apart(line, curves + np.array([0.0, 0.4])) > 0.2


@pytest.mark.slow
def test_very_many_strokes_are_ordered_too():
    drawing = scattered(20_000)
    ordered = order(drawing, OrderSettings(kicks=0))
    assert len(ordered.lines_mm) == 20_000
    assert measure(ordered).travel_mm < 0.01 * measure(drawing).travel_mm
    assert np.sort(ordered.weight).tolist() == np.sort(drawing.weight).tolist()
