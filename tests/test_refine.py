"""Corrections on pictures whose truth is drawn, and over degenerate faces and photos."""

from __future__ import annotations

import dataclasses

import cv2
import numpy as np
import pytest

from limner.errors import BadInput
from limner.types import Face, Photo
from limner.vision.refine import REFINEMENTS, RefineSettings, names_of, refine
from limner.vision.refine.brows import BrowsSettings, brows
from limner.vision.refine.eye_corners import EyeCornersSettings, eye_corners
from limner.vision.refine.jaw_gradient import JawGradientSettings, jaw_gradient
from limner.vision.refine.jaw_outliers import JawOutliersSettings, jaw_outliers
from limner.vision.refine.jaw_spline import JawSplineSettings, jaw_spline
from limner.vision.refine.shape import (
    ShapeSettings,
    load_shape,
    save_shape,
    shape,
    shipped_shape,
    similarity,
    train_shape,
)
from limner.vision.splines import smoothing_spline
from portraits import MIRROR, face_of, mirrored, plain_face

SIZE = (600, 560)
EYE = 128.0
CENTRE = np.array([280.0, 290.0])
BROW = np.arange(17, 27)


def blank(level=200):
    return np.full((*SIZE, 3), level, np.uint8)


def moved(face, which, by):
    points = face.points_px.copy()
    points[which] += by
    return dataclasses.replace(face, points_px=points)


def disc(radius=150.0, inside=210, outside=60):
    """A bright disc on dark: a step edge at a known distance from its centre."""
    y, x = np.mgrid[: SIZE[0], : SIZE[1]]
    share = np.clip(radius - np.hypot(x - CENTRE[0], y - CENTRE[1]) + 0.5, 0, 1)
    grey = outside + (inside - outside) * share
    return Photo(np.repeat(grey[..., None], 3, axis=2).round().astype(np.uint8))


def jaw_on_circle(radius):
    angle = np.linspace(np.pi, 0, 17)
    face = plain_face(EYE, CENTRE)
    points = face.points_px.copy()
    points[:17] = CENTRE + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return face_of(points)


@pytest.mark.parametrize("off", [-12.0, -6.0, 7.0, 13.0])
def test_the_jaw_goes_to_the_edge_and_the_ears_stay(off):
    face = jaw_on_circle(150 + off)
    after = jaw_gradient(disc(), face, JawGradientSettings()).points_px
    assert np.allclose(np.hypot(*(after[3:14] - CENTRE).T), 150, atol=1.5)
    rest = np.r_[0:3, 14:68]
    assert np.array_equal(after[rest], face.points_px[rest])


def test_the_jaw_does_not_jump_beyond_its_reach():
    face = jaw_on_circle(110)
    after = jaw_gradient(disc(), face, JawGradientSettings(reach=0.1)).points_px
    assert np.hypot(*(after - face.points_px).T).max() <= 0.1 * EYE * np.sqrt(2)


def test_brows_go_down_to_the_dark_arc():
    face = plain_face(EYE, CENTRE)
    rgb = blank()
    for brow in (slice(17, 22), slice(22, 27)):
        cv2.polylines(rgb, [np.rint(face.points_px[brow] * 16).astype(np.int32)], False, (40,) * 3, 5, cv2.LINE_AA, 4)
    after = brows(Photo(rgb), moved(face, slice(17, 27), [0, -8]), BrowsSettings()).points_px
    assert np.abs(after[17:27, 1] - face.points_px[17:27, 1]).max() < 2
    # The face's own down is a little aslant of the picture's.
    assert np.abs(after[17:27, 0] - face.points_px[17:27, 0]).max() < 0.5


