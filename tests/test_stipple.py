"""Dots as dense as asked, each in its cell; ink where a face is dark; drawings made for their budget."""

import dataclasses

import cv2
import numpy as np
import pytest
from hypothesis import given, strategies as st
from shapely.geometry import LineString

import limner
from limner.errors import NothingToDraw
from limner.motion.cost import costs
from limner.motion.machine import load_machine
from limner.stages import Stages
from limner.types import Photo
from limner.vision.likeness.picture import PAPER, drawing_picture, upright_from_photo
from limner.vision.lines import LineSettings, Sitter, draw_lines
from limner.vision.raster import filled
from limner.vision.tonal.voronoi import _hilbert, stipple_dots
from portraits import astronaut, plain_face

SETTINGS = LineSettings()


@pytest.fixture(scope="module")
def wanted():
    photo, face = astronaut()
    sitter = Sitter(photo, face, SETTINGS, Stages())
    return sitter.working, sitter.ink


@pytest.fixture(scope="module")
def session():
    return limner.Session(astronaut()[0])


def drawn(session, **changes):
    return session.draw(face=astronaut()[1], **changes)


def blurred(image, sigma):
    return cv2.GaussianBlur(np.asarray(image, np.float32), (0, 0), sigma)


def dots_picture(dots, shape):
    image = np.zeros(shape, np.float32)
    columns, rows = np.rint(dots).astype(int).T
    np.add.at(image, (rows, columns), 1)
    return image


def agreement(image, other, sigma):
    return np.corrcoef(blurred(image, sigma).ravel(), blurred(other, sigma).ravel())[0, 1]


@pytest.mark.parametrize("side", [2, 8, 32])
def test_the_curve_goes_from_neighbour_to_neighbour_over_all_places(side):
    places = np.argwhere(np.ones((side, side)))
    along = _hilbert(places)
    assert sorted(along.tolist()) == list(range(side * side))
    steps = np.abs(np.diff(places[np.argsort(along)], axis=0)).sum(axis=1)
    assert (steps == 1).all()


@given(st.integers(1, 300), st.integers(0, 5))
def test_as_many_dots_as_asked_all_where_there_is_density(count, seed):
    density = np.zeros((60, 80), np.float32)
    density[10:50, 20:70] = 1
    dots = stipple_dots(density, count, 3, seed)
    assert dots.shape == (count, 2)
    assert (dots >= [19.5, 9.5]).all()
    assert (dots <= [69.5, 49.5]).all()


def test_even_density_gives_even_distances():
    dots = stipple_dots(np.ones((100, 100), np.float32), 400, 40, 0)
    gaps = np.hypot(*(dots[:, None] - dots[None]).transpose(2, 0, 1)) + 1e9 * np.eye(400)
    nearest = gaps.min(axis=1)
    # Chance alone has a mean of 2.5 px and a variation of half of it.
    assert nearest.mean() > 4
    assert nearest.std() / nearest.mean() < 0.12


def test_dots_follow_a_ramp():
    ramp = np.tile(np.linspace(0, 1, 120, dtype=np.float32), (60, 1))
    dots = stipple_dots(ramp, 1500, 20, 0)
    counts = np.histogram(dots[:, 0], bins=6, range=(-0.5, 119.5))[0]
    assert counts == pytest.approx(1500 * np.arange(1, 12, 2) / 36, abs=25)


def test_dots_are_in_the_middle_of_their_cells():
    """Against the cells found by trying every dot at every pixel."""
    ramp = np.tile(np.linspace(0.2, 1, 90, dtype=np.float32), (90, 1))
    dots = stipple_dots(ramp, 60, 80, 1)
    places = np.argwhere(np.ones((90, 90)))[:, ::-1]
    cell = np.hypot(*(places[:, None] - dots[None]).transpose(2, 0, 1)).argmin(axis=1)
    mass = np.bincount(cell, ramp.ravel())
    centre = np.stack([np.bincount(cell, ramp.ravel() * places[:, k]) / mass for k in (0, 1)], axis=1)
    assert np.hypot(*(centre - dots).T).mean() < 0.5


def test_no_density_no_dots_and_no_more_dots_than_pixels():
    assert len(stipple_dots(np.zeros((9, 9), np.float32), 50, 3, 0)) == 0
    one = np.zeros((9, 9), np.float32)
    one[4, 2] = 1
    assert 1 <= len(stipple_dots(one, 5, 3, 0)) <= 5


