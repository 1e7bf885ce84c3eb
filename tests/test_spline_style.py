"""The style `splines`: curves through the landmarks, whatever the photo shows."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

import limner
from limner import geometry
from limner.types import Photo
from limner.vision.lines import LineSettings, draw_lines
from limner.vision.regions import RegionSettings
from limner.vision.spline_style import FEATURES, SplinesSettings, spline_strokes
from portraits import MIRROR, astronaut, mirrored, mirrored_points, plain_face

BLANK = Photo(np.full((600, 560, 3), 200, np.uint8))


def strokes(face, **changes):
    return spline_strokes(BLANK, face, SplinesSettings(**changes), RegionSettings())


def test_every_landmark_is_on_a_curve():
    face = plain_face()
    lines = strokes(face, tolerance=0.0).lines_px
    for point in face.points_px:
        far = min(geometry.distance_to_segments(point[None], a, b)[0] for line in lines for a, b in pairwise(line))
        assert far < 0.01 * face.outer_eye_px


def test_eyes_and_lips_are_closed_and_everything_has_its_region():
    drawn = strokes(plain_face())
    closed = [region for region, line in zip(drawn.region, drawn.lines_px, strict=True) if geometry.is_closed(line)]
    assert sorted(closed) == ["eye", "eye", "mouth", "mouth"]
    assert sorted(drawn.region) == sorted(region for region, _ in FEATURES)
    assert (np.diff(drawn.weight) <= 0).all()


def test_the_photo_does_not_matter():
    _, face = astronaut()
    black = Photo(np.zeros((512, 512, 3), np.uint8))
    white = Photo(np.full((512, 512, 3), 255, np.uint8))
    one, other = (draw_lines(photo, face, "splines", LineSettings()) for photo in (black, white))
    assert one == other


def test_the_mirror_image_has_the_mirrored_curves():
    face = plain_face()
    there = mirrored(BLANK, face)[1]
    assert np.allclose(there.points_px, mirrored_points(face.points_px, BLANK)[MIRROR])
    one = np.concatenate([mirrored_points(line, BLANK) for line in strokes(face, tolerance=0.0).lines_px])
    other = np.concatenate(strokes(there, tolerance=0.0).lines_px)
    far = np.hypot(*(one[:, None] - other).transpose(2, 0, 1))
    assert max(far.min(axis=0).max(), far.min(axis=1).max()) < 0.02 * face.outer_eye_px


@pytest.mark.parametrize("points", [np.full((68, 2), 50.0), np.arange(136.0).reshape(68, 2)])
def test_odd_faces_give_numbers_or_one_line(points):
    face = limner.Face(points, [0, 0, 200, 200])
    try:
        lines = strokes(face).lines_px
    except limner.BadInput as error:
        lines = ()
        message = str(error)
    else:
        message = ""
    assert all(np.isfinite(line).all() for line in lines)
    assert "\n" not in message


def test_draw_makes_a_portrait_of_it():
    photo, face = astronaut()
    portrait = limner.draw(photo, face=face, style="splines")
    assert portrait.report()["style"] == "splines"
    assert 5 < portrait.report()["strokes"] <= len(FEATURES)
