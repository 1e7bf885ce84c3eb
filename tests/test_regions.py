import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from limner.types import REGIONS, EdgeMap, Photo
from limner.vision.head import face_frame, inside
from limner.vision.regions import RegionSettings, regions_and_weights, regions_at
from portraits import mirrored, plain_face

FACE = plain_face()
SHAPE = (600, 560)
ALL = EdgeMap(np.ones(SHAPE, bool), np.ones(SHAPE), np.zeros(SHAPE))


def name_at(x, y, face=FACE):
    """The region of a place in the frame of the face."""
    return REGIONS[int(regions_at(face_frame(face).to_photo(np.array([[x, y]])), face)[0])]


@pytest.mark.parametrize(
    ("x", "y", "region"),
    [
        (-0.37, 0.0, "eye"),
        (0.37, -0.03, "eye"),
        (-0.4, -0.2, "brow"),
        (0.0, 0.3, "nose"),
        (0.0, 0.55, "mouth"),
        (0.0, 1.2, "jaw"),
        (0.4, 0.45, "face"),
        (0.0, -0.4, "face"),
        (0.85, 0.1, "ear"),
        (0.0, -1.1, "hair"),
        (-0.8, -0.7, "hair"),
        (0.0, 1.6, "body"),
        (2.0, -0.5, "background"),
        (0.0, -2.2, "background"),
    ],
)
def test_places_of_a_face(x, y, region):
    assert name_at(x, y) == region


@pytest.mark.parametrize(
    ("part", "region"),
    [
        (slice(36, 48), "eye"),
        (slice(17, 27), "brow"),
        (slice(31, 36), "nose"),
        (slice(48, 60), "mouth"),
        (slice(2, 15), "jaw"),
    ],
)
def test_every_landmark_lies_in_its_own_region(part, region):
    labels = regions_at(FACE.points_px[part], FACE)
    assert {REGIONS[label] for label in labels} == {region}


def test_regions_do_not_depend_on_size_place_or_tilt():
    rng = np.random.default_rng(0)
    points = rng.uniform(-2, 2, (500, 2))
    labels = regions_at(face_frame(FACE).to_photo(points), FACE)
    turn = np.deg2rad(-20)
    turned = 3.1 * FACE.points_px @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]]) + [900, -40]
    other = type(FACE)(turned, [0, 0, 1, 1])
    np.testing.assert_array_equal(regions_at(face_frame(other).to_photo(points), other), labels)


def test_a_mirrored_face_has_mirrored_regions():
    photo = Photo(np.zeros((*SHAPE, 3), np.uint8))
    _, other = mirrored(photo, FACE)
    points = np.random.default_rng(1).uniform(0, 560, (500, 2))
    across = points * [-1, 1] + [SHAPE[1] - 1, 0]
    np.testing.assert_array_equal(regions_at(points, FACE), regions_at(across, other))


def segment(x, y, length):
    start = face_frame(FACE).to_photo(np.array([x - length / 2, y]))
    return np.array([start, np.add(start, [128 * length, 0])])


def test_weight_is_length_times_importance_times_strength():
    lines = [segment(0.4, 0.45, 0.2), segment(0.4, 0.45, 0.1)]
    names, weights = regions_and_weights(lines, ALL, FACE, RegionSettings(face=1.5))
    assert names == ("face", "face")
    assert weights == pytest.approx([0.3, 0.15])
    half = EdgeMap(ALL.mask, ALL.strength / 2, ALL.angle_rad)
    assert regions_and_weights(lines, half, FACE, RegionSettings(face=1.5))[1] == pytest.approx([0.15, 0.075])


def test_an_eye_outweighs_hair_of_several_times_its_length():
    eye, hair = segment(-0.37, 0, 0.25), segment(0, -1.1, 1.0)
    names, weights = regions_and_weights([eye, hair], ALL, FACE, RegionSettings())
    assert names == ("eye", "hair")
    assert weights[0] > weights[1]


@settings(max_examples=50, deadline=None)
@given(st.lists(st.tuples(st.floats(-100, 700), st.floats(-100, 700)), min_size=1, max_size=6))
def test_any_line_gets_a_region_and_a_finite_weight(points):
    names, weights = regions_and_weights([np.array(points)], ALL, FACE, RegionSettings())
    assert names[0] in REGIONS
    assert weights[0] >= 0
    assert np.isfinite(weights).all()


def test_no_lines():
    assert regions_and_weights([], ALL, FACE, RegionSettings())[0] == ()


def test_inside_a_polygon_as_by_matplotlib_or_hand():
    square = np.array([[0.0, 0], [2, 0], [2, 2], [0, 2]])
    points = np.array([[1.0, 1], [3, 1], [-1, 1], [1, 3], [1, -1], [1.9, 0.1]])
    assert inside(points, square).tolist() == [True, False, False, False, False, True]
    assert inside(points, square[::-1]).tolist() == [True, False, False, False, False, True]


def test_a_setting_for_every_region():
    assert {path for path, _, _ in RegionSettings.walk()} == set(REGIONS)
