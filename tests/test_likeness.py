"""The likeness falls with what harms a drawing, is nothing for nobody, and survives saving."""

from __future__ import annotations

from itertools import pairwise

import cv2
import numpy as np
import pytest

import limner
from limner import geometry
from limner.errors import BadInput
from limner.types import Photo
from limner.vision.likeness.model import load_likeness, save_likeness, shipped_likeness
from limner.vision.refine.shape import moved, shipped_shape, similarity
from portraits import astronaut, face_of, london, resized

MM = 1 / 80
"""A millimetre on a face drawn 200 mm high, in outer-eye distances."""

PEOPLE = ("001_03.jpg", "010_03.jpg", "031_03.jpg", "064_03.jpg")


def drawn(photo, face, style="gabor", points=600):
    portrait = limner.draw(photo, face=face, style=style, points=points, order__by="given")
    return portrait.ink_px(), portrait.pen_px


def score(photo, face, lines, pen_px):
    return shipped_likeness().likeness(photo, face, lines, pen_px)


@pytest.fixture(scope="module")
def drawings(shared):
    """Some people of London: photo, face, lines and pen."""
    pictures = [london(shared, name) for name in PEOPLE]
    return [(photo, face, *drawn(photo, face)) for photo, face in pictures]


def mean_score(drawings, harm):
    """The mean likeness of the drawings, after something was done to their lines."""
    rng = np.random.default_rng(5)
    scores = [score(photo, face, harm(lines, face, rng), pen) for photo, face, lines, pen in drawings]
    return float(np.mean(scores))


def fewer(share):
    return lambda lines, face, rng: [lines[i] for i in rng.permutation(len(lines))[: round(len(lines) * (1 - share))]]


def displaced(mm):
    def harm(lines, face, rng):
        turns = rng.uniform(0, 2 * np.pi, len(lines))
        steps = mm * MM * face.outer_eye_px * np.stack([np.cos(turns), np.sin(turns)], axis=1)
        return [line + step for line, step in zip(lines, steps, strict=True)]

    return harm


def cluttered(share):
    """Lines of the drawing itself, thrown over the face at random."""

    def harm(lines, face, rng):
        low, high = face.points_px.min(axis=0), face.points_px.max(axis=0)
        wanted, extra = share * geometry.total_length(lines), []
        while geometry.total_length(extra) < wanted:
            line = lines[rng.integers(len(lines))]
            extra.append(line - line.mean(axis=0) + rng.uniform(low, high))
        return [*lines, *extra]

    return harm


def averaged(lines, face, rng):
    """Lines moved with the landmarks nearest to them to those of the mean face."""
    mean = shipped_shape().mean
    target = moved(mean, similarity(mean, face.points_px))
    shift, unit = target - face.points_px, face.outer_eye_px

    def warp(line):
        near = np.exp(-(((line[:, None] - face.points_px) / (0.15 * unit)) ** 2).sum(axis=2)) + 1e-9
        return line + near @ shift / near.sum(axis=1, keepdims=True)

    return [warp(line) for line in lines]


def unharmed(lines, face, rng):
    return lines


@pytest.mark.parametrize(
    "steps",
    [
        [unharmed, fewer(0.25), fewer(0.5), fewer(0.75)],
        [unharmed, displaced(1), displaced(2), displaced(4)],
        [unharmed, cluttered(0.5), cluttered(1.0)],
        [unharmed, averaged],
    ],
    ids=["strokes lost", "strokes displaced", "foreign strokes", "mean face"],
)
def test_more_harm_less_likeness(drawings, steps):
    scores = [mean_score(drawings, harm) for harm in steps]
    assert scores[0] > 0.8
    assert all(before > after + 0.005 for before, after in pairwise(scores)), scores


