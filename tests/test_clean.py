"""Cleaning joins what meets, drops crumbs and needless points, and leaves the ink where it was."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from drawings import drawings, of, segments
from limner import geometry
from limner.drawing.clean import CleanSettings, clean
from limner.drawing.join import chains, near_pairs
from limner.errors import NothingToDraw

KEEP_ALL = CleanSettings(join_mm=0, min_length_mm=0, double_pens=0, tolerance_mm=0)
SOME = st.builds(CleanSettings, st.floats(0, 2), st.floats(0, 2), st.just(0.0), st.floats(0, 0.5))


def cleaned(drawing, how):
    try:
        return clean(drawing, how)
    except NothingToDraw:
        return of()


def distances(points, lines):
    """Of each point to the nearest of the lines."""
    found = np.full(len(points), np.inf)
    for line in lines:
        ends = line if len(line) > 1 else np.repeat(line, 2, axis=0)
        for a, b in itertools.pairwise(ends):
            found = np.minimum(found, geometry.distance_to_segments(points, a, b))
    return found


@settings(max_examples=50)
@given(drawings(), SOME)
def test_all_new_ink_lies_on_the_old_or_bridges_a_gap(drawing, how):
    result = cleaned(drawing, how)
    for line in result.lines_mm:
        dense = geometry.resample(line, 0.2)
        assert distances(dense, drawing.lines_mm).max() <= how.tolerance_mm + how.join_mm / 2 + 1e-9


@settings(max_examples=50)
@given(drawings(), SOME)
def test_all_old_ink_is_still_there_but_for_crumbs(drawing, how):
    result = cleaned(drawing, how)
    for line in drawing.lines_mm:
        if geometry.length(line) >= how.min_length_mm:
            assert distances(line, result.lines_mm).max() <= how.tolerance_mm + 1e-9


@given(drawings(), SOME)
def test_never_more_strokes_points_or_weight_and_no_crumbs(drawing, how):
    result = cleaned(drawing, how)
    assert len(result.lines_mm) <= len(drawing.lines_mm)
    # A ring of which the ends nearly meet gets its first point once more.
    assert result.points <= drawing.points + len(result.lines_mm)
    assert result.weight.sum() <= drawing.weight.sum() + 1e-6
    for line in result.lines_mm:
        # Simplifying comes last and may shorten a line a little.
        assert how.tolerance_mm or geometry.length(line) >= how.min_length_mm
        assert len(line) == 1 or (np.diff(line, axis=0) != 0).any(axis=1).all()
    if how.min_length_mm == 0:
        assert result.weight.sum() == pytest.approx(drawing.weight.sum())


@given(drawings())
def test_with_nothing_to_do_nothing_is_done(drawing):
    result = clean(drawing, KEEP_ALL)
    straight = [geometry.without_repeats(line) for line in drawing.lines_mm]
    assert len(result.lines_mm) == len(straight)
    for got, line in zip(result.lines_mm, straight, strict=True):
        assert distances(line, [got]).max() <= 1e-9
        assert (got[0] == line[0]).all()
        assert (got[-1] == line[-1]).all()


@given(drawings(), SOME)
def test_the_same_drawing_is_cleaned_the_same(drawing, how):
    assert cleaned(drawing, how) == cleaned(drawing, how)


@given(drawings())
def test_joining_alone_moves_no_ink(drawing):
    """With a reach below the grid of the places only ends that touch are joined."""
    result = clean(drawing, CleanSettings(join_mm=1e-6, min_length_mm=0, double_pens=0, tolerance_mm=0))
    for a, b in ((drawing.lines_mm, result.lines_mm), (result.lines_mm, drawing.lines_mm)):
        assert all(distances(geometry.resample(line, 0.5), b).max() < 1e-5 for line in a)


def joined(*lines, regions=None, reach=0.8):
    return clean(
        of(*lines, regions=regions), CleanSettings(join_mm=reach, min_length_mm=0, double_pens=0, tolerance_mm=0)
    )


def test_pieces_of_one_line_become_one():
    result = joined([[10.3, 0], [20, 0]], [[30, 0], [20.4, 0]], [[0, 0], [10, 0]])
    assert len(result.lines_mm) == 1
    assert result.lines_mm[0][[0, -1]].tolist() in ([[0, 0], [30, 0]], [[30, 0], [0, 0]])
    assert result.weight.tolist() == [3]


def test_at_a_crossing_the_line_goes_straight_on():
    result = joined([[0, 0], [10, 0]], [[10, 0], [10, 10]], [[10, 0], [20, 0.5]])
    assert segments(result.lines_mm) == segments(of([[0, 0], [10, 0], [20, 0.5]], [[10, 10], [10, 0]]).lines_mm)
    assert sorted(len(line) for line in result.lines_mm) == [2, 3]


def test_corners_that_touch_are_joined_and_corners_with_a_gap_are_not():
    assert len(joined([[0, 0], [10, 0]], [[10, 0], [10, 10]]).lines_mm) == 1
    assert len(joined([[0, 0], [10, 0]], [[10, 0.7], [10, 10]]).lines_mm) == 2
    assert len(joined([[0, 0], [10, 0]], [[10.9, 0], [20, 0]]).lines_mm) == 2


def test_no_line_is_joined_to_itself_by_going_back():
    assert joined([[0, 0], [0.5, 0]]).points == 2
    assert len(joined([[0, 0], [10, 0]], [[9.5, 0], [20, 0]]).lines_mm) == 2


def test_a_ring_in_pieces_is_closed():
    t = np.linspace(0, 2 * np.pi, 40)
    ring = np.stack([4 * np.cos(t), 4 * np.sin(t)], axis=1)
    result = joined(ring[:15], ring[14:30][::-1], ring[29:-1], reach=1.2)
    assert len(result.lines_mm) == 1
    assert geometry.is_closed(result.lines_mm[0])


def test_regions_stay_apart():
    assert len(joined([[0, 0], [10, 0]], [[10, 0], [20, 0]], regions=["eye", "brow"]).lines_mm) == 2


def test_a_straight_line_of_many_points_keeps_two():
    line = np.stack([np.linspace(0, 50, 200), np.linspace(0, 20, 200)], axis=1)
    line[1:-1, 1] += 0.03 * np.sin(np.arange(198))
    assert clean(of(line), CleanSettings()).points == 2


def test_crumbs_go_and_when_all_are_crumbs_it_says_so():
    assert len(clean(of([[0, 0], [9, 0]], [[50, 50], [50.5, 50]], [[70, 70]]), CleanSettings()).lines_mm) == 1
    with pytest.raises(NothingToDraw, match="shorter than 1 mm"):
        clean(of([[0, 0], [0.5, 0]], [[9, 9]]), CleanSettings())
    assert clean(of(), CleanSettings()) == of()


@given(drawings(least=1), st.floats(0, 5))
def test_near_pairs_are_those_that_are_near(drawing, radius):
    points = np.concatenate(drawing.lines_mm)
    gap = np.hypot(*(points[:, None] - points[None]).transpose(2, 0, 1))
    expected = {(i, j) for i, j in np.argwhere(gap <= radius).tolist() if i < j}
    found = list(zip(*(k.tolist() for k in near_pairs(points, radius)), strict=True))
    assert len(found) == len(set(found))
    assert set(found) == expected


@given(drawings(), st.floats(0, 3))
def test_every_line_is_in_one_chain(drawing, reach):
    found = chains(drawing.lines_mm, drawing.region, reach)
    assert sorted(i for chain, _ in found for i, _ in chain) == list(range(len(drawing.lines_mm)))
    for chain, _ in found:
        assert len({drawing.region[i] for i, _ in chain}) == 1


DOUBLES = KEEP_ALL.replace(double_pens=1.0)


@settings(max_examples=50)
@given(drawings(), st.sampled_from([0.5, 2.0]))
def test_what_is_left_out_as_double_has_ink_beside_it(drawing, pens):
    result = clean(drawing, KEEP_ALL.replace(double_pens=pens))
    for line in result.lines_mm:
        assert distances(geometry.resample(line, 0.2), drawing.lines_mm).max() < 1e-6
    for line in drawing.lines_mm:
        assert distances(geometry.resample(line, 0.2), result.lines_mm).max() <= pens * drawing.pen.width_mm * 1.2
    assert result.weight.sum() <= drawing.weight.sum() + 1e-6


def arc(height, start=0.0, end=60.0):
    x = np.linspace(start, end, 90)
    return np.stack([x, 50 + height + 5 * np.sin(x / 15)], axis=1)


def test_of_two_lines_closer_than_the_pen_the_heavier_stays():
    result = clean(of(arc(0.3), arc(0), weights=[1, 2]), DOUBLES)
    assert len(result.lines_mm) == 1
    assert result.weight.tolist() == [2]
    assert (result.lines_mm[0] == arc(0)).all()


def test_lines_a_little_wider_apart_and_lines_that_cross_both_stay():
    apart = of(arc(0), arc(0.7))
    assert clean(apart, DOUBLES) == apart
    crossing = of([[0, 0], [40, 2]], [[0, 2], [40, 0]], [[20, -9], [20, 9]])
    assert geometry.total_length(clean(crossing, DOUBLES).lines_mm) > 0.8 * geometry.total_length(crossing.lines_mm)
    across = of([[0, 0], [40, 20]], [[0, 20], [40, 0]])
    assert clean(across, DOUBLES) == across


def test_only_the_part_that_runs_beside_is_left_out():
    bent = np.concatenate([arc(0.2, 20, 60), [[60, 90]]])
    result = clean(of(arc(0), bent, weights=[20, 10]), DOUBLES)
    assert len(result.lines_mm) == 2
    assert geometry.length(result.lines_mm[1]) == pytest.approx(90 - bent[-2, 1], abs=1.5)
    assert result.weight[1] == pytest.approx(10 * geometry.length(result.lines_mm[1]) / geometry.length(bent), rel=0.05)
