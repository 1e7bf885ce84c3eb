"""Strokes land on the page: centred, as large as the margins allow, y up; and the map for the SVG agrees."""

import numpy as np
import pytest
from hypothesis import assume, given, strategies as st
from hypothesis.extra.numpy import arrays

from drawings import drawings
from limner.drawing.compose import ComposeSettings, compose, fill_page, grown, page_from_photo
from limner.errors import BadInput, CannotDraw, NothingToDraw
from limner.types import Page, Pen, Strokes


def strokes(*lines, size=(640, 480)):
    return Strokes(tuple(lines), ("face",) * len(lines), np.ones(len(lines)), size)


LINE = arrays(np.float64, st.tuples(st.integers(1, 8), st.just(2)), elements=st.floats(-1000, 2000))
SOME = st.lists(LINE, min_size=1, max_size=6).map(lambda lines: strokes(*lines))
PAGES = st.builds(Page, st.floats(50, 500), st.floats(50, 500), st.floats(0, 20))
PENS = st.builds(Pen, st.floats(0.1, 5))
FITS = st.sampled_from([ComposeSettings(), ComposeSettings(fit="photo"), ComposeSettings(max_width_mm=30.0)])


@given(SOME, PAGES, FITS, PENS)
def test_the_map_says_where_every_point_went(some, page, settings, pen):
    drawing = compose(some, page, settings, pen)
    affine = page_from_photo(some, page, settings, pen)
    for px, mm in zip(some.lines_px, drawing.lines_mm, strict=True):
        svg = px @ affine[:, :2].T + affine[:, 2]
        assert np.allclose(mm, svg * [1, -1] + [0, page.height_mm], atol=1e-9)
    assert (drawing.region, drawing.page, drawing.pen) == (some.region, page, pen)
    assert (drawing.weight == some.weight).all()


@given(SOME, PAGES, FITS, PENS)
def test_the_map_keeps_shapes(some, page, settings, pen):
    affine = page_from_photo(some, page, settings, pen)
    assert affine[0, 0] == affine[1, 1] > 0
    assert affine[0, 1] == affine[1, 0] == 0


@given(SOME, PAGES, PENS, st.one_of(st.none(), st.floats(5, 50)))
def test_all_ink_stays_off_the_margins_and_is_centred(some, page, pen, most):
    drawing = compose(some, page, ComposeSettings(max_width_mm=most), pen)
    points = np.concatenate(drawing.lines_mm)
    edge = page.margin_mm + pen.width_mm / 2 - 1e-6
    low, high = points.min(axis=0), points.max(axis=0)
    assert (low >= edge).all()
    assert (high <= np.array([page.width_mm, page.height_mm]) - edge).all()
    assert np.allclose((low + high) / 2, [page.width_mm / 2, page.height_mm / 2], atol=1e-6)
    if most is not None:
        assert high[0] - low[0] <= most + 1e-6


@given(SOME, PAGES)
def test_the_strokes_fill_the_room_in_one_direction(some, page):
    extent = np.ptp(np.concatenate(some.lines_px), axis=0)
    assume(extent.min() > 640 / 50)
    drawing = compose(some, page, ComposeSettings(), Pen(0.5))
    room = np.array([page.width_mm, page.height_mm]) - 2 * page.margin_mm - 0.5
    filled = np.ptp(np.concatenate(drawing.lines_mm), axis=0) / room
    assert filled.max() == pytest.approx(1)


@given(SOME, PAGES, st.tuples(st.floats(-500, 500), st.floats(-500, 500)), st.floats(0.2, 5))
def test_where_and_how_large_the_photo_is_makes_no_difference_to_a_fit_of_its_content(some, page, shift, scale):
    moved = strokes(*(line * scale + shift for line in some.lines_px), size=(round(640 * scale), round(480 * scale)))
    assume(np.ptp(np.concatenate(some.lines_px), axis=0).min() > 20)
    for a, b in zip(
        compose(some, page, ComposeSettings()).lines_mm, compose(moved, page, ComposeSettings()).lines_mm, strict=True
    ):
        assert np.allclose(a, b, atol=1e-6)


