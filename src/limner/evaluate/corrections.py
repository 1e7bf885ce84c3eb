"""Annotated faces and detections of them in; how far the landmarks are off before and after each correction, out."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

import numpy as np

from limner import geometry
from limner.storage import read_bytes, unpack_npz
from limner.types import Face, Floats, Photo
from limner.vision.landmarks.fmp.dataset import Sample, check_table, folds, read_folder
from limner.vision.landmarks.fmp.scenes import read_image
from limner.vision.refine import RefineSettings, refine
from limner.vision.refine.descent import save_descent
from limner.vision.refine.descent_training import DescentTrainSettings, train_best
from limner.vision.refine.shape import save_shape, train_shape
from limner.vision.splines import natural_spline

Watch = Callable[[str, int, int, str], None]

FOLDS = 5

CORRECTIONS = {
    "initial": "none",
    "brows": "brows",
    "brows-upper": "brows",
    "harris": "eye-corners",
    "fast": "eye-corners",
    "gradient": "jaw-gradient",
    "spline": "jaw-gradient,jaw-spline",
    "shape35": "shape",
    "shape50": "shape",
    "best": "best",
}
"""What is measured, and the corrections that it stands for."""

_ABOVE_THE_LOBES = [0, 1, 2, 14, 15, 16]  # landmarks of the jaw where IMM's curve has not begun
_STEP = 0.005  # of curves, in outer-eye distances


@dataclass(frozen=True, eq=False)
class Truth:
    """An annotated face.

    Attributes:
        sample: its photo and landmarks, NaN where there is none.
        jaw_px: (n, 2) the annotated curve of the jaw, where its landmarks are unknown.
        brows_px: by name lines (n, 2) along each brow, where its whole outline is annotated.
    """

    sample: Sample
    jaw_px: Floats | None = None
    brows_px: dict[str, tuple[Floats, Floats]] = field(default_factory=dict)


@dataclass(frozen=True)
class HeldOut:
    """Files of models that never saw a person; empty for the shipped ones."""

    shape: str = ""
    best: str = ""


@dataclass(frozen=True, eq=False)
class BestTraining:
    """How `best` is trained without some people.

    Attributes:
        settings: of training.
        habits: the people held out -> errors of detectors on the others.
    """

    settings: DescentTrainSettings
    habits: Callable[[frozenset[str]], Sequence[Floats]]


@dataclass(frozen=True, eq=False)
class Measured:
    """How far off the landmarks of one face are.

    Attributes:
        unit_px: its outer-eye distance.
        errors_px: by name of ``CORRECTIONS`` (68,); NaN where unknown; the jaw to the curve where only that is known.
        brows_px: by name of the line along the brows, likewise (10,), the distances to it.
    """

    unit_px: float
    errors_px: dict[str, Floats]
    brows_px: dict[str, dict[str, Floats]] = field(default_factory=dict)


def read_truths(folder: str | Path) -> list[Truth]:
    """The annotated faces of a folder; of IMM (``imm73``) also the curves along jaw and brows.

    Raises:
        BadInput: as ``read_folder``.
    """
    samples, _ = read_folder(folder)
    labels = Path(folder) / "landmarks.npz"
    arrays = unpack_npz(read_bytes(labels), str(labels)) if labels.is_file() else {}
    if "imm73" not in arrays:
        return [Truth(sample) for sample in samples]
    check_table(labels, arrays, "imm73", "numbers", (len(arrays["names"]), 73, 2))
    outlines = dict(zip(arrays["names"].tolist(), arrays["imm73"], strict=True))
    return [_with_curves(sample, outlines[sample.path.name]) for sample in samples]


def _with_curves(sample: Sample, imm: Floats) -> Truth:
    """The jaw runs through points 62 to 72; a brow's middle is between its upper and its lower edge."""
    left = (imm[[0, 1, 2, 3, 4]] + imm[[0, 7, 6, 5, 4]]) / 2
    right = (imm[[12, 13, 14, 15, 8]] + imm[[12, 11, 10, 9, 8]]) / 2
    upper = sample.points_px[17:22], sample.points_px[22:27]
    return Truth(sample, imm[62:73], {"middle": (left, right), "upper edge": upper})


