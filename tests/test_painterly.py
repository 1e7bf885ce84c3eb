"""The painting: like the photo, finer where the face is, in the manner asked for; and as lines that keep within it."""

import dataclasses

import cv2
import numpy as np
import pytest

import limner
from limner.vision.painterly.brush import paint, spline
from limner.vision.painterly.settings import MANNERS, PainterlySettings
from limner.vision.painterly.style import importance, painted
from portraits import astronaut, darkness_inked

PHOTO, FACE = astronaut()
UNIT = 100.0


def stripes(size=160):
    """Bands that run to the lower right, one soft wave across."""
    y, x = np.mgrid[:size, :size]
    light = 128 + 90 * np.sin((x - y) / 14)
    return np.repeat(light[..., None], 3, axis=2).astype(np.uint8)


@pytest.fixture(scope="module")
def drawn():
    return limner.draw(PHOTO, face=FACE, style="painterly")


def everywhere(picture, worth=1.0):
    return np.full(picture.shape[:2], worth, np.float32)


def fault(picture, wanted):
    return float(np.abs(picture.astype(float) - wanted).mean())


def test_a_spline_goes_from_end_to_end_and_keeps_a_straight_line():
    control = np.array([[0.0, 0], [10, 0], [20, 10], [30, 10]])
    curve = spline(control)
    assert np.allclose(curve[[0, -1]], control[[0, -1]])
    steps = np.hypot(*np.diff(curve, axis=0).T)
    assert steps.max() < 10
    straight = spline(np.stack([np.arange(6.0), 2 * np.arange(6.0)], axis=1))
    assert np.allclose(straight[:, 1], 2 * straight[:, 0])
    # Its curve lies within the control points' hull.
    assert (curve.min(axis=0) >= -1e-9).all()
    assert (curve.max(axis=0) <= [30 + 1e-9, 10 + 1e-9]).all()


def test_strokes_run_across_the_slope():
    manner = MANNERS["impressionist"]._replace(brushes=(0.04,), value=0.0)
    painting = paint(stripes(), everywhere(stripes()), manner, UNIT, 0)
    ways = np.array([line[-1] - line[0] for line in painting.lines if len(line) > 2])
    along = np.abs(ways @ [1, 1]) / np.maximum(np.hypot(*ways.T), 1e-9) / np.sqrt(2)
    assert len(ways) > 50
    assert np.median(along) > 0.95


@pytest.mark.parametrize("name", MANNERS)
def test_finer_brushes_bring_the_painting_nearer_to_the_photo(name):
    manner = MANNERS[name]._replace(hue=0, saturation=0, value=0, rgb=0, opacity=1.0, threshold=15)
    wanted = stripes()
    coarse = paint(wanted, everywhere(wanted), manner._replace(brushes=manner.brushes[:1]), UNIT, 0)
    fine = paint(wanted, everywhere(wanted), manner, UNIT, 0)
    assert fault(fine.canvas, wanted) < fault(coarse.canvas, wanted)
    assert (np.diff(fine.layer) >= 0).all()
    assert (np.diff(fine.radius) <= 0).all()
    assert len(fine.lines) == len(fine.radius) == len(fine.rgb) == len(fine.layer)


def test_a_flat_picture_is_painted_once():
    flat = np.full((120, 90, 3), 77, np.uint8)
    painting = paint(flat, everywhere(flat), MANNERS["impressionist"]._replace(value=0.0), UNIT, 0)
    assert set(painting.layer.tolist()) == {0}
    assert np.abs(painting.canvas.astype(int) - 77).max() <= 1


def test_no_stroke_leaves_the_picture_and_pointillists_dab():
    for name, manner in MANNERS.items():
        painting = paint(stripes(), everywhere(stripes()), manner, UNIT, 0)
        points = np.concatenate(painting.lines)
        assert points.min() >= 0, name
        assert points.max() <= 159, name
        longest = max(map(len, painting.lines))
        assert (longest == 1) == (name == "pointillist")


def test_chance_is_the_seeds():
    first, again, other = (paint(stripes(), everywhere(stripes()), MANNERS["wash"], UNIT, k) for k in (1, 1, 2))
    assert np.array_equal(first.canvas, again.canvas)
    assert not np.array_equal(first.canvas, other.canvas)


def test_it_is_finest_on_the_features():
    grow = 2.0
    large = limner.Photo(cv2.resize(PHOTO.rgb, None, fx=grow, fy=grow))
    larger = dataclasses.replace(FACE, points_px=FACE.points_px * grow, box_px=FACE.box_px * grow)
    worth = importance(larger, large.rgb.shape[:2], PainterlySettings())
    eye, corner = larger.points_px[36:42].mean(axis=0).astype(int), (5, 5)
    assert worth[eye[1], eye[0]] > 2 * worth[corner[1], corner[0]]
    plain, careful = (
        painted(large, larger, PainterlySettings(detail=detail, manner="impressionist")) for detail in (0.1, 2.5)
    )
    box = np.s_[eye[1] - 15 : eye[1] + 15, eye[0] - 20 : eye[0] + 20]
    assert fault(careful.canvas[box], large.rgb[box]) < 0.9 * fault(plain.canvas[box], large.rgb[box])


def test_lines_are_deterministic_and_stay_on_the_page(drawn):
    assert limner.draw(PHOTO, face=FACE, style="painterly").drawing == drawn.drawing
    points, page = np.concatenate(drawn.drawing.lines_mm), drawn.drawing.page
    assert points.min() >= page.margin_mm - 1e-6
    assert (points <= np.array([page.width_mm, page.height_mm]) - page.margin_mm + 1e-6).all()
    assert len(drawn.drawing.pens) == 4


def test_one_pen_draws_it_all_in_black():
    assert limner.draw(PHOTO, face=FACE, style="painterly", painterly__pens=1).drawing.pens == (limner.Pen(),)


@pytest.mark.parametrize("points", [200, 800])
def test_budgets_are_kept(points):
    drawing = limner.draw(PHOTO, face=FACE, style="painterly", points=points).drawing
    assert points * 0.8 <= drawing.points <= points
    assert "eye" in drawing.region


def test_more_ink_where_it_is_darker(drawn):
    assert darkness_inked(drawn) > 0.3


def test_its_picture_is_like_the_photo(drawn):
    picture = drawn.picture()
    assert picture.shape[0] > PHOTO.rgb.shape[0]
    assert 2 < fault(cv2.resize(picture, PHOTO.size_px, interpolation=cv2.INTER_AREA), PHOTO.rgb) < 20
    assert np.array_equal(picture, drawn.picture())
