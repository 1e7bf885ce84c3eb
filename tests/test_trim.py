import cv2
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy import ndimage

from limner.errors import BadInput
from limner.types import EdgeMap
from limner.vision.head import face_frame, head_ellipse
from limner.vision.trim import TrimSettings, head_points, in_boxes, trim
from portraits import plain_face

FACE = plain_face()
OFF = TrimSettings(by="none")
RULES_BY_NAME = ("rectangle", "distance", "boxes", "length")
SHAPE = (600, 560)


def edge_map(mask):
    return EdgeMap(mask, mask.astype(float), np.zeros(mask.shape))


def line(start, end):
    picture = np.zeros(SHAPE, np.uint8)
    cv2.line(picture, start, end, 1)
    return picture > 0


def random_edges(seed, shape=SHAPE):
    noise = ndimage.gaussian_filter(np.random.default_rng(seed).normal(size=shape), 4)
    return edge_map(np.abs(noise) < 0.1 * noise.std())


def place(x, y):
    """Whole pixels of a place given in the frame of the face."""
    return tuple(np.rint(face_frame(FACE).to_photo(np.array([x, y]))).astype(int).tolist())


@settings(max_examples=20, deadline=None)
@given(
    st.integers(0, 10),
    st.lists(st.sampled_from(RULES_BY_NAME)),
    st.floats(0, 100),
    st.floats(0, 100),
    st.floats(1, 60),
    st.booleans(),
    st.integers(0, 60),
)
def test_trimming_only_takes_away(seed, by, beside, near, box, cut, fewest):
    edges = random_edges(seed)
    trimmed = trim(edges, FACE, TrimSettings(",".join(by), beside, 24.0, near, box, cut, fewest))
    assert not (trimmed.mask & ~edges.mask).any()
    np.testing.assert_array_equal(trimmed.strength, edges.strength)


def test_with_every_rule_off_nothing_changes():
    edges = random_edges(1)
    assert trim(edges, FACE, OFF) == edges


@pytest.mark.parametrize(
    ("rule", "strict"), [("fewest_px", 40), ("near_px", 10.0), ("beside_px", 0.0), ("below_px", 0.0)]
)
def test_a_stricter_rule_keeps_a_part(rule, strict):
    edges = random_edges(2)
    loose, tight = (trim(edges, FACE, s).mask for s in (TrimSettings(), TrimSettings().replace(**{rule: strict})))
    assert (loose | ~tight).all()
    assert tight.sum() < loose.sum()


def test_pieces_of_fewer_pixels_go_diagonals_count_as_connected():
    mask = np.zeros(SHAPE, bool)
    mask[np.arange(20), np.arange(20)] = True
    mask[100, 100:119] = True
    np.testing.assert_array_equal(
        trim(edge_map(mask), FACE, TrimSettings("length", fewest_px=20)).mask,
        mask & (np.arange(SHAPE[0]) < 50)[:, None],
    )


def test_at_the_eyes_half_as_many_pixels_are_enough():
    x, y = place(-0.37, 0)
    at_eye = line((x - 6, y), (x + 6, y))
    elsewhere = line((x - 6, y + 60), (x + 6, y + 60))
    np.testing.assert_array_equal(
        trim(edge_map(at_eye | elsewhere), FACE, TrimSettings("length", fewest_px=20)).mask, at_eye
    )


def test_far_pieces_go_and_near_ones_stay_whole():
    chin, far = place(0, 1.0), place(2.0, 0.5)
    reaching = line(chin, (chin[0], SHAPE[0] - 1))
    alone = line(far, (far[0], far[1] + 40))
    np.testing.assert_array_equal(
        trim(edge_map(reaching | alone), FACE, TrimSettings("distance", near_px=40.0)).mask, reaching
    )


def test_the_top_of_the_head_is_near_thanks_to_the_ellipse():
    top = head_ellipse(FACE).centre - [0, head_ellipse(FACE).radii[1]]
    x, y = place(*top)
    crown = line((x - 20, y), (x + 20, y))
    assert trim(edge_map(crown), FACE, TrimSettings("distance", near_px=40.0)).mask.all() == crown.all()
    assert trim(edge_map(crown), FACE, TrimSettings("distance", near_px=40.0)).mask.sum() == crown.sum()
    assert np.hypot(*(FACE.points_px - [x, y]).T).min() > 80  # no landmark is anywhere near


