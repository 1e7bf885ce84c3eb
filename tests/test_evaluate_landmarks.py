"""``limner evaluate landmarks``: rows for several detectors, side by side, as a table and as JSON."""

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image

from limner.cli import landmarks as command
from limner.errors import BadInput
from limner.evaluate.landmarks import with_model
from limner.vision.landmarks import DetectSettings
from limner.vision.landmarks.fmp import model
from limner.vision.landmarks.fmp.scenes import read_image

SHIPPED = Path(model.__file__).parent / model.SHIPPED
ROW = ["all_68", "brows", "eyes", "faces", "found", "inner_51", "jaw", "model", "mouth", "nose", "set", "wrong"]


@pytest.fixture
def folder(shared, tmp_path):
    """Two people of the Canada set, at a third of their size."""
    labels = np.load(shared / "data/canada/landmarks.npz")
    (tmp_path / "few/images").mkdir(parents=True)
    names, points, sizes = labels["names"][:2], labels["ibug68"][:2], []
    for name in names:
        image = Image.open(shared / "data/canada/images" / name)
        image.reduce(3).save(tmp_path / "few/images" / name, quality=95)
        sizes.append(image.reduce(3).size)
    np.savez(tmp_path / "few/landmarks.npz", names=names, size_wh=sizes, ibug68=(points + 0.5) / 3 - 0.5)
    return str(tmp_path / "few")


def run(*arguments):
    done = CliRunner().invoke(command.landmarks, [str(argument) for argument in arguments])
    if isinstance(done.exception, BadInput):
        raise done.exception
    assert done.exit_code == 0, done.output
    return done.stdout


def test_detectors_stand_side_by_side(folder, shared, monkeypatch):
    monkeypatch.setenv("LIMNER_MODELS", str(shared / "data/models"))
    what = ["--data", folder, "--detector", "mediapipe", "--model", SHIPPED]
    report = json.loads(run(*what, "--no-false-alarms", "--json"))
    assert report["false_alarms"] == []
    mesh, mixture = report["landmarks"]
    assert sorted(mesh) == sorted(mixture) == ROW
    assert (mesh["model"], mixture["model"]) == ("mediapipe", SHIPPED.stem)
    for figures in (mesh, mixture):
        assert (figures["set"], figures["faces"], figures["found"], figures["wrong"]) == ("few", 2, 2, 0)
        regions = {"jaw": 17, "brows": 10, "nose": 9, "eyes": 12, "mouth": 20}
        mean = sum(figures[name] * count for name, count in regions.items()) / 68
        assert figures["all_68"] == pytest.approx(mean)
    assert max(mesh["inner_51"], mixture["inner_51"]) < 4


def test_the_table_has_every_figure(folder, shared, monkeypatch):
    monkeypatch.setenv("LIMNER_MODELS", str(shared / "data/models"))
    monkeypatch.setenv("COLUMNS", "160")
    few = command.pictures_without_face()[:3]
    monkeypatch.setattr(command, "pictures_without_face", lambda: few)
    table = run("--data", folder, "--detector", "mediapipe")
    for word in (*command.COLUMNS.values(), "mediapipe", "few", "pictures", "false alarms"):
        assert word in table


def test_what_is_not_known_is_not_shown(folder, shared, monkeypatch, tmp_path):
    monkeypatch.setenv("LIMNER_MODELS", str(shared / "data/models"))
    (tmp_path / "few/landmarks.npz").rename(tmp_path / "few/landmarks_machine.npz")
    (figures,) = json.loads(run("--data", folder, "--detector", "mediapipe", "--no-false-alarms", "--json"))[
        "landmarks"
    ]
    assert figures["jaw"] is figures["all_68"] is None
    assert 0 < figures["inner_51"] < 3
    assert command.shown(None) == "-"


def test_turned_faces_may_be_left_out(folder):
    samples = command.annotated((folder,), False)
    angles = sorted(abs(sample.yaw_deg) for sample in samples)
    assert len(command.not_turned(samples, None)) == 2
    assert len(command.not_turned(samples, (angles[0] + angles[1]) / 2)) == 1


def test_a_set_is_called_as_its_folder_or_file():
    assert command.name_of("data/london/") == "london"
    assert command.name_of("data/london/landmarks_smiling_machine.npz") == "london/smiling_machine"


def test_a_missing_model_is_said_before_any_work(folder, monkeypatch):
    monkeypatch.delenv("LIMNER_MODELS", raising=False)
    monkeypatch.setattr(command, "evaluate_landmarks", None)
    for wrong in (
        ["--detector", "mediapipe"],
        ["--model", "none.npz"],
        ["--model", "none.tflite"],
        ["--detector", "file"],
    ):
        with pytest.raises(BadInput, match=r"get face_landmark.tflite|cannot be read|choose fmp or mediapipe"):
            run("--data", folder, "--no-false-alarms", *wrong)


@pytest.mark.parametrize(
    ("detectors", "models", "default", "names"),
    [
        ((), (), True, ["fmp"]),
        ((), (), False, []),
        (("mediapipe", "fmp"), (), True, ["mediapipe", "fmp"]),
        ((), ("a/p99.mat", "b.tflite"), True, ["p99", "b"]),
    ],
)
def test_the_default_is_the_detector_of_the_settings(detectors, models, default, names):
    assert [item.name for item in command.to_measure(DetectSettings(), detectors, models, default=default)] == names


def test_folds_give_a_row_for_each_set_of_people_never_seen(folder, monkeypatch):
    trained = []

    def cross_validate(samples, scenes, settings, count, helpers, watch):
        trained.append((len(samples), len(scenes) > 10, settings.seed, count, len(helpers)))
        return command.evaluate_landmarks("x", samples, lambda photo: ())

    monkeypatch.setattr(command, "cross_validate", cross_validate)
    report = json.loads(run("--data", folder, "--folds", 2, "--helpers", folder, "--no-false-alarms", "--json"))
    assert trained == [(2, True, 0, 2, 2)]
    assert report["training"] == command.TrainSettings().to_dict()
    (figures,) = report["landmarks"]
    assert (figures["model"], figures["set"], figures["faces"], figures["found"]) == ("2-fold", "few", 2, 0)
    assert figures["all_68"] is None


def test_folds_say_how_their_models_were_trained(folder, monkeypatch, tmp_path):
    monkeypatch.setenv("COLUMNS", "160")
    (tmp_path / "quick.toml").write_text("rounds = 2\nscenes = 30\n")
    seen = []

    def cross_validate(samples, scenes, settings, count, helpers, watch):
        seen.append((settings.rounds, settings.scenes))
        return command.evaluate_landmarks("x", samples, lambda photo: ())

    monkeypatch.setattr(command, "cross_validate", cross_validate)
    what = ["--data", folder, "--folds", 2, "--no-false-alarms", "--train-settings", tmp_path / "quick.toml"]
    table = run(*what)
    assert seen == [(2, 30)]
    assert "folds trained with rounds=2, scenes=30" in table
    assert command.other_than_default(command.TrainSettings()) == ""


def test_a_model_that_is_in_no_file_finds_what_the_same_in_a_file_does(folder):
    (sample, _) = command.annotated((folder,), False)
    photo = command.Photo(read_image(sample.path))
    with with_model(model.default_model()) as detect:
        (again,) = detect(photo)
    (face,) = command.detect(photo, command.DetectSettings())
    assert np.array_equal(again.points_px, face.points_px)
