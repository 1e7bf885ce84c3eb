import numpy as np
import pytest

import limner
from limner.errors import BadInput
from limner.types import EdgeMap, Face, Photo
from limner.vision.edges import EXTRACTORS
from limner.vision.lines import LineSettings, draw_lines, edges_to_strokes
from portraits import agreement, astronaut, ink, london, mirrored, mirrored_points, plain_face, resized

SETTINGS = LineSettings()
STYLES = tuple(EXTRACTORS)


def within(face):
    return 0.015 * face.outer_eye_px


@pytest.fixture(scope="module")
def drawings():
    photo, face = astronaut()
    return {style: draw_lines(photo, face, style, SETTINGS) for style in STYLES}


@pytest.mark.parametrize("style", STYLES)
def test_a_photo_at_double_size_gives_nearly_the_same_drawing(drawings, style):
    photo, face = astronaut()
    large, large_face, factors = resized(photo, face, 2)
    lines = draw_lines(large, large_face, style, SETTINGS).lines_px
    back = (ink(lines) + 0.5) / factors - 0.5
    assert agreement(ink(drawings[style].lines_px), back, within(face)) >= 0.9


@pytest.mark.parametrize("style", STYLES)
@pytest.mark.parametrize("name", ["062_03.jpg", "017_03.jpg"])
def test_a_photo_at_half_size_gives_nearly_the_same_drawing(shared, style, name):
    photo, face = london(shared, name)
    small, small_face, factors = resized(photo, face, 0.5)
    lines = draw_lines(small, small_face, style, SETTINGS).lines_px
    back = (ink(lines) + 0.5) / factors - 0.5
    assert agreement(ink(draw_lines(photo, face, style, SETTINGS).lines_px), back, within(face)) >= 0.9


def test_agreement_can_be_low(drawings):
    """Another style of the same photo is no match, so the tests above can fail."""
    _, face = astronaut()
    assert agreement(*(ink(drawings[style].lines_px) for style in ("gabor", "canny")), within(face)) < 0.7


@pytest.mark.parametrize("style", STYLES)
def test_a_mirrored_photo_gives_the_mirrored_drawing(drawings, style):
    photo, face = astronaut()
    lines = draw_lines(*mirrored(photo, face), style, SETTINGS).lines_px
    assert agreement(ink(drawings[style].lines_px), mirrored_points(ink(lines), photo), within(face)) >= 0.97


@pytest.mark.parametrize("style", STYLES)
def test_the_face_is_there_and_comes_first(drawings, style):
    strokes = drawings[style]
    assert {"eye", "nose", "mouth", "jaw", "hair"} <= set(strokes.region)
    assert (np.diff(strokes.weight) <= 0).all()
    assert strokes.size_px == (512, 512)
    points = np.concatenate(strokes.lines_px)
    assert points.min() >= -0.5
    assert points.max() <= 511.5


def test_the_features_of_the_astronaut_are_drawn_within_a_few_points(drawings):
    """Lids, brows, lips and jaw lie near the ink of the 600 most important points."""
    _, face = astronaut()
    strokes = drawings["gabor"]
    used = np.cumsum([len(line) for line in strokes.lines_px])
    drawn = ink([line for line, n in zip(strokes.lines_px, used, strict=True) if n <= 600])
    for part in (slice(36, 48), slice(17, 27), slice(48, 60), slice(3, 14)):
        away = [np.hypot(*(drawn - mark).T).min() for mark in face.points_px[part]]
        assert np.mean(np.array(away) < 0.07 * face.outer_eye_px) > 0.75


@pytest.mark.parametrize("style", STYLES)
def test_the_same_photo_gives_the_same_strokes(drawings, style):
    assert draw_lines(*astronaut(), style, SETTINGS) == drawings[style]


@pytest.mark.parametrize("style", STYLES)
@pytest.mark.parametrize("size", [(1, 1), (40, 40), (300, 7), (400, 400)])
@pytest.mark.parametrize("value", [0, 255])
def test_blank_photos_give_no_strokes(style, size, value):
    photo = Photo(np.full((*size, 3), value, np.uint8))
    face = plain_face(60, (size[1] / 2, size[0] / 2))
    assert draw_lines(photo, face, style, SETTINGS).lines_px == ()


@pytest.mark.parametrize("style", STYLES)
def test_a_face_at_the_border_of_the_photo(style):
    photo, face = astronaut()
    cut = Photo(photo.rgb[110:, 215:])
    moved = Face(face.points_px - [215, 110], face.box_px)
    points = np.concatenate(draw_lines(cut, moved, style, SETTINGS).lines_px)
    assert points.min() >= -0.5


@pytest.mark.parametrize("style", STYLES)
def test_noise_is_drawn_without_a_crash(style):
    rng = np.random.default_rng(0)
    photo = Photo(rng.integers(0, 256, (500, 500, 3), dtype=np.uint8))
    draw_lines(photo, plain_face(110, (250, 250)), style, SETTINGS)


def test_edges_alone_become_strokes():
    mask = np.zeros((600, 560), bool)
    mask[300, 200:360] = True
    strokes = edges_to_strokes(EdgeMap(mask, mask.astype(float), np.zeros(mask.shape)), plain_face(), SETTINGS)
    np.testing.assert_allclose(strokes.lines_px[0], [[200, 300], [359, 300]], atol=0.5)
    empty = EdgeMap(mask & False, mask * 0.0, np.zeros(mask.shape))
    assert edges_to_strokes(empty, plain_face(), SETTINGS).lines_px == ()


def test_a_full_mask_and_a_single_pixel():
    full = np.ones((200, 220), bool)
    face = plain_face(64, (110, 90))
    for mask in (full, np.pad([[True]], 50)):
        edges_to_strokes(EdgeMap(mask, mask.astype(float), np.zeros(mask.shape)), face, SETTINGS)


def test_an_unknown_style_and_a_profile_are_refused():
    photo, face = astronaut()
    with pytest.raises(BadInput, match="style: 'oil' does not exist; choose from gabor, canny"):
        draw_lines(photo, face, "oil", SETTINGS)
    with pytest.raises(BadInput, match="profile"):
        draw_lines(photo, Face(face.points_px[:39], face.box_px), "gabor", SETTINGS)


def test_every_style_has_its_group_of_settings():
    assert all(SETTINGS.of_style(style) for style in limner.STYLES)