def test_a_millimetre_hardly_harms_and_half_of_the_strokes_much(drawings):
    whole = mean_score(drawings, unharmed)
    assert mean_score(drawings, displaced(1)) > 0.9 * whole
    assert mean_score(drawings, fewer(0.5)) < 0.85 * whole


def test_every_person_is_in_their_own_drawing_and_in_no_other(drawings):
    strangers = []
    for i, (photo, face, lines, pen) in enumerate(drawings):
        other, there, *_ = drawings[i - 1]
        over = similarity(face.points_px[27:48], there.points_px[27:48])
        strangers.append(score(other, there, [moved(line, over) for line in lines], pen))
        assert score(photo, face, lines, pen) > strangers[-1] + 0.3
    assert np.mean(strangers) < 0.25


def test_edges_and_dark_lines_score_high_and_splines_low(drawings):
    def mean_of(style):
        return np.mean([score(photo, face, *drawn(photo, face, style)) for photo, face, *_ in drawings])

    assert min(mean_of("gabor"), mean_of("canny")) > 0.8
    assert mean_of("splines") < 0.75


def test_nothing_and_scribbles_are_nobody():
    photo, face = astronaut()
    assert score(photo, face, [], 1.0) == 0
    low, high = face.points_px.min(axis=0), face.points_px.max(axis=0)
    scribbles = list(np.random.default_rng(2).uniform(low, high, (40, 2, 2)))
    assert score(photo, face, scribbles, 1.0) < 0.25
    assert score(Photo(np.full((512, 512, 3), 128, np.uint8)), face, drawn(photo, face)[0], 1.0) == 0


def test_a_stranger_to_the_model_is_recognised_at_any_size():
    photo, face = astronaut()
    lines, pen = drawn(photo, face)
    own = score(photo, face, lines, pen)
    assert own > 0.6
    larger, bigger, factors = resized(photo, face, 2.5)
    there = [(line + 0.5) * factors - 0.5 for line in lines]
    assert score(larger, bigger, there, pen * 2.5) == pytest.approx(own, abs=0.06)
    quarter = np.array([[0.0, -1.0, 511.0], [1.0, 0.0, 0.0]])  # a quarter turn clockwise
    lying = Photo(cv2.rotate(photo.rgb, cv2.ROTATE_90_CLOCKWISE))
    turned = [moved(line, quarter) for line in lines]
    assert score(lying, face_of(moved(face.points_px, quarter)), turned, pen) == pytest.approx(own, abs=0.03)


def test_the_report_tells_the_likeness_of_what_is_drawn():
    photo, face = astronaut()
    portrait = limner.draw(photo, face=face, points=200)
    assert portrait.report()["likeness"] == portrait.likeness == score(photo, face, portrait.ink_px(), portrait.pen_px)
    assert portrait.pen_px == pytest.approx(portrait.settings.page.pen_mm / portrait.page_from_photo[0, 0])


def test_the_lines_of_the_drawing_come_back_to_the_photo():
    photo, face = astronaut()
    portrait = limner.draw(photo, face=face, style="splines", order__by="given")
    back, seen = portrait.ink_px(), portrait.strokes.lines_px
    apart = [np.hypot(*(point - np.concatenate(seen)).T).min() for line in back for point in line]
    assert max(apart) < 0.05 * face.outer_eye_px


def test_a_saved_model_is_the_same(tmp_path):
    model = shipped_likeness()
    for name in ("a.npz", "b.npz"):
        save_likeness(model, tmp_path / name)
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()
    again = load_likeness(tmp_path / "a.npz")
    assert np.allclose(again.discriminant.directions, model.discriminant.directions, atol=1e-6)
    assert np.array_equal(again.gallery, model.gallery)
    assert (tmp_path / "a.npz").stat().st_size < 500_000


def test_other_files_are_no_model(tmp_path):
    np.savez(tmp_path / "x.npz", mean=np.zeros(3))
    with pytest.raises(BadInput, match="no likeness model"):
        load_likeness(tmp_path / "x.npz")
