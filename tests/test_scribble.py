"""Few long strokes: as far apart as asked, as many as asked, joined end to end; more ink where the face is dark."""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import limner
from limner import geometry
from limner.errors import NothingToDraw
from limner.motion.cost import costs
from limner.motion.machine import load_machine
from limner.stages import Stages
from limner.types import Photo
from limner.vision.lines import LineSettings, Sitter, draw_lines
from limner.vision.tonal.chain import Taste, chained
from limner.vision.tonal.scribble import CLOSEST_PX, ScribbleSettings, _Look, _strokes, spacing_px
from portraits import astronaut, plain_face

TASTE = Taste(light=3.0, turn_px=10.0, least_px=0.0)
WHITE = np.zeros((200, 200), np.float32)


@pytest.fixture(scope="module")
def session():
    return limner.Session(astronaut()[0])


def drawn(session, **changes):
    return session.draw(face=astronaut()[1], style="scribble", **changes)


def rows(count, gap=5.0, length=100):
    return [np.stack([np.arange(20.0, 20 + length), np.full(length, 20 + gap * k)], axis=1) for k in range(count)]


def lengths(lines):
    return np.array([geometry.length(line) for line in lines])


def gaps(lines):
    """Distance of each line's middle to the nearest other line."""
    found = []
    for k, line in enumerate(lines):
        others = np.concatenate([other for i, other in enumerate(lines) if i != k])
        found.append(np.hypot(*(others - line[len(line) // 2]).T).min())
    return np.array(found)


@pytest.mark.parametrize("ink", [0.25, 0.5, 1.0])
def test_strokes_are_as_far_apart_as_the_wanted_ink_says(ink):
    shape = (300, 300)
    along = np.stack([np.ones(shape, np.float32), np.zeros(shape, np.float32)])
    look = _Look(np.full(shape, ink, np.float32), along, np.zeros(shape, np.float32))
    loose = ScribbleSettings(strokes=10_000, tolerance=0.0)
    lines = [line for line in _strokes(look, 6.0, 256.0, loose) if geometry.length(line) > 200]
    assert gaps(lines).mean() == pytest.approx(6.0 / ink, rel=0.15)
    assert gaps(lines).min() > 0.6 * 6.0 / ink


def test_spacing_is_the_inverse_of_ink_within_limits():
    ink = np.repeat(np.array([[0.0, 0.01, 0.2, 1.0, 9.0]], np.float32), 40, axis=0).repeat(40, axis=1)
    middles = spacing_px(ink, 8.0, 50.0)[20, 20::40]
    assert middles == pytest.approx([0, 0, 39, 7, CLOSEST_PX - 1], rel=0.01)


def test_neighbours_become_one_stroke_that_turns_at_their_ends():
    (line,) = chained(rows(8), lengths(rows(8)), WHITE, 1, TASTE)
    assert geometry.length(line) < 8 * 99 + 7 * 12
    for row in rows(8):
        place = int(np.flatnonzero((line == row[0]).all(axis=1) | (line == row[-1]).all(axis=1))[0])
        piece = line[place : place + len(row)]
        assert (piece == row).all() or (piece == row[::-1]).all()
    # Never farther off than half a gap.
    assert line[:, 0].min() > 17
    assert line[:, 0].max() < 122


def test_a_link_goes_where_it_is_dark():
    """From the first row to one of two as near to it, of which the other lies over white paper."""
    first, upper, lower = (np.stack([np.arange(20.0, 60), np.full(40, y)], axis=1) for y in (100.0, 80, 120))
    for dark, chosen in ((slice(0, 100), upper), (slice(101, 200), lower)):
        ink = WHITE.copy()
        ink[dark] = 1
        lines = chained([first, upper, lower], np.full(3, 1e3), ink, 2, TASTE)
        joined = max(lines, key=len)
        assert (joined == chosen[0]).all(axis=1).any()
        assert (joined == first[0]).all(axis=1).any()


@given(st.integers(0, 10_000), st.integers(1, 40), st.integers(1, 12))
@settings(max_examples=60)
def test_never_more_strokes_than_asked_and_nothing_twice(seed, count, most):
    rng = np.random.default_rng(seed)
    lines = [np.cumsum(rng.normal(0, 3, (9, 2)), axis=0) + rng.uniform(20, 180, 2) for _ in range(count)]
    strokes = chained(lines, lengths(lines), WHITE, most, TASTE)
    assert 1 <= len(strokes) <= most
    whole = np.concatenate(strokes)
    for line in lines:
        assert (whole[:, None] == line[None, [0, 4, -1]]).all(axis=2).sum(axis=0).max() <= 1
    assert [s.tobytes() for s in strokes] == [s.tobytes() for s in chained(lines, lengths(lines), WHITE, most, TASTE)]


def test_a_crumb_far_away_is_left_out_but_not_an_eye():
    far = np.array([[190.0, 190], [192, 190], [194, 190]])
    lines = [*rows(2), far]
    assert len(chained(lines, np.array([99, 99, 4.0]), WHITE, 1, TASTE)) == 1
    assert not (chained(lines, np.array([99, 99, 4.0]), WHITE, 1, TASTE)[0] == far[0]).all(axis=1).any()
    assert (chained(lines, np.array([99, 99, 4e3]), WHITE, 1, TASTE)[0] == far[0]).all(axis=1).any()


def test_no_lines():
    assert chained([], np.zeros(0), WHITE, 20, TASTE) == []


@pytest.mark.parametrize("points", [400, 1500])
def test_budget_strokes_and_page(session, points):
    drawing = drawn(session, points=points).drawing
    assert 0.6 * points < drawing.points <= points
    assert 1 <= len(drawing.lines_mm) <= 20
    page, places = drawing.page, np.concatenate(drawing.lines_mm)
    assert places.min() >= page.margin_mm
    assert (places <= np.array([page.width_mm, page.height_mm]) - page.margin_mm).all()


def test_strokes_stay_on_the_photo(session):
    photo, face = astronaut()
    for line in draw_lines(photo, face, "scribble", LineSettings()).lines_px:
        assert (line >= -3).all()
        assert (line <= np.array(photo.size_px) + 2).all()


def test_ink_follows_the_wanted_ink(session):
    photo, face = astronaut()
    sitter = Sitter(photo, face, LineSettings(), Stages())
    back, ink = cv2.invertAffineTransform(sitter.working.photo_from_working), sitter.ink
    picture = np.zeros(ink.shape, np.uint8)
    for line in drawn(session).ink_px():
        fixed = np.rint((line @ back[:, :2].T + back[:, 2]) * 16).astype(np.int32)
        cv2.polylines(picture, [fixed], False, (1,), 1, cv2.LINE_8, 4)
    soft = [cv2.GaussianBlur(image.astype(np.float32), (0, 0), 8).ravel() for image in (picture, ink)]
    assert np.corrcoef(*soft)[0, 1] > 0.85


def test_minutes_are_kept(session):
    spent = costs(drawn(session, minutes=1.5).drawing, load_machine("axidraw")).seconds
    assert 60 < spent <= 90


def test_the_same_bytes_again(session):
    assert drawn(session, points=500).svg() == drawn(limner.Session(astronaut()[0]), points=500).svg()


def test_a_blank_photo_draws_nothing():
    with pytest.raises(NothingToDraw):
        limner.draw(Photo(np.full((640, 560, 3), 255, np.uint8)), style="scribble", face=plain_face(), points=500)