@pytest.mark.parametrize("off", [-8, -3])
def test_brows_go_to_the_upper_edge_where_asked(off):
    face, thick = plain_face(EYE, CENTRE), 12
    rgb = blank()
    for brow in (slice(17, 22), slice(22, 27)):
        cv2.polylines(rgb, [np.rint(face.points_px[brow] * 16).astype(np.int32)], False, (40,) * 3, thick, 16, 4)
    start = moved(face, slice(17, 27), [0, off])
    after = brows(Photo(rgb), start, BrowsSettings(edge="upper")).points_px
    # A stroke is as thick as said across itself, and the outer parts of a brow are aslant.
    within = (face.points_px - after)[[18, 19, 24, 25], 1]
    assert np.abs(within - thick / 2).max() < 2
    assert np.array_equal(np.delete(after, BROW, axis=0), np.delete(face.points_px, BROW, axis=0))


def test_on_a_flat_picture_there_is_no_upper_edge():
    face = plain_face(EYE, CENTRE)
    assert np.allclose(brows(Photo(blank()), face, BrowsSettings(edge="upper")).points_px, face.points_px)


def test_brows_never_go_up():
    random = np.random.default_rng(0)
    face = plain_face(EYE, CENTRE)
    photo = Photo(random.integers(0, 255, (*SIZE, 3), np.uint8))
    assert (brows(photo, face, BrowsSettings()).points_px[:, 1] >= face.points_px[:, 1] - 1e-6).all()


@pytest.mark.parametrize("index", [5, 8, 10])
def test_one_outlier_comes_back_and_the_others_stay(index):
    face = jaw_on_circle(150)
    out = face.points_px[index] - CENTRE
    far = moved(face, index, 20 * out / np.hypot(*out))
    after = jaw_outliers(disc(), far, JawOutliersSettings()).points_px
    assert np.hypot(*(after[index] - face.points_px[index])) < 2
    others = np.delete(np.arange(68), index)
    assert np.array_equal(after[others], face.points_px[others])


def test_a_smooth_jaw_has_no_outliers():
    face = jaw_on_circle(150)
    assert jaw_outliers(disc(), face, JawOutliersSettings()) == face


def test_the_path_of_the_strongest_edge_is_believed():
    face = moved(jaw_on_circle(150), [6], [0, -25])
    after = jaw_outliers(disc(), face, JawOutliersSettings(score="path")).points_px
    assert abs(np.hypot(*(after[6] - CENTRE)) - 150) < 3


@pytest.mark.parametrize(("detector", "within"), [("harris", 0.35), ("fast", 3.0)])
def test_eye_corners_go_to_corners_at_known_places(detector, within):
    face = plain_face(EYE, CENTRE)
    rgb = blank()
    truth = []
    for k, corner in enumerate((36, 39, 42, 45)):
        x, y = face.points_px[corner].round() + np.array([0.25, 0.5])
        truth.append((x, y))
        side = 14 if k % 2 == 0 else -14
        wedge = np.array([[x, y], [x + side, y - 14], [x + side, y + 14]])
        cv2.fillPoly(rgb, [np.rint(wedge * 256).astype(np.int32)], (30,) * 3, cv2.LINE_AA, 8)
    start = moved(face, [36, 39, 42, 45], [[3, 2], [-3, 1], [2, -3], [-2, -2]])
    after = eye_corners(Photo(rgb), start, EyeCornersSettings(detector=detector)).points_px
    before = np.hypot(*(start.points_px[[36, 39, 42, 45]] - truth).T)
    error = np.hypot(*(after[[36, 39, 42, 45]] - truth).T)
    assert (error <= before).all()
    assert error.mean() < before.mean()
    # Antialiasing draws the tip of a wedge blunt, a little inside it.
    assert error.mean() < within + 1.2


def test_the_regularised_jaw_is_smoother_and_on_the_spline():
    random = np.random.default_rng(3)
    face = moved(jaw_on_circle(150), slice(0, 17), random.normal(0, 5, (17, 2)))
    after = jaw_spline(disc(), face, JawSplineSettings()).points_px[:17]
    spline = smoothing_spline(face.points_px[:17], 6 / 7)
    assert np.allclose(spline.nearest(after), after, atol=0.01)
    rough = [np.abs(np.diff(line, 2, axis=0)).sum() for line in (after, face.points_px[:17])]
    assert rough[0] < 0.9 * rough[1]


