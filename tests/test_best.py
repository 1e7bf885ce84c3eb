"""The learnt cascade: it converges on a real face, says when there is none, and training learns from few faces."""

from __future__ import annotations

import dataclasses

import cv2
import numpy as np
import pytest

from limner.errors import BadInput
from limner.types import Photo
from limner.vision.landmarks.fmp.dataset import Sample
from limner.vision.refine import RefineSettings, refine_in_steps
from limner.vision.refine.best import BestSettings, best, judge, load_best, shipped_best
from limner.vision.refine.descent import Pictures, save_descent, unpacked, view
from limner.vision.refine.descent_training import DescentTrainSettings, detector_errors, mean_face, train_best
from limner.vision.refine.shape import similarity
from portraits import MIRROR, astronaut, london, mirrored, plain_face, resized


def displaced(face, seed, share=0.03):
    """The face with its landmarks wrong by some parts of the outer-eye distance, features together."""
    random = np.random.default_rng(seed)
    by = random.normal(0, share, (68, 2)) * 0.5 + random.normal(0, share, 2)
    return dataclasses.replace(face, points_px=face.points_px + by * face.outer_eye_px)


def error(points, face):
    return np.hypot(*(points - face.points_px).T).mean() / face.outer_eye_px


def test_the_landmarks_of_a_real_face_stay_near_the_truth():
    photo, face = astronaut()
    # Her landmarks are known to whole pixels of a face 60 px wide.
    assert error(best(photo, face, BestSettings()).points_px, face) < 0.045


@pytest.mark.parametrize("seed", range(4))
def test_wrong_landmarks_come_nearer_to_where_the_true_ones_end(seed):
    photo, face = astronaut()
    end = best(photo, face, BestSettings())
    start = displaced(face, seed, 0.05)
    verdict = judge(photo, start, BestSettings())
    assert verdict.trusted
    assert error(verdict.face.points_px, end) < 0.65 * error(start.points_px, end)


def test_different_starts_end_in_one_place():
    photo, face = astronaut()
    ends = [best(photo, displaced(face, seed), BestSettings()).points_px for seed in range(5)]
    assert np.std(ends, axis=0).mean() < 0.015 * face.outer_eye_px


def test_on_the_portraits_it_was_trained_on_it_is_within_two_percent(shared):
    photo, face = london(shared, "001_03.jpg")
    assert error(best(photo, displaced(face, 0), BestSettings()).points_px, face) < 0.02


@pytest.mark.parametrize("blur", [0.6, 2.0, 6.0])
def test_where_there_is_no_face_the_input_comes_back(blur):
    noise = np.random.default_rng(int(blur)).integers(0, 255, (500, 500, 3)).astype(np.uint8)
    face = plain_face(128.0, (250.0, 230.0))
    verdict = judge(Photo(cv2.GaussianBlur(noise, (0, 0), blur)), face, BestSettings())
    assert not verdict.trusted
    assert verdict.face is face


def test_landmarks_beside_the_face_are_not_believed():
    photo, face = astronaut()
    wrong = dataclasses.replace(face, points_px=face.points_px + np.array([0.2, 1.5]) * face.outer_eye_px)
    assert best(photo, wrong, BestSettings()) is wrong
    steps = refine_in_steps(photo, wrong, "best", RefineSettings())
    assert steps[-1].face is wrong
    assert steps[-1].move == 0


@pytest.mark.parametrize("limits", [BestSettings(spread=0.0), BestSettings(move=0.0)])
def test_the_limits_decide(limits):
    photo, face = astronaut()
    assert best(photo, displaced(face, 0), limits) == displaced(face, 0)


def test_the_mirror_image_is_refined_alike():
    photo, face = astronaut()
    there = best(*mirrored(photo, face), BestSettings())
    back = mirrored(photo, best(photo, face, BestSettings()))[1]
    assert np.hypot(*(there.points_px - back.points_px).T).max() < 0.02 * face.outer_eye_px


def test_a_larger_photo_gives_the_same_places():
    photo, face = astronaut()
    large, there, factors = resized(photo, face, 2.0)
    after = (best(large, there, BestSettings()).points_px + 0.5) / factors - 0.5
    assert np.hypot(*(after - best(photo, face, BestSettings()).points_px).T).mean() < 0.01 * face.outer_eye_px


