"""``limner evaluate landmarks``: annotated photos and detectors in, a table of what they find and how well, out."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import click
import numpy as np
from rich.console import Console, Group
from rich.table import Table

from limner.cli import options
from limner.cli.gathered import gathered
from limner.cli.progress import Watch, bars
from limner.cli.train import annotated
from limner.errors import BadInput
from limner.evaluate.false_alarms import count_false_alarms, pictures_without_face
from limner.evaluate.landmarks import Detect, LandmarkReport, cross_validate, evaluate_landmarks
from limner.pipeline import Settings
from limner.settings import read_toml
from limner.storage import read_bytes
from limner.types import Photo
from limner.vision.landmarks import DetectSettings, detect
from limner.vision.landmarks.fmp import scenes as fmp_scenes
from limner.vision.landmarks.fmp.dataset import Sample
from limner.vision.landmarks.fmp.train_settings import TrainSettings

COLUMNS = {
    "faces": "faces",
    "found": "found",
    "wrong": "wrong",
    "all_68": "68 points",
    "inner_51": "inner 51",
    "jaw": "jaw",
    "brows": "brows",
    "eyes": "eyes",
    "nose": "nose",
    "mouth": "mouth",
}
"""The figures of a row, and their headings."""


class Measured(NamedTuple):
    """A way to find faces that is measured."""

    name: str
    detect: Detect


class Faces(NamedTuple):
    """A set of annotated faces."""

    name: str
    samples: list[Sample]


@dataclass(frozen=True)
class LandmarksWish:
    """Which detectors are measured on which faces.

    Attributes:
        data: folders of annotated photos.
        detectors: by name.
        models: files of models.
        folds: models trained and measured crosswise, or None.
        helpers: folders of photos to train those on, too.
        train_settings: file of settings for that, or None.
        yaw: faces turned by more are left out [deg]; None: none is.
        false_alarms: whether they are counted in pictures without a face.
        skip_bad: whether unusable annotations are left out.
        as_json: whether the rows are printed as JSON.
    """

    data: tuple[str, ...]
    detectors: tuple[str, ...]
    models: tuple[str, ...]
    folds: int | None
    helpers: tuple[str, ...]
    train_settings: str | None
    yaw: float | None
    false_alarms: bool
    skip_bad: bool
    as_json: bool

    def training(self) -> TrainSettings:
        """How the models of the folds are trained."""
        if self.train_settings is None:
            return TrainSettings()
        return read_toml(TrainSettings, read_bytes(self.train_settings).decode())

    def faces(self, folder: str) -> Faces:
        """Those of a folder that are measured on."""
        return Faces(name_of(folder), not_turned(annotated((folder,), self.skip_bad), self.yaw))


@click.command(short_help="Measure detectors side by side on annotated photos.")
@click.option("--data", multiple=True, required=True, metavar="DIR", help="Annotated photos; may be repeated.")
@click.option(
    "--detector", "detectors", multiple=True, metavar="NAME", help="fmp (default) or mediapipe; may be repeated."
)
@click.option(
    "--model",
    "models",
    multiple=True,
    metavar="FILE",
    help="A model: .npz or .mat for fmp, .tflite for mediapipe; may be repeated.",
)
@click.option(
    "--folds",
    type=click.IntRange(2),
    metavar="N",
    help="Also train N models, each without an N-th of the people, and measure each on those.",
)
@click.option(
    "--helpers",
    multiple=True,
    metavar="DIR",
    help="With --folds: photos to train on too, of other people than those held out.",
)
@click.option(
    "--train-settings",
    metavar="FILE",
    help="With --folds: settings of `limner train fmp`, as TOML; rounds = 2 and scenes = 30 take minutes, not an hour.",
)
@click.option("--yaw", type=click.FloatRange(0), metavar="DEG", help="Only faces turned by no more than this [deg].")
@click.option("--false-alarms/--no-false-alarms", default=True, help="Count them in pictures without a face, or not.")
@click.option("--skip-bad", is_flag=True, help="Leave out, by name, faces that lack landmarks or a photo.")
@options.settings_options
@options.json_option
@click.pass_context
@gathered(LandmarksWish)
def landmarks(ctx: click.Context, wish: LandmarksWish, save_settings: Path | None) -> None:
    """Measure detectors side by side: annotated faces found, wrong detections, and how far off landmarks are.

    A --data folder is what `limner train fmp` takes. Errors are mean distances in percent of that of the outer eye
    corners, over the faces found; the pictures without a face are scikit-image's, parts of them, and made-up ones.
    """
    settings = options.chosen_settings(ctx, Settings, save_settings).detect
    training = wish.training()
    measured = list(to_measure(settings, wish.detectors, wish.models, default=wish.folds is None))
    sets = [wish.faces(folder) for folder in wish.data]
    for item in measured:
        item.detect(Photo(np.zeros((320, 320, 3), np.uint8)))  # a missing model is said now, not in an hour
    empty = pictures_without_face() if wish.false_alarms else []
    rows, alarms = [], []
    with bars() as watch:
        for item in measured:
            for faces in sets:
                report = evaluate_landmarks(f"{item.name}, {faces.name}", faces.samples, item.detect, watch)
                rows.append(row(item.name, faces.name, report))
        if wish.folds:
            helping = annotated(wish.helpers, wish.skip_bad)
            rows += cross_validated(sets, helping, training, wish.folds, watch)
        for item in measured if empty else ():
            alarms.append({"model": item.name} | count_false_alarms(item.detect, empty, item.name, watch).row())
    if wish.as_json:
        trained = {"training": training.to_dict()} if wish.folds else {}
        click.echo(json.dumps({"landmarks": rows, "false_alarms": alarms} | trained))
    else:
        Console(highlight=False).print(tables(rows, alarms, other_than_default(training)))


def to_measure(
    settings: DetectSettings, detectors: Sequence[str], models: Sequence[str], *, default: bool
) -> Iterator[Measured]:
    """The detectors with their own models, then the models with their detectors; without any perhaps the default.

    Raises:
        BadInput: no such detector, or one that does not look at photos.
    """
    for name in detectors or ((settings.detector,) if default and not models else ()):
        if name not in MEASURABLE:
            raise BadInput(f"--detector {name}: cannot be measured; choose {' or '.join(MEASURABLE)}")
        yield Measured(name, detecting(settings.replace(detector=name)))
    for file in models:
        detector = "mediapipe" if file.lower().endswith(".tflite") else "fmp"
        own = getattr(settings, detector).replace(model=file)
        yield Measured(Path(file).stem, detecting(settings.replace(detector=detector, **{detector: own})))


MEASURABLE = ("fmp", "mediapipe")
"""Detectors that look for faces in a photo."""


def detecting(settings: DetectSettings) -> Detect:
    """The detector with its settings."""
    return lambda photo: detect(photo, settings)


def name_of(folder: str) -> str:
    """What the faces of a folder, or of a file of landmarks in it, are called."""
    path = Path(folder).resolve()
    return f"{path.parent.name}/{path.stem.removeprefix('landmarks_')}" if path.suffix == ".npz" else path.name


def not_turned(samples: list[Sample], yaw_deg: float | None) -> list[Sample]:
    """Those turned by no more than this; all for None."""
    return [sample for sample in samples if yaw_deg is None or abs(sample.yaw_deg) <= yaw_deg]


def cross_validated(
    sets: Sequence[Faces], helpers: Sequence[Sample], settings: TrainSettings, folds: int, watch: Watch
) -> list[dict[str, Any]]:
    """A row for each set, of models that never saw the people they are measured on."""
    scenes = fmp_scenes.sample_pictures() + fmp_scenes.textures(settings.textures, settings.seed)
    samples = [sample for faces in sets for sample in faces.samples]
    whole = cross_validate(samples, scenes, settings, folds, helpers, watch)
    rows = []
    for faces in sets:
        paths = {sample.path for sample in faces.samples}
        of_set = tuple(outcome for outcome in whole.outcomes if outcome.sample.path in paths)
        rows.append(row(f"{folds}-fold", faces.name, LandmarkReport(faces.name, of_set)))
    return rows


def row(model: str, faces: str, report: LandmarkReport) -> dict[str, Any]:
    """The figures by name; None where there are none, and for all 68 where the jaw is not known."""
    figures = {name: None if math.isnan(value) else value for name, value in report.row().items() if name in COLUMNS}
    if figures["jaw"] is None:
        figures["all_68"] = None
    return {"model": model, "set": faces} | figures


def other_than_default(training: TrainSettings) -> str:
    """How the models of the folds were trained, in words that go below the table; empty for the usual way."""
    usual = TrainSettings().to_dict()
    others = [f"{name}={value}" for name, value in training.to_dict().items() if value != usual[name]]
    return f"folds trained with {', '.join(others)}" if others else ""


def tables(rows: Sequence[dict[str, Any]], alarms: Sequence[dict[str, Any]], caption: str = "") -> Group:
    """All rows, and the false alarms if they were counted."""
    title = "limner: landmarks, mean error in % of the outer-eye distance"
    main = Table("model", "faces of", *COLUMNS.values(), title=title, title_justify="left")
    main.caption, main.caption_justify = caption, "left"
    for column in main.columns[2:]:
        column.justify = "right"
    for figures in rows:
        main.add_row(figures["model"], figures["set"], *(shown(figures[name]) for name in COLUMNS))
    if not alarms:
        return Group(main)
    below = Table("model", "pictures", "false alarms", "in", title="pictures without a face", title_justify="left")
    for figures in alarms:
        places = ", ".join(f"{place['picture']} ({place['score']:.2f})" for place in figures["in"][:4])
        more = len(figures["in"]) - 4
        where = places + (f" and {more} more" if more > 0 else "")
        below.add_row(figures["model"], str(figures["pictures"]), str(figures["false_alarms"]), where)
    return Group(main, "", below)


def shown(figure: float | None) -> str:
    """A count, or a percentage to a hundredth."""
    if figure is None:
        return "-"
    return str(figure) if isinstance(figure, int) else f"{figure:.2f}"
