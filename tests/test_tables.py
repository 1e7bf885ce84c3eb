"""The thesis's tables and figures from annotated photos: the numbers are those of what was drawn."""

from __future__ import annotations

import dataclasses
import json

import cv2
import numpy as np
import pytest
from click.testing import CliRunner

from limner import storage
from limner.cli.evaluate import evaluate
from limner.cli.train import train
from limner.evaluate.corrections import CORRECTIONS, HeldOut, Measured, Truth, estimates, measure, read_truths, to_curve
from limner.evaluate.detections import detections, errors_of
from limner.evaluate.figures import figures, modes
from limner.evaluate.tables import summary, tables
from limner.pipeline import Settings
from limner.types import Face, Photo
from limner.vision.landmarks.fmp.dataset import Sample
from limner.vision.refine import RefineSettings
from portraits import astronaut, resized


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Five people, all of them the astronaut at other sizes."""
    folder = tmp_path_factory.mktemp("set")
    (folder / "images").mkdir()
    photo, face = astronaut()
    names, sizes, points = [], [], []
    for k, factor in enumerate((1.0, 0.95, 0.9, 0.85, 0.8)):
        small, there, _ = resized(photo, face, factor)
        names.append(f"{k}_a.png")
        cv2.imwrite(str(folder / "images" / names[-1]), small.rgb[:, :, ::-1])
        sizes.append(small.size_px)
        points.append(there.points_px + np.random.default_rng(k).normal(0, 0.3, (68, 2)))
    arrays = {"names": np.array(names), "size_wh": np.array(sizes), "ibug68": np.array(points)}
    storage.write_whole(folder / "landmarks.npz", storage.pack_npz(arrays))
    return folder


def test_a_shifted_detection_is_off_by_the_shift(folder):
    truths = read_truths(folder)
    faces = [_face(truth.sample.points_px + np.array([3.0, 4.0])) for truth in truths]
    measured = measure(truths, faces, RefineSettings(), {})
    assert len(measured) == 5
    for one in measured:
        assert set(one.errors_px) == set(CORRECTIONS)
        assert np.allclose(one.errors_px["initial"], 5.0)
        assert np.isfinite(list(one.errors_px.values())).all()


def _face(points):
    return Face(points, [*points.min(axis=0), *(points.max(axis=0) + 1)])


def test_a_correction_changes_only_its_own_landmarks(folder):
    truths = read_truths(folder)[:1]
    (one,) = measure(
        truths, [_face(truths[0].sample.points_px)], RefineSettings(), {truths[0].sample.person: HeldOut()}
    )
    assert not np.delete(one.errors_px["brows"], np.arange(17, 27)).any()
    assert not one.errors_px["spline"][17:].any()
    assert not np.delete(one.errors_px["fast"], [36, 39, 42, 45]).any()


def test_where_only_a_curve_is_annotated_its_distance_counts(folder):
    sample = read_truths(folder)[0].sample
    points = sample.points_px.copy()
    points[:17] = np.nan
    jaw = np.stack([np.linspace(0, 500, 11), np.full(11, 170.0)], axis=1)
    truth = Truth(dataclasses.replace(sample, points_px=points), jaw)
    (one,) = measure([truth], [_face(sample.points_px)], RefineSettings(), {})
    expected = np.abs(sample.points_px[3:14, 1] - 170)
    assert np.allclose(one.errors_px["initial"][3:14], expected, atol=1e-6)
    assert np.isnan(one.errors_px["initial"][[0, 1, 2, 14, 15, 16]]).all()


def test_distances_to_a_line_along_the_brows_make_a_table_of_their_own(folder):
    sample = read_truths(folder)[0].sample
    level = [np.stack([np.linspace(0, 500, 5), np.full(5, 40.0)], axis=1)] * 2
    (one,) = measure([Truth(sample, brows_px={"level": tuple(level)})], [_face(sample.points_px)], RefineSettings(), {})
    expected = np.abs(sample.points_px[17:27, 1] - 40)
    assert np.allclose(one.brows_px["level"]["initial"], expected, atol=1e-6)
    grid = tables("set", [one])[1]
    assert grid.title.endswith("level")
    assert grid.rows[-2][1].startswith(f"{expected.mean():.2f} /")


def test_distance_to_a_curve_is_zero_on_it():
    knots = np.array([[0, 0], [10, 4], [20, 0], [30, -4]], float)
    assert to_curve(knots, knots, 100.0) == pytest.approx(0, abs=0.01)
    assert to_curve(np.array([[0.0, -1.0]]), np.array([[-50.0, 0.0], [50.0, 0.0]]), 100.0) == pytest.approx(1)


def measured(error, unit=100.0):
    return Measured(unit, {name: np.full(68, error * (1 if name == "initial" else 0.5)) for name in CORRECTIONS})


def test_tables_have_the_thesis_s_form_and_its_figures():
    brows, corners, jaw, total = tables("set", [measured(10.0), measured(20.0, 200.0)])
    assert len(brows.rows) == 10 + 2
    assert len(corners.rows) == 4 + 2
    assert len(jaw.rows) == 17 + 2
    assert brows.rows[0] == ("1", "15.00 / 10.00 %", "7.50 / 5.00 %", "7.50 / 5.00 %", "14.84", "8.02")
    assert brows.rows[-1][2:] == ("-50 %", "-50 %", "", "-45 %")
    assert jaw.rows[-2][6:] == ("16.47", "11.92", "11.60", "13.04", "13.16")
    assert total.rows[-1] == ("best", *["5.00 %"] * 5, "0 of 2")


def test_a_table_of_no_face_is_no_error():
    assert summary("set", []).rows == ()


def test_estimates_are_of_people_the_model_never_saw(folder):
    samples = [truth.sample for truth in read_truths(folder)]
    errors, count = estimates(samples, count=2)
    assert len(errors) == 2
    assert count >= 1
    assert 0 < min(errors) < max(errors) < 0.1


def test_a_detector_s_errors_come_with_their_mirror_image(folder):
    samples = [truth.sample for truth in read_truths(folder)]
    faces = [_face(sample.points_px * 1.2) for sample in samples]
    errors = errors_of(samples, [*faces[:4], None])
    assert len(errors) == 8
    assert np.abs(errors).max() < 1e-9
    assert errors_of(samples, [None] * 5) == []


@pytest.mark.slow
def test_detections_are_in_the_pixels_of_the_photo(folder):
    samples = [truth.sample for truth in read_truths(folder)][:2]
    for sample, face in zip(samples, detections(samples, "", lambda *_: None), strict=True):
        assert np.hypot(*(face.points_px - sample.points_px).T).mean() < 0.08 * sample.outer_eye_px


def test_the_figures_are_all_there_and_not_blank():
    photo, face = astronaut()
    drawn = figures([photo, photo], [face, face], Settings())
    assert list(drawn) == [f"3.{number}" for number in (1, 2, 3, *range(5, 15))]
    for picture in drawn.values():
        assert picture.dtype == np.uint8
        assert picture.std() > 5


def test_the_modes_show_the_shipped_model():
    assert np.array_equal(modes(), modes())


def test_figures_of_a_face_cut_by_the_frame():
    photo, face = astronaut()
    cut = Photo(photo.rgb[:160, 190:260])
    there = dataclasses.replace(face, points_px=face.points_px - [190, 0])
    assert len(figures([cut], [there], Settings())) == 13


@pytest.mark.slow
def test_the_command_prints_tables_and_json(folder):
    plain = CliRunner().invoke(evaluate, ["tables", "--data", str(folder)])
    assert plain.exit_code == 0
    assert "Table 3.4: jawline" in plain.output
    printed = CliRunner().invoke(evaluate, ["tables", "--data", str(folder), "--summary", "--json"])
    (table,) = json.loads(printed.output)["tables"]
    assert [row[0] for row in table["rows"]] == list(CORRECTIONS)


def test_train_shape_writes_a_model_that_face_can_use(folder, tmp_path):
    out = tmp_path / "shape.npz"
    ran = CliRunner().invoke(train, ["shape", "--data", str(folder), "-o", str(out), "--json"])
    assert ran.exit_code == 0
    assert json.loads(ran.output)["faces"] == 5
    photo, face = astronaut()
    settings = RefineSettings().assign("shape.model", str(out))
    truth = Truth(Sample(folder / "images" / "0_a.png", "set/0", face.points_px, photo.size_px))
    assert measure([truth], [face], settings, {})


def test_train_best_writes_a_model(folder, tmp_path):
    out = tmp_path / "best.npz"
    arguments = ["best", "--data", str(folder), "-o", str(out), "--set", "starts=1", "--set", "rank=8", "--json"]
    ran = CliRunner().invoke(train, arguments)
    assert ran.exit_code == 0
    assert json.loads(ran.output) == {"out": [str(out)], "faces": 5, "habits": 0}