def test_the_whole_photo_fits_edge_to_edge():
    corners = np.array([[-0.5, -0.5], [639.5, -0.5], [639.5, 479.5], [-0.5, 479.5]])
    drawing = compose(strokes(corners), Page(148, 210, 10), ComposeSettings(fit="photo"), Pen(1))
    height = 127 * 480 / 640
    low, high = 105 - height / 2, 105 + height / 2
    assert np.allclose(drawing.lines_mm[0], [[10.5, high], [137.5, high], [137.5, low], [10.5, low]])


def test_what_is_higher_in_the_photo_is_higher_on_the_page():
    drawing = compose(strokes(np.array([[0, 0], [100.0, 200]])), Page(), ComposeSettings())
    assert drawing.lines_mm[0][0, 1] > drawing.lines_mm[0][1, 1]
    assert drawing.lines_mm[0][0, 0] < drawing.lines_mm[0][1, 0]


@pytest.mark.parametrize("line", [[[50.0, 50]], [[50.0, 50]] * 3, [[50, 50], [50, 50.001]], [[-300.0, 900]]])
def test_a_speck_is_centred_and_not_magnified(line):
    drawing = compose(strokes(np.array(line)), Page(), ComposeSettings())
    assert np.allclose(drawing.lines_mm[0], [74, 105], atol=0.1)


def test_no_stroke_is_nothing_to_draw():
    with pytest.raises(NothingToDraw, match="no stroke"):
        compose(strokes(), Page(), ComposeSettings())
    assert page_from_photo(strokes(), Page(), ComposeSettings()).shape == (2, 3)


def test_no_room_on_the_page():
    with pytest.raises(CannotDraw, match="margins of"):
        compose(strokes(np.array([[0, 0], [1.0, 1]])), Page(10, 10, 4.9), ComposeSettings(), Pen(0.5))


@pytest.mark.parametrize("far", [1e8, -1e300])
def test_absurdly_far_points_are_refused(far):
    with pytest.raises(BadInput, match="away from the photo"):
        compose(strokes(np.array([[0, 0], [0, far]])), Page(), ComposeSettings())


def test_a_photo_of_no_size_is_still_placed():
    assert compose(strokes(np.array([[3.0, 4]]), size=(0, 0)), Page(), ComposeSettings()).points == 1


@given(drawings(least=1), st.sampled_from([None, 60.0]))
def test_what_was_chosen_fills_the_page_again(drawing, max_width):
    settings = ComposeSettings(max_width_mm=max_width)
    filling, growth = fill_page(drawing, settings)
    scale = growth[0, 0]
    for line, before in zip(filling.lines_mm, drawing.lines_mm, strict=True):
        assert line == pytest.approx(before * scale + growth[:, 2])
    if filling == drawing:
        assert (growth == np.eye(2, 3)).all()
        return
    assert 1.02 <= scale <= 2
    points = np.concatenate(filling.lines_mm)
    inset = drawing.page.margin_mm + drawing.pen.width_mm / 2
    sides = np.array([drawing.page.width_mm, drawing.page.height_mm])
    assert (points >= inset - 1e-6).all()
    assert (points <= sides - inset + 1e-6).all()
    assert points.min(axis=0) + points.max(axis=0) == pytest.approx(sides)


def test_the_map_from_the_photo_grows_with_the_drawing():
    page = Page()
    affine, growth = np.array([[0.5, 0, 7], [0, 0.5, 9]]), np.array([[1.5, 0, -3], [0, 1.5, 4.0]])
    x, y = affine[:, :2] @ [20, 30] + affine[:, 2]
    expected = growth[:, :2] @ [x, page.height_mm - y] + growth[:, 2]
    got = grown(affine, growth, page) @ [20, 30, 1]
    assert [got[0], page.height_mm - got[1]] == pytest.approx(expected.tolist())
