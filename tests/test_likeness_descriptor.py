"""Pictures of faces that can be compared, what is described of them, and what is learnt to tell people apart."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from limner.errors import BadInput
from limner.types import Photo
from limner.vision.likeness.descriptor import LANDMARKS, describe, edges, lines
from limner.vision.likeness.discriminant import train_discriminant
from limner.vision.likeness.picture import (
    EYES_PX,
    OUTER_EYE_PX,
    PAPER,
    SIZE_PX,
    drawing_picture,
    photo_picture,
    upright_from_photo,
)
from limner.vision.refine.shape import moved
from portraits import astronaut, plain_face, resized


def cosine(a, b):
    return float(a @ b / np.linalg.norm(a) / np.linalg.norm(b))


def described(photo, face):
    upright = upright_from_photo(face.points_px)
    return describe(photo_picture(photo, upright), moved(face.points_px, upright))


def test_eyes_come_to_their_place_whatever_the_photo():
    face = plain_face(outer_eye_px=300, centre=(900, 700))
    turned = face.points_px @ np.array([[0.9, 0.3], [-0.3, 0.9]])
    for points in (face.points_px, turned):
        eyes = moved(points, upright_from_photo(points))[[36, 45]]
        assert np.allclose(eyes.mean(axis=0), EYES_PX, atol=2)
        assert np.ptp(eyes[:, 0]) == pytest.approx(OUTER_EYE_PX, rel=0.1)


@pytest.mark.parametrize("outer_eye_px", [50, 128, 410])
def test_a_line_in_the_photo_and_the_same_line_drawn_coincide(outer_eye_px):
    face = plain_face(outer_eye_px, centre=(3 * outer_eye_px, 3 * outer_eye_px))
    paper = np.full((6 * outer_eye_px, 6 * outer_eye_px, 3), 255, np.uint8)
    width = outer_eye_px // 8
    line = face.points_px[:17]
    cv2.polylines(paper, [np.rint(line * 16).astype(np.int32)], False, (0, 0, 0), width, cv2.LINE_AA, 4)
    upright = upright_from_photo(face.points_px)
    seen, drawn = photo_picture(Photo(paper), upright), drawing_picture([line], width, upright)
    centres = [np.argwhere(255 - cv2.GaussianBlur(image, (0, 0), 2) > 60).mean(axis=0) for image in (seen, drawn)]
    assert seen.shape == drawn.shape == SIZE_PX[::-1]
    assert np.allclose(*centres, atol=0.6)
    assert (PAPER - seen).sum() == pytest.approx((PAPER - drawn).sum(), rel=0.35)


def test_a_face_outside_the_photo_is_paper():
    picture = photo_picture(astronaut()[0], upright_from_photo(plain_face(centre=(9000, 9000)).points_px))
    assert (picture == PAPER).all()


def test_empty_paper_has_no_features():
    face = plain_face()
    upright = upright_from_photo(face.points_px)
    nothing = describe(drawing_picture([], 1.0, upright), moved(face.points_px, upright))
    assert np.abs(nothing).max() < 1e-4


def test_light_and_resolution_hardly_matter():
    photo, face = astronaut()
    whole = described(photo, face)
    dim = Photo((photo.rgb * 0.6 + 20).astype(np.uint8))
    assert cosine(whole, described(dim, face)) > 0.98
    larger, bigger, _ = resized(photo, face, 2.0)
    assert cosine(whole, described(larger, bigger)) > 0.95
    mirror = Photo(photo.rgb[::-1].copy())
    assert cosine(whole, described(mirror, face)) < 0.8


@pytest.mark.parametrize("degrees", [0, 30, 60, 90, 120, 150])
def test_a_dark_line_is_one_orientation(degrees):
    picture = np.full((101, 101), 255, np.float32)
    along = 60 * np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees))])
    ends = [tuple(np.rint(50 + sign * along).astype(int).tolist()) for sign in (-1, 1)]
    cv2.line(picture, *ends, 0, 2, cv2.LINE_AA)
    across = ((degrees + 90) % 180) // 30
    assert lines(picture)[50, 50].argmax() == across
    assert edges(picture)[30:70, 30:70].sum(axis=(0, 1)).argmax() == across
    assert not lines(255 - picture)[50, 50].any()


def test_only_landmarks_that_all_agree_on_are_looked_at():
    assert min(LANDMARKS) >= 17
    photo, face = astronaut()
    without_jaw = face.points_px.copy()
    without_jaw[:17] = np.nan
    upright = upright_from_photo(without_jaw)
    assert np.array_equal(described(photo, face), describe(photo_picture(photo, upright), moved(without_jaw, upright)))


def people(rng, count):
    """Two photos and a drawing of each: identity in ten of 300 numbers, louder moods in twenty, noise in the rest."""
    identity = np.zeros((count, 300), np.float32)
    identity[:, :10] = rng.normal(size=(count, 10))
    mood = np.concatenate([np.full(10, 0.1), np.full(20, 3.0), np.full(270, 0.1)])
    pictures = [identity + mood * rng.normal(size=identity.shape) for _ in range(3)]
    pictures[2] += 3.0  # a drawing is no photo
    return [rows.astype(np.float32) for rows in pictures]


def test_what_tells_people_apart_is_learnt_on_others():
    rng = np.random.default_rng(1)
    known, strangers = people(rng, 80), people(rng, 40)
    learnt = train_discriminant(known[:2], known[2:], directions=10)
    likeness = learnt.of_drawings(strangers[2]) @ learnt.of_photos(strangers[1]).T
    untrained = (strangers[2] - strangers[2].mean(0)) @ (strangers[1] - strangers[1].mean(0)).T
    right = np.arange(40)
    assert np.mean(likeness.argmax(axis=1) == right) > 0.9
    assert np.mean(untrained.argmax(axis=1) == right) < 0.5
    assert np.allclose(np.linalg.norm(learnt.of_photos(strangers[0]), axis=1), 1, atol=1e-5)


def test_too_few_people_to_learn_from():
    rows = np.zeros((2, 5), np.float32)
    with pytest.raises(BadInput, match="three or more"):
        train_discriminant([rows, rows], [])
