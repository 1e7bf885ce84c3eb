"""The picture shows the ink where it is and as wide as the pen."""

import io
import itertools

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from PIL import Image

from drawings import drawings, of
from limner import geometry
from limner.errors import BadInput
from limner.targets import image as module
from limner.targets.image import encode_png, to_png, to_rgb
from limner.types import Drawing, Page, Pen


def drawn(*lines, page=(60, 40), pen=0.5):
    some = of(*lines)
    return Drawing(some.lines_mm, some.region, some.weight, Page(*page, 0), (Pen(pen),))


def ink_mm2(drawing, px_per_mm):
    return float((255 - to_rgb(drawing, px_per_mm)[..., 0].astype(float)).sum() / 255 / px_per_mm**2)


@pytest.mark.parametrize("angle", range(0, 180, 20))
@pytest.mark.parametrize(("pen", "px_per_mm"), [(0.5, 8), (0.3, 4), (0.3, 11.811), (1.0, 3), (2.0, 10)])
def test_a_line_is_as_wide_as_the_pen(angle, pen, px_per_mm):
    along = np.array([np.cos(np.deg2rad(angle)), np.sin(np.deg2rad(angle))])
    drawing = drawn([[30, 20] - 14 * along, [30, 20] + 14 * along], pen=pen)
    assert ink_mm2(drawing, px_per_mm) == pytest.approx(28 * pen + np.pi * pen**2 / 4, rel=0.08)


@pytest.mark.parametrize("pen", [0.3, 0.5, 1.0, 4.0])
def test_a_dot_is_a_disc(pen):
    for dot in ([[30.2, 20.1]], [[30.2, 20.1]] * 3):
        assert ink_mm2(drawn(dot, pen=pen), 12) == pytest.approx(np.pi * pen**2 / 4, rel=0.12)


def test_ink_is_within_half_a_pen_of_the_line_and_nowhere_else():
    line = np.array([[5, 5], [50, 10], [30, 35], [30, 20], [8, 30.0]])
    drawing = drawn(line, pen=1.2)
    rgb = to_rgb(drawing, 10)
    y, x = np.indices(rgb.shape[:2])
    places = np.stack([(x.ravel() + 0.5) / 10, 40 - (y.ravel() + 0.5) / 10], axis=1)
    away = [geometry.distance_to_segments(places, a, b) for a, b in itertools.pairwise(line)]
    away = np.min(away, axis=0).reshape(rgb.shape[:2])
    assert (rgb[away < 0.6 - 0.12] == 0).all()
    assert (rgb[away > 0.6 + 0.12] == 255).all()


def test_up_on_the_page_is_up_in_the_picture():
    rgb = to_rgb(drawn([[5, 35], [10, 35]]), 4)
    assert rgb.shape == (160, 240, 3)
    rows, columns = np.nonzero(rgb[..., 0] < 128)
    assert rows.mean() == pytest.approx((40 - 35) * 4 - 0.5, abs=0.3)
    assert columns.mean() == pytest.approx(7.5 * 4 - 0.5, abs=0.3)


@settings(max_examples=40, deadline=None)
@given(drawings(), st.sampled_from([0.5, 2, 3.7]))
def test_any_drawing_can_be_shown(drawing, px_per_mm):
    rgb = to_rgb(drawing, px_per_mm)
    page = drawing.page
    assert rgb.shape == (round(page.height_mm * px_per_mm), round(page.width_mm * px_per_mm), 3)
    assert rgb.dtype == np.uint8
    assert (rgb == 255).all() == (not drawing.lines_mm)


@settings(max_examples=20, deadline=None)
@given(drawings())
def test_bands_show_by_a_row_of_sub_pixels_at_most(drawing):
    whole = to_rgb(drawing, 2)
    kept = module._BAND_SUBPIXELS
    module._BAND_SUBPIXELS = 200_000
    try:
        off = np.abs(to_rgb(drawing, 2).astype(int) - whole.astype(int))
    finally:
        module._BAND_SUBPIXELS = kept
    assert off.max() <= 255 / 8 + 1


def test_what_is_off_the_page_is_cut_off():
    far = to_rgb(drawn([[-1e9, 20], [1e9, 20]], [[1e12, -1e12]]), 4)
    assert (far[80, :] < 255).any()
    assert (far[:70] == 255).all()
    assert ink_mm2(drawn([[-30, 20], [30, 20]]), 8) == pytest.approx(30 * 0.5 + np.pi / 32, rel=0.05)


def test_png_knows_its_size_and_is_always_the_same():
    drawing = drawn([[5, 5], [50, 30]])
    data = to_png(drawing, 300)
    assert data == to_png(drawing, 300)
    picture = Image.open(io.BytesIO(data))
    assert picture.info["dpi"] == pytest.approx((300, 300), rel=1e-3)
    assert picture.size == (round(60 / 25.4 * 300), round(40 / 25.4 * 300))
    assert (np.asarray(picture) == to_rgb(drawing, 300 / 25.4)[..., 0]).all()


def test_encoding_keeps_every_pixel():
    rgb = np.random.default_rng(0).integers(0, 256, (9, 7, 3), np.uint8)
    assert (np.asarray(Image.open(io.BytesIO(encode_png(rgb)))) == rgb).all()


@pytest.mark.parametrize("px_per_mm", [0, -1, np.nan, np.inf, 1000])
def test_resolutions_that_make_no_sense(px_per_mm):
    with pytest.raises(BadInput, match=r"image: .*pixels per mm"):
        to_rgb(drawn([[5, 5], [50, 30]]), px_per_mm)
