import cv2
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from limner.errors import BadInput
from limner.types import Photo
from limner.vision.scale import ScaleSettings, apply, to_working_scale
from portraits import astronaut, face_of, plain_face

SETTINGS = ScaleSettings()


def grey(width, height):
    return Photo(np.full((height, width, 3), 128, np.uint8))


@settings(max_examples=40, deadline=None)
@given(st.floats(9, 700), st.floats(-100, 1100), st.floats(-100, 900))
def test_the_outer_eye_distance_is_the_asked_one_and_the_way_back_is_exact(unit, x, y):
    face = plain_face(unit, (x, y))
    try:
        working = to_working_scale(grey(1000, 800), face, SETTINGS)
    except BadInput:
        assert x < 0 or y < 0 or x > 1000 or y > 800
        return
    shape = working.photo.size_px
    assert working.face.outer_eye_px == pytest.approx(128, rel=0.5 / min(shape) + 1e-9)
    back = apply(working.photo_from_working, working.face.points_px)
    np.testing.assert_allclose(back, face.points_px, atol=1e-6)


@pytest.mark.parametrize("unit", [30, 64, 127, 128, 129, 256, 512.5])
def test_the_crop_and_its_pixels_end_on_the_same_edges(unit):
    face = plain_face(unit, (900, 700))
    working = to_working_scale(grey(2000, 1500), face, SETTINGS)
    width, height = working.photo.size_px
    corners = apply(working.photo_from_working, np.array([[-0.5, -0.5], [width - 0.5, height - 0.5]]))
    np.testing.assert_allclose(corners + 0.5, np.rint(corners + 0.5), atol=1e-9)  # edges of whole pixels of the photo


@pytest.mark.parametrize("unit", [40, 90, 128, 200, 333])
def test_a_spot_is_found_where_the_map_says(unit):
    """The map is checked against the picture itself: the middle of a blurred spot, before and after."""
    face, (height, width) = plain_face(unit, (800, 800)), (1600, 1600)
    y, x = np.mgrid[:height, :width]
    spot = np.array([800 + 0.31 * unit, 800 - 0.17 * unit])
    picture = 255 * np.exp(-((x - spot[0]) ** 2 + (y - spot[1]) ** 2) / (2 * (0.1 * unit) ** 2))
    photo = Photo(np.repeat(picture.astype(np.uint8)[..., None], 3, axis=2))
    working = to_working_scale(photo, face, SETTINGS)
    weights = working.photo.rgb[..., 0].astype(float)
    rows, columns = np.indices(weights.shape)
    middle = np.array([(columns * weights).sum(), (rows * weights).sum()]) / weights.sum()
    assert np.abs(apply(working.photo_from_working, middle[None])[0] - spot).max() < 0.02 * max(1, unit / 128)


def test_at_the_working_scale_nothing_is_resampled():
    rgb = np.random.default_rng(0).integers(0, 256, (700, 700, 3), dtype=np.uint8)
    working = to_working_scale(Photo(rgb), plain_face(128, (350, 350)), SETTINGS)
    x, y = (working.photo_from_working[:, 2]).astype(int)
    width, height = working.photo.size_px
    np.testing.assert_array_equal(working.photo.rgb, rgb[y : y + height, x : x + width])


@pytest.mark.parametrize("unit", [128 / 1.7, 310])
def test_a_mirrored_photo_gives_the_mirrored_crop(unit):
    rng = np.random.default_rng(1)
    photo = Photo(cv2.GaussianBlur(rng.integers(0, 256, (1400, 1501, 3), dtype=np.uint8), (0, 0), 3))
    face = plain_face(unit, (703.3, 640.2))
    points = face.points_px.copy()
    points[:, 0] = 1500 - points[:, 0]
    mirrored_face = face_of(points)
    assert mirrored_face.points_px[36, 0] > mirrored_face.points_px[45, 0]
    one = to_working_scale(photo, face, SETTINGS).photo.rgb
    other = to_working_scale(Photo(photo.rgb[:, ::-1]), mirrored_face, SETTINGS).photo.rgb
    assert one.shape == other.shape
    assert np.abs(one.astype(int) - other[:, ::-1]).max() <= 1


def test_the_cost_does_not_depend_on_the_size_of_the_photo():
    photo, face = astronaut()
    small = to_working_scale(photo, face, SETTINGS).photo.size_px
    big_rgb = cv2.resize(photo.rgb, None, fx=6, fy=6)
    big = to_working_scale(Photo(big_rgb), face_of((face.points_px + 0.5) * 6 - 0.5), SETTINGS).photo.size_px
    assert np.abs(np.subtract(small, big)).max() <= 3


@pytest.mark.parametrize("size", [(1, 1), (40, 40), (3, 900)])
def test_tiny_photos(size):
    working = to_working_scale(grey(*size), plain_face(100, (0.5, 0.5)), SETTINGS)
    assert min(working.photo.size_px) >= 1
    assert max(working.photo.size_px) < 1000


@pytest.mark.parametrize(
    ("unit", "centre"), [(100, (5000, 300)), (100, (300, -900)), (7.9, (300, 300)), (0.01, (9, 9))]
)
def test_faces_outside_or_of_a_few_pixels_are_refused(unit, centre):
    with pytest.raises(BadInput, match="face: "):
        to_working_scale(grey(600, 600), plain_face(unit, centre), SETTINGS)
