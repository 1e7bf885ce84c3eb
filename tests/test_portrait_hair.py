import cv2
import numpy as np
import pytest

from limner import geometry
from limner.types import Photo
from limner.vision.figure import Figure, FigureSettings, find_figure
from limner.vision.lines import LineSettings, draw_lines
from limner.vision.portrait.hair import beside_hair, clutter, hair_of_head
from limner.vision.portrait.masses import CLOSEST, draw_masses
from limner.vision.portrait.seen import FlowSettings, look_at
from limner.vision.portrait.shoulders import draw_shoulders
from limner.vision.raster import dilated
from portraits import ink, painted

BODY = 0.75


def sitter(**changes):
    photo, face = painted(**changes)
    return look_at(photo, FlowSettings()), face, find_figure(photo, face, FigureSettings())


@pytest.fixture(scope="module")
def plain():
    return sitter()


def dark_hair(photo):
    return photo.rgb.astype(int).sum(axis=2) < 150


def test_strokes_in_dark_hair_stay_in_it_and_keep_apart(plain):
    _, face, _ = plain
    hair = dilated(dark_hair(painted()[0]), 6)
    lengths = []
    for apart in (0.06, 0.1, 0.2):
        lines = [mark.line for mark in draw_masses(*plain, [], apart)]
        lengths.append(geometry.total_length(lines))
        columns, rows = np.rint(ink(lines)).astype(int).T
        assert hair[rows, columns].all()
        for i, line in enumerate(lines):
            others = [other for k, other in enumerate(lines) if k != i]
            away = np.hypot(*(geometry.resample(line, 2.0)[:, None] - ink(others)).transpose(2, 0, 1)).min()
            assert away > 0.5 * CLOSEST * face.outer_eye_px
    assert lengths[0] > 1.2 * lengths[1] > 1.2 * lengths[2] > 0


def test_no_strokes_in_light_hair_nor_where_none_are_wanted(plain):
    photo, face = painted()
    blond = photo.rgb.copy()
    blond[dark_hair(photo)] = (225, 205, 150)
    figure = plain[2]
    assert not draw_masses(look_at(Photo(blond), FlowSettings()), face, figure, [], 0.075)
    assert not draw_masses(*plain, [], 0.0)
    assert draw_masses(*plain, [], 0.075)


def test_strokes_in_hair_keep_off_what_is_drawn(plain):
    first = draw_masses(*plain, [], 0.075)
    second = draw_masses(*plain, first, 0.075)
    assert sum(geometry.length(mark.line) for mark in second) < 0.4 * sum(geometry.length(mark.line) for mark in first)


def test_dark_hair_is_the_first_to_go():
    photo, face = painted()
    settings = LineSettings()
    empty = settings.replace(portrait=settings.portrait.replace(dark_apart=0.0))
    with_strokes, without = (draw_lines(photo, face, "portrait", each) for each in (settings, empty))
    assert len(with_strokes.lines_px) > len(without.lines_px)
    added = sorted(set(with_strokes.weight.tolist()) - set(without.weight.tolist()))
    hair = [w for w, region in zip(without.weight, without.region, strict=True) if region == "hair"]
    assert max(added) < max(hair)
    face_ink = [
        w for w, region in zip(without.weight, without.region, strict=True) if region in ("eye", "mouth", "jaw")
    ]
    assert max(added) < np.median(face_ink)


def test_shoulders_lie_on_the_outline_on_both_sides(plain):
    _, face, figure = plain
    marks = draw_shoulders(*plain, BODY)
    outline = cv2.morphologyEx(figure.figure.astype(np.uint8), cv2.MORPH_GRADIENT, np.ones((3, 3), np.uint8))
    rows, columns = np.nonzero(outline)
    border = np.stack([columns, rows], axis=1).astype(float)
    points = ink([mark.line for mark in marks], 4.0)
    away = np.hypot(*(points[:, None] - border).transpose(2, 0, 1)).min(axis=1)
    assert np.quantile(away, 0.95) < 0.06 * face.outer_eye_px
    assert points[:, 1].min() > face.points_px[8, 1] - 0.5 * face.outer_eye_px
    middle = face.points_px[8, 0]
    assert points[:, 0].min() < middle - face.outer_eye_px
    assert points[:, 0].max() > middle + face.outer_eye_px
    assert not draw_shoulders(*plain, 0.0)


def test_where_no_outline_is_seen_no_shoulder_is_drawn(plain):
    _, face, figure = plain
    blank = look_at(Photo(np.full((620, 560, 3), 180, np.uint8)), FlowSettings())
    assert not draw_shoulders(blank, face, figure, BODY)


def test_hair_of_the_head_reaches_above_the_eyes(plain):
    _, face, _ = plain
    shape = (620, 560)
    hair, clothes, none = np.zeros(shape, bool), np.zeros(shape, bool), np.zeros(shape, bool)
    hair[100:320, 180:230] = True
    clothes[480:520, 150:260] = True
    both = hair | clothes
    found = hair_of_head(face, Figure(both, none, both, none, none))
    assert (found == hair).all()
    assert beside_hair(np.array([[235.0, 120.0], [235.0, 300.0]]), found, face.outer_eye_px)
    assert not beside_hair(np.array([[160.0, 500.0], [250.0, 500.0]]), found, face.outer_eye_px)


def test_a_busy_background_is_seen_as_clutter(plain):
    stripes = np.full((620, 560, 3), 200, np.uint8)
    stripes[:, ::20], stripes[:, 1::20], stripes[:, 2::20] = 60, 60, 60
    assert clutter(*sitter(background=stripes)) > 0.1 > 0.02 > clutter(*plain)
    everywhere = np.ones((620, 560), bool)
    none = ~everywhere
    assert clutter(plain[0], plain[1], Figure(everywhere, everywhere, none, none, none)) == 0