def measure(
    truths: Sequence[Truth], faces: Sequence[Face | None], settings: RefineSettings, models: Mapping[str, HeldOut]
) -> list[Measured]:
    """Correct every detection in each way and compare with the truth; faces that were not found are left out.

    Args:
        truths: annotated faces.
        faces: their detections.
        settings: of the corrections.
        models: for a person those that were trained without the person; the shipped ones for who is not in it.
    """
    return [
        _measured(truth, face, settings, models.get(truth.sample.person, HeldOut()))
        for truth, face in zip(truths, faces, strict=True)
        if face is not None
    ]


def _measured(truth: Truth, face: Face, settings: RefineSettings, models: HeldOut) -> Measured:
    photo = Photo(read_image(truth.sample.path))
    unit = truth.sample.outer_eye_px
    errors: dict[str, Floats] = {}
    brows: dict[str, dict[str, Floats]] = {line: {} for line in truth.brows_px}
    for name, names in CORRECTIONS.items():
        points = refine(photo, face, names, _settings(settings, name, models)).points_px
        errors[name] = _distances(truth.sample, points)
        if truth.jaw_px is not None:
            errors[name][:17] = to_curve(points[:17], truth.jaw_px, unit)
            errors[name][_ABOVE_THE_LOBES] = np.nan
        for line, sides in truth.brows_px.items():
            both = zip((points[17:22], points[22:27]), sides, strict=True)
            brows[line][name] = np.concatenate([to_curve(side, knots, unit) for side, knots in both])
    return Measured(unit, errors, brows)


def _settings(settings: RefineSettings, name: str, models: HeldOut) -> RefineSettings:
    if name in ("harris", "fast"):
        return settings.assign("eye_corners.detector", name)
    if name == "brows-upper":
        return settings.assign("brows.edge", "upper")
    if name.startswith("shape"):
        settings = settings.assign("shape.components", name.removeprefix("shape"))
        return settings.assign("shape.model", models.shape) if models.shape else settings
    return settings.assign("best.model", models.best) if models.best else settings


def _distances(sample: Sample, points: Floats) -> Floats:
    distance: Floats = np.hypot(*(points - sample.points_px).T)
    return distance


def to_curve(points: Floats, knots: Floats, unit: float) -> Floats:
    """Distance (n,) of points to the natural spline through knots."""
    line = natural_spline(knots).line(_STEP * unit)
    distance: Floats = np.min([geometry.distance_to_segments(points, a, b) for a, b in pairwise(line)], axis=0)
    return distance


def held_out(
    samples: Sequence[Sample], helpers: Sequence[Sample], folder: Path, best: BestTraining | None, watch: Watch
) -> dict[str, HeldOut]:
    """Train the models ``FOLDS`` times without some of the people, into files of a folder.

    Args:
        samples: annotated by people with all landmarks.
        helpers: more to train `best` on, unless of a person held out.
        folder: where the models go.
        best: how to train `best`; not given: only shapes are trained.
        watch: told of progress.
    """
    models: dict[str, HeldOut] = {}
    for k, people in enumerate(folds(samples, FOLDS)):
        watch("fold", k, FOLDS, f"{len(people)} people held out")
        kept = [sample for sample in samples if sample.person not in people]
        file = folder / f"shape-{k}.npz"
        save_shape(train_shape([sample.points_px for sample in kept]), file)
        model = ""
        if best is not None:
            model = str(folder / f"best-{k}.npz")
            more = [sample for sample in helpers if sample.person not in people]
            save_descent(train_best([*kept, *more], best.settings, watch, best.habits(people)), model)
        models |= dict.fromkeys(people, HeldOut(str(file), model))
    watch("fold", FOLDS, FOLDS, "")
    return models


def estimates(samples: Sequence[Sample], count: int = 10) -> tuple[list[float], int]:
    """Table 3.3: how far off the shape model's estimates of true landmarks are, on ``count`` people it never saw.

    Returns:
        For each the sum of the squared distances in outer-eye distances, and how many components held 99 %.
    """
    whole = [sample for sample in samples if sample.known.all()]
    people = list(dict.fromkeys(sample.person for sample in whole))[-count:]
    model = train_shape([sample.points_px for sample in whole if sample.person not in people])
    components = model.components_for(0.99)
    errors = []
    for person in people:
        sample = next(each for each in whole if each.person == person)
        change = (model.project(sample.points_px, components) - sample.points_px) / sample.outer_eye_px
        errors.append(float((change**2).sum()))
    return errors, components