def test_what_is_seen_does_not_depend_on_where_the_face_is():
    photo, face = astronaut()
    grey = cv2.cvtColor(photo.rgb, cv2.COLOR_RGB2GRAY).astype(np.float32)
    model = shipped_best()
    look = model.steps[0].look
    views = []
    for shift in (0, 40):
        moved = np.roll(grey, shift, axis=1)
        points = face.points_px + np.array([shift, 0])
        views.append(view(Pictures(moved), points, similarity(points, look.place(model.mean)), look))
    assert np.allclose(*views, atol=0.02)


@pytest.fixture(scope="module")
def samples(tmp_path_factory):
    """The astronaut in a few lights and sizes, as if they were people."""
    folder = tmp_path_factory.mktemp("faces") / "set" / "images"
    folder.mkdir(parents=True)
    photo, face = astronaut()
    photo = Photo(photo.rgb[:300, 80:380])
    result = []
    for k, factor in enumerate((1.0, 0.8, 0.9)):
        small, there, _ = resized(photo, dataclasses.replace(face, points_px=face.points_px - [80, 0]), factor)
        path = folder / f"{k}_a.png"
        cv2.imwrite(str(path), small.rgb[:, :, ::-1])
        result.append(Sample(path, f"set/{k}", there.points_px, small.size_px))
    return result


SMALL = DescentTrainSettings(starts=4, rank=20)


def quiet(*_):
    pass


def test_training_learns_and_saving_keeps_it(samples, tmp_path):
    model = train_best(samples, SMALL, quiet)
    save_descent(model, tmp_path / "best.npz")
    photo, face = astronaut()
    start = dataclasses.replace(face, points_px=face.points_px + 0.05 * face.outer_eye_px)
    settings = BestSettings(model=str(tmp_path / "best.npz"), spread=1.0, move=2.0)
    assert error(best(photo, start, settings).points_px, face) < 0.6 * error(start.points_px, face)


def test_training_twice_gives_the_same_bytes(samples, tmp_path):
    for name in ("a.npz", "b.npz"):
        save_descent(train_best(samples, SMALL, quiet), tmp_path / name)
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


def test_a_machine_s_constant_habit_is_taken_out(samples):
    """Labels of a machine that puts the eyes too low teach no low eyes."""
    shifted = []
    for sample in samples:
        points = sample.points_px.copy()
        points[36:48, 1] += 0.05 * sample.outer_eye_px
        points[:17] = np.nan
        shifted.append(dataclasses.replace(sample, points_px=points, machine=True))
    photo, face = astronaut()
    model = train_best([*samples, *shifted], SMALL, quiet)
    plain = train_best(samples, SMALL, quiet)
    grey = Pictures(cv2.cvtColor(photo.rgb, cv2.COLOR_RGB2GRAY).astype(np.float32))
    low = [(each.run(grey, face.points_px) - face.points_px)[36:48, 1].mean() for each in (model, plain)]
    assert abs(low[0] - low[1]) < 0.02 * face.outer_eye_px


def test_too_few_faces_are_named(samples):
    with pytest.raises(BadInput, match="2 faces annotated by people"):
        train_best(samples[:2], SMALL, quiet)


def test_errors_of_a_detector_are_free_of_place_and_size():
    face = plain_face()
    mean = mean_face([face.points_px, face.points_px * 1.1, face.points_px * 0.9])
    error, flipped = detector_errors(face.points_px * 1.3 + 20, face.points_px, mean)
    assert np.allclose(error, 0, atol=1e-9)
    assert np.allclose(flipped, (error * [-1, 1])[MIRROR])


@pytest.mark.parametrize("data", [b"", b"not a zip"])
def test_a_damaged_model_is_one_line(data):
    with pytest.raises(BadInput, match="model"):
        unpacked(data, "model")


def test_another_npz_is_no_model(tmp_path):
    np.savez(tmp_path / "x.npz", mean=np.zeros((68, 2)))
    with pytest.raises(BadInput, match="no model of `limner train best`"):
        load_best(str(tmp_path / "x.npz"))
