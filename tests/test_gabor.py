import cv2
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from limner import geometry
from limner.types import Photo
from limner.vision.edges.attention import MOST_GAIN, attention_to
from limner.vision.edges.gabor import GaborSettings, gabor_edges, gabor_lines, gabor_sight
from limner.vision.edges.iris import find_iris
from limner.vision.edges.ridges import Wave, crests, find_ridges, gabor_kernel, hysteresis, luminance
from limner.vision.scale import ScaleSettings, to_working_scale
from limner.vision.skeleton import skeletonize
from limner.vision.trace import TraceSettings, trace
from portraits import astronaut, line_photo, plain_face

SETTINGS = GaborSettings()
PLAIN = SETTINGS.replace(guided=False, irises=False, hairline=1.0)
FACE = plain_face()
WAVE = Wave(6.0, 2.0, 0.3, np.pi)


@pytest.fixture(scope="module")
def working():
    return to_working_scale(*astronaut(), ScaleSettings())


def inner_lines(edges, reach=90):
    """What is drawn away from the border of the picture, where the line bends, and how: one line, no barbs."""
    inside = np.hypot(*(np.mgrid[:240, :240] - 119.5)) < reach
    mask = edges.mask & inside
    _, labels, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=8)
    return (stats[:, cv2.CC_STAT_AREA] >= 5)[labels] & mask


@settings(max_examples=40, deadline=None)
@given(st.floats(0, 180))
def test_a_dark_line_is_one_line_at_its_centre_whatever_its_direction(angle):
    photo, away = line_photo(angle)
    edges = gabor_edges(photo, FACE, PLAIN)
    middle = inner_lines(edges)
    assert np.abs(away[middle]).max() <= 1.5
    (line,) = trace(skeletonize(middle), TraceSettings(), middle)
    turn = np.deg2rad(angle)
    assert np.abs((line - 119.5) @ [-np.sin(turn), np.cos(turn)]).max() <= 0.75
    assert geometry.length(line) == pytest.approx(180, abs=6)
    off = np.abs(np.angle(np.exp(2j * (edges.angle_rad[middle] - turn)))) / 2
    assert np.rad2deg(off).max() < 180 / 16


@pytest.mark.parametrize("angle", [0, 22.5, 30, 45, 67, 90, 111])
@pytest.mark.parametrize("width", [2, 3, 5])
def test_a_line_has_no_spurs(angle, width):
    """Eight thinned pictures added up would leave barbs along it."""
    photo, _ = line_photo(angle, width=width)
    mask = inner_lines(gabor_edges(photo, FACE, PLAIN))
    assert len(trace(skeletonize(mask), TraceSettings(spur_px=0, shortest_px=0, gap_px=0))) == 1


def test_a_light_line_is_none_for_dark_filters_but_at_its_borders():
    photo, away = line_photo(30, dark=200, light=40)
    dark, light = (inner_lines(gabor_edges(photo, FACE, PLAIN.replace(phase_deg=phase))) for phase in (180.0, 0.0))
    assert np.abs(away[light]).max() <= 1.5
    assert not (dark & (np.abs(away) < 2)).any()


@pytest.mark.parametrize("level", [1.0, 0.5, 0.25])
def test_a_darker_photo_gives_the_same_lines(level):
    """Half the light and half the contrast: dark skin draws as light skin does."""
    photo, _ = line_photo(20)
    darker = Photo(np.rint(photo.rgb * level).astype(np.uint8))
    one, other = (gabor_edges(p, FACE, PLAIN).mask for p in (photo, darker))
    near = cv2.dilate(one.astype(np.uint8), np.ones((3, 3))) > 0
    assert (other & ~near).sum() == 0
    assert other.sum() == pytest.approx(one.sum(), rel=0.1)