def test_limits_follow_a_tilted_head():
    turn = np.deg2rad(25)
    points = (FACE.points_px - [280, 290]) @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    tilted = type(FACE)(np.add(points, [280, 290]), FACE.box_px)
    everywhere = edge_map(np.ones(SHAPE, bool))
    rule = TrimSettings("rectangle", beside_px=10.0, below_px=10.0)
    mask = trim(everywhere, tilted, rule).mask
    y, x = np.nonzero(mask)
    inside = face_frame(tilted).from_photo(np.stack([x, y], axis=1).astype(float))
    jaw = face_frame(tilted).from_photo(tilted.points_px[:17])
    allowance = 10 / 128
    assert inside[:, 0].min() >= jaw[:, 0].min() - allowance
    assert inside[:, 0].max() <= jaw[:, 0].max() + allowance
    assert inside[:, 1].max() <= jaw[:, 1].max() + allowance
    assert inside[:, 1].max() > jaw[:, 1].max() + allowance - 0.02


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10), st.lists(st.sampled_from(RULES_BY_NAME), min_size=1, max_size=4, unique=True))
def test_rules_combined_keep_no_more_than_each_alone(seed, by):
    edges = random_edges(seed)
    alone = [trim(edges, FACE, TrimSettings(name, box_px=30.0)).mask for name in by]
    together = trim(edges, FACE, TrimSettings(",".join(by), box_px=30.0)).mask
    assert not (together & ~np.all(alone, axis=0)).any()


@pytest.mark.parametrize("by", ["rectangle,boxes", "boxes,rectangle"])
def test_rules_about_single_pixels_combine_to_what_both_keep(by):
    edges = random_edges(3)
    cut = TrimSettings(by, beside_px=0.0, below_px=0.0, box_px=40.0, box_cut=True)
    one, other = (trim(edges, FACE, cut.replace(by=name)).mask for name in by.split(","))
    np.testing.assert_array_equal(trim(edges, FACE, cut).mask, one & other)
    assert 0 < (one & other).sum() < min(one.sum(), other.sum())


def test_boxes_lie_on_landmarks_and_ellipse():
    """Against the distance that a box is about: its side is twice the largest of the two offsets."""
    points = np.concatenate([FACE.points_px, face_frame(FACE).to_photo(head_ellipse(FACE).points(40))])
    np.testing.assert_allclose(head_points(FACE), points)
    y, x = np.indices(SHAPE)
    offsets = np.min([np.maximum(np.abs(x - px), np.abs(y - py)) for px, py in points], axis=0)
    np.testing.assert_array_equal(in_boxes(FACE, SHAPE, TrimSettings(box_px=14.0)), offsets <= 7)


def test_a_piece_that_touches_a_box_stays_whole_or_is_cut():
    chin, far = place(0, 1.0), place(2.0, 0.5)
    edges = edge_map(line(chin, (chin[0], SHAPE[0] - 1)) | line(far, (far[0], far[1] + 40)))
    touched = trim(edges, FACE, TrimSettings("boxes")).mask
    np.testing.assert_array_equal(touched, line(chin, (chin[0], SHAPE[0] - 1)))
    cut = trim(edges, FACE, TrimSettings("boxes", box_cut=True)).mask
    assert 3 <= cut.sum() <= 11


def test_the_order_of_the_rules_matters_where_pieces_are_cut():
    """A line that leaves the face is cut first and its rest is too short, or is long enough before it is cut."""
    jaw = FACE.points_px[:17]
    bottom = int(jaw[:, 1].max())
    edges = edge_map(line((280, bottom - 10), (280, bottom + 60)))
    rule = TrimSettings("rectangle,length", below_px=0.0)
    assert not trim(edges, FACE, rule).mask.any()
    assert trim(edges, FACE, rule.replace(by="length,rectangle")).mask.any()


@pytest.mark.parametrize("by", ["", "none", " none , "])
def test_no_rule_at_all(by):
    edges = random_edges(4)
    assert trim(edges, FACE, TrimSettings(by)) == edges


def test_an_unknown_rule_is_named():
    with pytest.raises(
        BadInput, match="'circle' does not exist; choose from rectangle, distance, boxes, length, or none"
    ):
        TrimSettings("distance,circle")


def test_the_ellipse_surrounds_the_head():
    ellipse, frame = head_ellipse(FACE), face_frame(FACE)
    marks = frame.from_photo(FACE.points_px)
    assert ellipse.level(marks).max() < 1.1
    np.testing.assert_allclose(ellipse.level(ellipse.points(40)), 1)
    points = ellipse.points(40)
    assert points[:, 1].max() == pytest.approx(marks[8, 1], abs=0.02)
    assert -1.6 < points[:, 1].min() < -1.0
    np.testing.assert_allclose(frame.to_photo(marks), FACE.points_px, atol=1e-9)


@pytest.mark.parametrize("shape", [(1, 1), (1, 40), (40, 40)])
@pytest.mark.parametrize("centre", [(20, 20), (-5000, 900), (1e6, -1e6)])
def test_tiny_pictures_and_landmarks_outside(shape, centre):
    for mask in (np.zeros(shape, bool), np.ones(shape, bool)):
        everything = TrimSettings("rectangle,distance,boxes,length")
        assert trim(edge_map(mask), plain_face(centre=centre), everything).mask.shape == shape