def test_without_smoothing_the_jaw_stays():
    face = jaw_on_circle(150)
    after = jaw_spline(disc(), face, JawSplineSettings(spacing=0.0))
    assert np.allclose(after.points_px, face.points_px, atol=1e-6)


@pytest.fixture(scope="module")
def faces():
    random = np.random.default_rng(5)
    mean = plain_face(EYE, CENTRE).points_px
    bases = random.normal(size=(10, 68, 2))
    return [mean + np.tensordot(random.normal(size=10), bases, 1) * 3 for _ in range(40)]


def test_all_components_rebuild_every_training_face(faces):
    model = train_shape(faces)
    for points in faces:
        assert np.allclose(model.project(points, 136), points, atol=1e-6)


def test_the_error_falls_with_the_components(faces):
    model = train_shape(faces)
    one = plain_face(EYE, CENTRE).points_px + np.random.default_rng(6).normal(0, 4, (68, 2))
    sides = model.sigma.ravel()
    errors = []
    for count in range(1, 20):
        change = (model.project(one, count) - one) @ similarity(one, model.mean)[:, :2].T
        errors.append(np.linalg.norm(change.ravel() / sides))
    assert (np.diff(errors) <= 1e-9).all()
    assert errors[-1] < errors[0]


@pytest.mark.parametrize(("turn", "scale"), [(0.3, 2.0), (-1.2, 0.1), (np.pi, 7.0)])
def test_the_shape_model_does_not_see_where_a_face_is(faces, turn, scale):
    model = train_shape(faces)
    matrix = scale * np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    points = plain_face(EYE, CENTRE).points_px
    there = model.project(points @ matrix.T + [30, -70], 8)
    assert np.allclose(there, model.project(points, 8) @ matrix.T + [30, -70], atol=1e-6 * scale * EYE)


def test_a_model_trained_on_mirrored_faces_is_symmetric(faces):
    model = train_shape(faces)
    assert np.allclose(model.mean, (model.mean * [-1, 1])[MIRROR] + model.mean.mean(axis=0) * [2, 0], atol=1e-6)


def test_the_components_are_orthonormal_and_sorted(faces):
    model = shipped_shape()
    gram = model.components.T @ model.components
    assert np.allclose(gram, np.eye(len(gram)), atol=1e-5)
    assert (np.diff(model.deviations) <= 0).all()
    assert model.variance_kept(model.components_for(0.9)) >= 0.9 > model.variance_kept(model.components_for(0.9) - 1)


def test_a_shape_model_is_the_same_after_saving(faces, tmp_path):
    model = train_shape(faces)
    save_shape(model, tmp_path / "shape.npz")
    again = load_shape(str(tmp_path / "shape.npz"))
    assert np.allclose(again.mean, model.mean, atol=1e-6)
    face = plain_face(EYE, CENTRE)
    settings = ShapeSettings(components=0, variance=0.9, model=str(tmp_path / "shape.npz"))
    assert np.isfinite(shape(Photo(blank()), face, settings).points_px).all()


@pytest.mark.parametrize("names", ["brows,nose", "jaw", "brows,,x"])
def test_an_unknown_correction_is_named(names):
    with pytest.raises(BadInput, match="choose from best, jaw-gradient, brows"):
        names_of(names)


def test_names_are_read_in_their_order():
    assert names_of("brows, jaw-gradient") == ("brows", "jaw-gradient")
    assert names_of("none") == names_of("") == ()


def test_a_sequence_is_one_after_the_other():
    photo, face, settings = disc(), jaw_on_circle(160), RefineSettings()
    both = refine(photo, face, "jaw-gradient,jaw-spline", settings)
    first = jaw_gradient(photo, face, settings.jaw_gradient)
    assert both == jaw_spline(photo, first, settings.jaw_spline)
    assert refine(photo, face, "none", settings) is face