@pytest.mark.parametrize("normal", np.pi * np.arange(8) / 8)
def test_kernels_are_the_gabor_function_without_its_mean(normal):
    kernel = gabor_kernel(WAVE, normal).astype(float)
    assert kernel.sum() == pytest.approx(0, abs=1e-6)
    assert np.abs(kernel).sum() == pytest.approx(2, rel=1e-6)
    np.testing.assert_allclose(kernel, kernel[::-1, ::-1], atol=1e-7)  # even phase
    reach = len(kernel) // 2
    y, x = np.mgrid[-reach : reach + 1, -reach : reach + 1]
    across, along = x * np.cos(normal) + y * np.sin(normal), -x * np.sin(normal) + y * np.cos(normal)
    envelope = np.exp(-(across**2 + 0.3**2 * along**2) / (2 * 2.0**2))
    wave = envelope * np.cos(2 * np.pi * across / 6.0 + np.pi)
    left_over = np.linalg.lstsq(np.stack([wave.ravel(), envelope.ravel()], axis=1), kernel.ravel(), rcond=None)[1]
    assert left_over == pytest.approx(0, abs=1e-9)
    assert kernel[reach, reach] == kernel.min()  # a dark line has the answer above zero: dark times negative


def test_ridges_answer_in_the_unit_of_the_luminance():
    photo, away = line_photo(0, dark=0, light=255, width=2.5)
    ridges = find_ridges(luminance(photo), WAVE, 8, 0.7)
    assert 0.3 < ridges.strength[np.abs(away) < 0.6].mean() < 1
    assert ridges.strength.min() >= 0


def test_a_blob_answers_less_than_a_line():
    y, x = np.mgrid[:120, :120]
    spot = 1 - np.exp(-((x - 60) ** 2 + (y - 60) ** 2) / (2 * 1.5**2))
    line = 1 - np.exp(-((y - 60) ** 2) / (2 * 1.5**2))
    spot_answer, line_answer = (
        find_ridges(picture.astype(np.float32), WAVE, 8, 0.7).strength[60, 60] for picture in (spot, line)
    )
    assert spot_answer < line_answer / 2


def test_crests_are_thin():
    photo, _ = line_photo(37)
    ridges = find_ridges(luminance(photo), WAVE, 8, 0.7)
    thick = crests(ridges.strength, ridges.angle_rad) & (ridges.strength > 0.1)
    assert thick.sum() <= 2 * 240 / np.cos(np.deg2rad(37))


def test_hysteresis_keeps_whole_pieces_that_are_strong_somewhere():
    strength = np.zeros((9, 30), np.float32)
    strength[2, 2:20] = 1.2
    strength[2, 10] = 3
    strength[6, 2:20] = 1.2
    kept = hysteresis(strength, strength > 0, 1, 2)
    assert kept[2, 2:20].all()
    assert kept.sum() == 18


def test_lower_thresholds_never_lose_a_line(working):
    tight = gabor_edges(working.photo, working.face, PLAIN)
    loose = gabor_edges(working.photo, working.face, PLAIN.replace(low=0.6, high=1.2))
    assert (loose.mask | ~tight.mask).all()


@pytest.mark.parametrize("change", [{}, {"guided": False}, {"hairline": 1.0}, {"irises": False}])
def test_what_was_seen_gives_the_lines_at_any_threshold(working, change):
    given = SETTINGS.replace(**change)
    sight = gabor_sight(working.photo, working.face, given.seeing())
    for low, high in ((0.9, 1.8), (0.0, 0.5), (2.0, 3.0)):
        settings = given.replace(low=low, high=high)
        assert gabor_lines(sight, settings) == gabor_edges(working.photo, working.face, settings)


@pytest.mark.parametrize("order", [0.0, 0.5, 1.0])
def test_no_attention_lifts_a_line_more_than_said(order):
    """Only then may what is too weak for it be left out."""
    y, x = np.indices((573, 564))
    pixels = np.stack([y.ravel(), x.ravel()], axis=1)[::7]
    attention = attention_to(FACE, y.shape)
    for angle in np.linspace(0, np.pi, 8, endpoint=False):
        flat = np.full(len(pixels), angle, np.float32)
        assert attention.gain(pixels, flat, np.full_like(flat, order)).max() < MOST_GAIN