def test_seeds():
    density = np.ones((40, 40), np.float32)
    one, same, other = (stipple_dots(density, 90, 2, seed) for seed in (3, 3, 4))
    assert one.tobytes() == same.tobytes() != other.tobytes()


def test_ink_is_on_the_person_and_most_on_what_a_face_is_known_by(wanted):
    working, ink = wanted
    face = working.face.points_px
    eyes = filled(face[36:42], ink.shape) | filled(face[42:48], ink.shape)
    cheek = filled(face[[1, 2, 3, 31, 39]], ink.shape)
    assert ink.min() >= 0
    assert ink[eyes].mean() > 4 * ink[cheek].mean()
    assert ink[: ink.shape[0] // 3, -40:].mean() < 0.01


def test_dots_follow_the_wanted_ink(wanted):
    working, ink = wanted
    photo, face = astronaut()
    strokes = draw_lines(photo, face, "stipple", SETTINGS)
    assert all(line.shape == (1, 2) for line in strokes.lines_px)
    dots = np.concatenate(strokes.lines_px)
    assert (dots >= -0.5).all()
    assert (dots <= np.array(photo.size_px) - 0.5).all()
    back = cv2.invertAffineTransform(working.photo_from_working)
    picture = dots_picture(dots @ back[:, :2].T + back[:, 2], ink.shape)
    assert agreement(picture, ink**SETTINGS.stipple.power, 6) > 0.95


def test_line_follows_the_wanted_ink(wanted, session):
    working, ink = wanted
    portrait = drawn(session, style="one-line")
    back = cv2.invertAffineTransform(working.photo_from_working)
    line = portrait.ink_px()[0] @ back[:, :2].T + back[:, 2]
    picture = np.zeros(ink.shape, np.uint8)
    cv2.polylines(picture, [np.rint(line * 16).astype(np.int32)], False, (1,), 1, cv2.LINE_8, 4)
    assert agreement(picture, ink, 8) > 0.75


@pytest.mark.parametrize("points", [40, 300])
@pytest.mark.parametrize("style", ["stipple", "one-line"])
def test_points_are_the_number_of_points(session, style, points):
    drawing = drawn(session, style=style, points=points).drawing
    assert drawing.points == points
    assert len(drawing.lines_mm) == (points if style == "stipple" else 1)


def test_one_line_is_one_stroke_that_never_crosses_itself(session):
    portrait = drawn(session, style="one-line", points=3000)
    assert portrait.report()["strokes"] == 1
    assert portrait.report()["lifts"] == 1
    assert LineString(portrait.drawing.lines_mm[0]).is_simple
    ends = portrait.drawing.page.margin_mm, portrait.drawing.page.height_mm - portrait.drawing.page.margin_mm
    assert portrait.drawing.lines_mm[0][:, 1].min() >= ends[0]
    assert portrait.drawing.lines_mm[0][:, 1].max() <= ends[1]


def test_a_smooth_line_keeps_the_budget_and_does_not_cross_itself(session):
    drawing = drawn(session, style="one-line", points=1200, thread__smooth="true").drawing
    assert 1180 < drawing.points <= 1200
    assert LineString(drawing.lines_mm[0]).is_simple


@pytest.mark.parametrize(("style", "minutes"), [("stipple", 0.5), ("one-line", 0.5)])
def test_minutes_are_kept_and_used(session, style, minutes):
    drawing = drawn(session, style=style, minutes=minutes).drawing
    assert 0.9 * 60 * minutes < costs(drawing, load_machine("axidraw")).seconds <= 60 * minutes


def test_the_same_bytes_again(session):
    changes = {"style": "one-line", "points": 300}
    assert drawn(session, **changes).svg() == drawn(limner.Session(astronaut()[0]), **changes).svg()


def test_a_blank_photo_draws_nothing():
    with pytest.raises(NothingToDraw):
        limner.draw(Photo(np.full((640, 560, 3), 255, np.uint8)), style="stipple", face=plain_face(), points=50)


def test_likeness_sees_dots():
    face = plain_face()
    upright = upright_from_photo(face.points_px)
    dots = [point[None] for point in face.points_px[36:48]]
    assert drawing_picture(dots, 2.0, upright).min() < PAPER / 2


def test_dots_know_what_they_draw(session):
    strokes = dataclasses.replace(drawn(session, style="stipple", points=600)).strokes
    assert {"eye", "brow", "mouth", "nose"} <= set(strokes.region)
    assert (np.diff(strokes.weight) <= 0).all()