def test_a_profile_comes_back():
    profile = Face(np.random.default_rng(0).uniform(100, 200, (39, 2)), [90, 90, 210, 210])
    assert refine(disc(), profile, ",".join(REFINEMENTS), RefineSettings()) is profile


@pytest.mark.parametrize("name", REFINEMENTS)
def test_only_landmarks_change(name):
    face = dataclasses.replace(plain_face(EYE, CENTRE), score=3.5, yaw_deg=-4.0, detector="somebody")
    after = refine(disc(), face, name, RefineSettings())
    assert dataclasses.replace(after, points_px=face.points_px) == face


def random_photo(width, height, seed=0):
    noise = np.random.default_rng(seed).integers(0, 255, (height, width, 3)).astype(np.uint8)
    return Photo(cv2.GaussianBlur(noise, (0, 0), 2))


DEGENERATE = {
    "flat": (Photo(blank()), plain_face(EYE, CENTRE)),
    "black": (Photo(blank(0)), plain_face(EYE, CENTRE)),
    "noise": (random_photo(560, 600), plain_face(EYE, CENTRE)),
    "small": (random_photo(40, 40), plain_face(18.0, (20.0, 18.0))),
    "tiny": (random_photo(12, 12), plain_face(6.0, (6.0, 6.0))),
    "cut at the left": (random_photo(560, 600), plain_face(EYE, (40.0, 290.0))),
    "cut at the chin": (random_photo(560, 320), plain_face(EYE, (280.0, 290.0))),
    "half outside": (random_photo(560, 600), moved(plain_face(EYE, CENTRE), slice(0, 27), [-300.0, 0.0])),
    "outside": (random_photo(560, 600), plain_face(EYE, (5000.0, 290.0))),
    "one pixel": (random_photo(1, 1), plain_face(EYE, (0.0, 0.0))),
    "one point": (random_photo(560, 600), Face(np.full((68, 2), 100.0), [90, 90, 110, 110])),
    "jaw in one point": (disc(), face_of(np.r_[np.full((17, 2), 290.0), plain_face(EYE, CENTRE).points_px[17:]])),
    "eyes in two points": (disc(), face_of(np.where(np.arange(68)[:, None] < 40, 100.0, 200.0) * np.ones((68, 2)))),
    "upside down": (random_photo(560, 600), face_of(2 * CENTRE - plain_face(EYE, CENTRE).points_px)),
    "large": (random_photo(3000, 2500), plain_face(1400.0, (1500.0, 1200.0))),
}


def corrected_or_why_not(photo, face, name):
    try:
        return refine(photo, face, name, RefineSettings()).points_px
    except BadInput as error:
        return str(error)


@pytest.mark.parametrize("name", REFINEMENTS)
@pytest.mark.parametrize("case", DEGENERATE)
def test_degenerate_input_gives_a_result_or_one_line(name, case):
    photo, face = DEGENERATE[case]
    after = corrected_or_why_not(photo, face, name)
    if isinstance(after, str):
        assert len(after.splitlines()) == 1
        return
    assert np.isfinite(after).all()
    changed = (after != face.points_px).any(axis=1)
    assert ((after[changed] >= 0) & (after[changed] <= np.array(photo.size_px) - 1)).all()


@pytest.mark.parametrize("name", [name for name in REFINEMENTS if name != "jaw-outliers"])
def test_the_mirror_image_is_corrected_the_same(name):
    photo, face = disc(), plain_face(EYE, CENTRE)
    settings = RefineSettings()
    after = refine(photo, face, name, settings)
    there = refine(*mirrored(photo, face), name, settings)
    assert np.allclose(there.points_px, mirrored(photo, after)[1].points_px, atol=0.75)


@pytest.mark.parametrize("name", REFINEMENTS)
def test_a_correction_is_the_same_each_time(name):
    photo, face = DEGENERATE["noise"]
    assert refine(photo, face, name, RefineSettings()) == refine(photo, face, name, RefineSettings())