def test_guided_by_the_landmarks_the_features_gain_and_the_wall_loses(working):
    guided = gabor_edges(working.photo, working.face, PLAIN.replace(guided=True)).mask
    alone = gabor_edges(working.photo, working.face, PLAIN).mask
    features = np.zeros(guided.shape, np.uint8)
    for part in (slice(36, 42), slice(42, 48), slice(48, 60)):
        cv2.fillPoly(features, [np.rint(working.face.points_px[part]).astype(np.int32)], 1)
    features = cv2.dilate(features, np.ones((9, 9))) > 0
    assert guided[features].sum() / guided.sum() > 1.2 * alone[features].sum() / alone.sum()


@pytest.mark.parametrize("offset", [(0, 0), (3, -1), (-4, 2)])
@pytest.mark.parametrize("radius", [7.2, 8.5, 9.8])
def test_an_iris_is_found_where_it_was_drawn(offset, radius):
    eye = plain_face().points_px[36:42]
    centre = eye.mean(axis=0) + offset
    y, x = np.mgrid[:573, :564]
    grey = np.where(np.hypot(x - centre[0], y - centre[1]) < radius, 0.2, 0.8).astype(np.float32)
    disc = find_iris(cv2.GaussianBlur(grey, (0, 0), 1), eye, 128)
    assert np.abs(disc.centre - centre).max() <= 1.5
    assert abs(disc.radius - radius) <= 1


def test_no_iris_in_an_even_picture():
    assert find_iris(np.full((573, 564), 0.5, np.float32), plain_face().points_px[36:42], 128) is None


def test_both_eyes_of_the_astronaut_get_iris_and_pupil(working):
    with_, without = (gabor_edges(working.photo, working.face, SETTINGS.replace(irises=on)) for on in (True, False))
    y, x = np.indices(with_.mask.shape)
    changed = with_.mask != without.mask
    for eye in (slice(36, 42), slice(42, 48)):
        middle = working.face.points_px[eye].mean(axis=0)
        disc = find_iris(luminance(working.photo), working.face.points_px[eye], 128)
        assert np.abs(disc.centre - middle).max() < 8
        away = np.hypot(x - disc.centre[0], y - disc.centre[1])
        assert (with_.mask & (np.abs(away - disc.radius) < 1.5)).sum() > np.pi * disc.radius
        changed &= np.hypot(x - middle[0], y - middle[1]) > 30
    assert not changed.any()


@pytest.mark.parametrize("size", [(1, 1), (1, 40), (40, 1), (40, 40), (300, 300)])
@pytest.mark.parametrize("value", [0, 128, 255])
def test_blank_and_tiny_photos_have_no_line(size, value):
    edges = gabor_edges(Photo(np.full((*size, 3), value, np.uint8)), FACE, SETTINGS)
    assert edges.mask.shape == size
    assert not edges.mask.any()


@pytest.mark.parametrize("centre", [(-3000, 300), (300, 30000), (-1e7, 1e7)])
def test_landmarks_far_outside_of_the_photo(centre):
    photo, _ = line_photo(10)
    gabor_edges(photo, plain_face(centre=centre), SETTINGS)


def test_the_same_photo_gives_the_same_lines(working):
    one, other = (gabor_edges(working.photo, working.face, SETTINGS) for _ in range(2))
    assert one == other


@pytest.mark.parametrize("change", [{"orientations": 4}, {"orientations": 13}, {"wavelength_px": 40.0}, {"low": 5.0}])
def test_other_settings_work(working, change):
    gabor_edges(working.photo, working.face, SETTINGS.replace(**change))
