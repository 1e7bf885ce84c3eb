"""Contact sheets hold their tiles, evenly and unchanged; landmarks lie where they are."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from drawings import of
from limner.drawing.compose import ComposeSettings, compose, page_from_photo
from limner.errors import BadInput
from limner.targets.framing import frame_face, frame_photo
from limner.targets.image import to_rgb
from limner.targets.overlay import overlay
from limner.targets.sheet import Tile, to_sheet
from limner.types import Face, Page, Photo, Strokes


def flat(width, height, value):
    return np.full((height, width, 3), value, np.uint8)


@given(
    st.lists(st.tuples(st.integers(1, 300), st.integers(1, 300)), min_size=1, max_size=7),
    st.none() | st.integers(1, 5),
    st.integers(40, 200),
)
@settings(max_examples=40, deadline=None)
def test_every_tile_is_there(sizes, columns, tile_px):
    tiles = [Tile(flat(w, h, (10 + 30 * k, 0, 200)), f"Tile {k}", "note") for k, (w, h) in enumerate(sizes)]
    sheet = to_sheet(tiles, columns, tile_px)
    for k, (w, h) in enumerate(sizes):
        scale = min(tile_px / w, tile_px * 1.6 / h)
        area = max(1, round(w * scale)) * max(1, round(h * scale))
        assert (sheet == (10 + 30 * k, 0, 200)).all(axis=2).sum() >= area
    assert (sheet[[0, -1]] == 255).all()
    assert (sheet[:, [0, -1]] == 255).all()


def test_tiles_stand_evenly_row_by_row():
    sheet = to_sheet([Tile(flat(100, 60, (0, 0, 10 * k)), "") for k in range(1, 6)], 3, 100)
    corners = [np.argwhere((sheet == (0, 0, 10 * k)).all(axis=2)).min(axis=0) for k in range(1, 6)]
    tops, lefts = zip(*(corner.tolist() for corner in corners), strict=True)
    assert tops[0] == tops[1] == tops[2] < tops[3] == tops[4]
    assert lefts[:2] == lefts[3:]
    assert lefts[1] - lefts[0] == lefts[2] - lefts[1] == 107
    assert sheet.shape[1] - lefts[2] - 100 == lefts[0] == 7


@pytest.mark.parametrize(("count", "columns"), [(1, 1), (2, 2), (4, 4), (5, 3), (6, 3), (8, 4), (9, 3)])
def test_rows_come_out_even(count, columns):
    sheet = to_sheet([Tile(flat(50, 50, 0), "")] * count, tile_px=100)
    assert sheet.shape[1] == 7 + columns * 107


def test_captions_are_under_their_tile_and_never_wider():
    plain = to_sheet([Tile(flat(100, 60, 128), "")] * 2, tile_px=200)
    long = "A very long title that cannot possibly fit under a small picture\nlet alone on two lines " * 3
    told = to_sheet(
        [Tile(flat(100, 60, 128), long, "12 strokes \u00b7 1.2 m"), Tile(flat(100, 60, 128), "b")], tile_px=200
    )
    ink = np.argwhere((told < 128).all(axis=2))
    assert len(ink) > 200
    assert ink[:, 0].min() >= 14 + 120
    first = ink[ink[:, 1] < 14 + 200 + 7]
    assert first[:, 1].min() >= 14
    assert first[:, 1].max() < 14 + 200
    assert plain.shape[1] == told.shape[1]


def test_the_same_tiles_give_the_same_sheet():
    tiles = [Tile(flat(90, 60, 50), "One", "two"), Tile(flat(40, 90, 150), "Three")]
    assert (to_sheet(tiles) == to_sheet(tiles)).all()


@pytest.mark.parametrize(("tiles", "columns", "tile_px"), [(0, None, 100), (1, 0, 100), (1, None, 0)])
def test_sheets_that_make_no_sense(tiles, columns, tile_px):
    with pytest.raises(BadInput, match="sheet"):
        to_sheet([Tile(flat(9, 9, 0), "a")] * tiles, columns, tile_px)


def face(center=(150, 150), size=100, count=68):
    """Landmarks on a spiral: anywhere will do."""
    t = np.linspace(0, 6, count)
    points = np.array(center) + size * np.stack([(0.3 + t / 12) * np.cos(t), (0.3 + t / 12) * np.sin(t)], axis=1)
    low, high = points.min(axis=0) - size * 0.1, points.max(axis=0) + size * 0.1
    return Face(points, np.concatenate([low, high]))


def changed(photo, faces, scale=1.0):
    rgb = overlay(photo, faces, scale)
    return (rgb != overlay(photo, [], scale)).any(axis=2)


@pytest.mark.parametrize("count", [68, 39])
@pytest.mark.parametrize("scale", [0.5, 1.0, 2.0])
def test_every_landmark_is_marked_where_it_is(count, scale):
    photo, one = Photo(flat(300, 300, 90)), face(count=count)
    marks = changed(photo, [one], scale)
    assert marks.shape == (300 * scale, 300 * scale)
    for x, y in np.rint((one.points_px + 0.5) * scale - 0.5).astype(int):
        assert marks[y, x]
    rows, columns = np.nonzero(marks)
    low, high = one.points_px.min(axis=0) * scale, one.points_px.max(axis=0) * scale
    assert (low - [columns.min(), rows.min()] < 12 * scale + 3).all()
    assert ([columns.max(), rows.max()] - high < 12 * scale + 3).all()


def test_marks_grow_with_the_face():
    photo = Photo(flat(900, 900, 90))
    small, large = changed(photo, [face((450, 450), 100)]), changed(photo, [face((450, 450), 400)])
    assert large.sum() > 6 * small.sum()


def test_boxes_and_numbers_only_for_several_faces():
    photo = Photo(flat(700, 300, 90))
    one, two = face((150, 150)), face((500, 150))
    alone = changed(photo, [one])
    both = changed(photo, [one, two])
    x, y = np.rint(one.box_px[[2, 1]]).astype(int)
    assert both[y + 40, x - 2 : x + 3].any()
    assert not alone[y + 40, x - 2 : x + 3].any()
    first, second = overlay(photo, [one, two])[:, :320], overlay(photo, [two, one])[:, :320]
    assert (first != second).any()


def test_a_face_that_leaves_the_photo_and_a_tiny_one():
    photo = Photo(flat(50, 40, 90))
    assert overlay(photo, [face((0, 0), 500), face((20, 20), 3), face((1e7, 1e7), 1e6)]).shape == (40, 50, 3)
    assert (photo.rgb == 90).all()


@pytest.mark.parametrize("scale", [0, -1, np.nan, 1e6])
def test_scales_that_make_no_sense(scale):
    with pytest.raises(BadInput, match="overlay"):
        overlay(Photo(flat(50, 40, 90)), [], scale)


@settings(max_examples=60, deadline=None)
@given(
    st.tuples(st.integers(1, 300), st.integers(1, 300)),
    st.floats(0.01, 3),
    st.tuples(st.floats(-200, 300), st.floats(-200, 300)),
    st.sampled_from([0.3, 1.0, 4.0]),
)
def test_a_framed_photo_is_as_large_as_the_drawing_s_picture(size, scale, shift, px_per_mm):
    photo = Photo(flat(*size, 7))
    affine = np.array([[scale, 0, shift[0]], [0, scale, shift[1]]])
    framed = frame_photo(photo, affine, Page(), px_per_mm)
    assert framed.rgb.shape == to_rgb(of(), px_per_mm).shape
    assert set(np.unique(framed.rgb)) <= {7, 255}


def test_photo_drawing_and_landmarks_lie_over_each_other_on_the_page():
    rgb = flat(640, 480, 250)
    rgb[100:300, 200:202] = 0
    line = np.array([[200.5, 100], [200.5, 299]])
    strokes = Strokes((line, np.array([[50, 50], [600, 450.0]])), ("face",) * 2, np.ones(2), (640, 480))
    page, how = Page(), ComposeSettings()
    affine = page_from_photo(strokes, page, how)
    framed = frame_photo(Photo(rgb), affine, page, 4)
    drawn = to_rgb(compose(Strokes((line,), ("face",), np.ones(1), (640, 480)), page, how), 4)
    drawing = compose(strokes, page, how)
    dark = np.argwhere(framed.rgb[..., 0] < 128)
    ends = drawing.lines_mm[0]
    assert dark[:, 1].mean() == pytest.approx(ends[0, 0] * 4 - 0.5, abs=1)
    assert dark[:, 0].min() == pytest.approx((page.height_mm - ends[0, 1]) * 4 - 0.5, abs=1.5)
    assert dark[:, 0].max() == pytest.approx((page.height_mm - ends[1, 1]) * 4 - 0.5, abs=1.5)
    assert drawn.shape == framed.rgb.shape
    moved = frame_face(face((200, 150), 40), affine, 4)
    expected = face((200, 150), 40).points_px @ affine[:, :2].T + affine[:, 2]
    assert np.allclose((moved.points_px + 0.5) / 4, expected)
