import cv2
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from limner.types import Photo
from limner.vision.edges.gabor_pyramid import GaborPyramidSettings, at_level, gabor_pyramid_edges, prepared
from limner.vision.scale import ScaleSettings, to_working_scale
from limner.vision.skeleton import skeletonize
from portraits import astronaut, line_photo, plain_face

SETTINGS = GaborPyramidSettings()
BARE = SETTINGS.replace(share=0.0, apart=0.0)
FACE = plain_face()


@pytest.fixture(scope="module")
def working():
    return to_working_scale(*astronaut(), ScaleSettings())


def inner(mask, reach=90):
    return mask & (np.hypot(*(np.mgrid[: mask.shape[0], : mask.shape[1]] - (mask.shape[0] - 1) / 2)) < reach)


def levels(photo, settings):
    grey = prepared(photo, settings)
    return [at_level(grey, level, settings) for level in range(settings.levels)]


def turned(angle_rad, other_rad):
    """How far two directions of lines are apart [rad]."""
    return np.abs(np.angle(np.exp(2j * (angle_rad - other_rad)))) / 2


@settings(max_examples=12, deadline=None)
@given(st.floats(0, 180), st.sampled_from([2, 3, 5]))
def test_a_line_is_drawn_at_its_centre_whatever_its_direction_and_width(angle, width):
    photo, away = line_photo(angle, width=width)
    edges = gabor_pyramid_edges(photo, FACE, SETTINGS)
    mask = inner(edges.mask)
    assert np.abs(away[skeletonize(mask)]).max() <= 3  # barbs that tracing prunes
    assert skeletonize(mask).sum() >= 180 / np.sqrt(2) - 8
    assert np.rad2deg(turned(edges.angle_rad[mask], np.deg2rad(angle))).max() <= 180 / 8 + 1


@pytest.mark.parametrize("number", range(8))
def test_each_filter_answers_most_to_its_own_direction(number):
    photo, away = line_photo(180 * number / 8)
    for seen in levels(photo, BARE):
        on_line = [np.median(one.strength[inner(np.abs(away) < 1)]) for one in seen]
        best = seen[int(np.argmax(on_line))].angle_rad
        assert turned(best, np.pi * number / 8) <= np.pi / len(seen) / 2 + 1e-6


def test_four_resolutions_the_coarsest_with_four_filters(working):
    seen = levels(working.photo, SETTINGS)
    assert [len(one) for one in seen] == [8, 8, 8, 4]
    assert [len(one) for one in levels(working.photo, SETTINGS.replace(levels=1))] == [8]
    assert [len(one) for one in levels(working.photo, SETTINGS.replace(levels=2, orientations=5))] == [5, 4]
    for one in [single for level in seen for single in level]:
        assert one.thin.shape == one.thick.shape == working.photo.rgb.shape[:2]
        assert one.thick.any()
        assert (one.thick | ~one.thin).all()
        assert one.thin.sum() < 0.7 * one.thick.sum()


def test_the_bare_sum_is_what_all_filters_drew(working):
    drawn = [one.thin for level in levels(working.photo, BARE) for one in level]
    np.testing.assert_array_equal(gabor_pyramid_edges(working.photo, FACE, BARE).mask, np.any(drawn, axis=0))


def test_a_wide_line_needs_a_coarse_resolution():
    photo, away = line_photo(30, width=16, dark=100)
    fine, all_ = (inner(gabor_pyramid_edges(photo, FACE, s).mask) for s in (SETTINGS.replace(levels=1), SETTINGS))
    assert (all_ & (np.abs(away) < 3)).sum() > 120
    assert (fine & (np.abs(away) < 3)).sum() < 60


def test_lower_thresholds_never_lose_a_line_of_the_bare_sum(working):
    loose, tight = (gabor_pyramid_edges(working.photo, FACE, BARE.replace(low=k, high=2 * k)).mask for k in (0.8, 1.2))
    assert (loose | ~tight).all()
    assert loose.sum() > tight.sum()


def test_a_mirrored_photo_gives_the_mirrored_lines(working):
    one = gabor_pyramid_edges(working.photo, FACE, SETTINGS).mask
    other = gabor_pyramid_edges(Photo(working.photo.rgb[:, ::-1]), FACE, SETTINGS).mask[:, ::-1]
    for a, b in ((one, other), (other, one)):
        near = cv2.dilate(b.astype(np.uint8), np.ones((3, 3))) > 0
        assert (a & near).sum() > 0.97 * a.sum()


@pytest.mark.parametrize("size", [(1, 1), (1, 40), (40, 1), (40, 40), (300, 300)])
@pytest.mark.parametrize("value", [0, 128, 255])
def test_blank_and_tiny_photos_have_no_line(size, value):
    edges = gabor_pyramid_edges(Photo(np.full((*size, 3), value, np.uint8)), FACE, SETTINGS)
    assert edges.mask.shape == size
    assert not edges.mask.any()


@pytest.mark.parametrize("change", [{"levels": 6, "step": 4.0}, {"orientations": 2}, {"wavelength_px": 40.0}])
def test_other_settings_work(working, change):
    gabor_pyramid_edges(working.photo, FACE, SETTINGS.replace(**change))
