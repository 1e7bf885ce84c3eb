"""Annotated faces and a detector in; how many it finds and how far its landmarks are off, out."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from limner.types import Face, Floats, Photo
from limner.vision.landmarks.fmp import detector as fmp
from limner.vision.landmarks.fmp.dataset import Sample, folds
from limner.vision.landmarks.fmp.examples import Watch, silent
from limner.vision.landmarks.fmp.mining import overlap
from limner.vision.landmarks.fmp.model import FmpModel, save_model
from limner.vision.landmarks.fmp.scenes import Scene, of_samples, read_image
from limner.vision.landmarks.fmp.train_settings import TrainSettings
from limner.vision.landmarks.fmp.training import train

FOUND = 0.5
"""A face is found when the boxes around its known and its detected landmarks overlap by more (union = 1)."""

REGIONS = {
    "jaw": slice(0, 17),
    "brows": slice(17, 27),
    "nose": slice(27, 36),
    "eyes": slice(36, 48),
    "mouth": slice(48, 68),
}
"""The iBUG landmarks of each region."""

INNER = slice(17, 68)
"""All but the jaw."""

Detect = Callable[[Photo], Sequence[Face]]


@dataclass(frozen=True, eq=False)
class Outcome:
    """What became of one annotated face.

    Attributes:
        sample: the face.
        face: what was detected there; None where it was not found.
        wrong: detections elsewhere in the photo.
        error: (68,) distance of each landmark over that of the outer eye corners; NaN where unknown or not found.
    """

    sample: Sample
    face: Face | None
    wrong: int
    error: Floats


@dataclass(frozen=True, eq=False)
class LandmarkReport:
    """The outcomes of a set of faces.

    Attributes:
        name: of the set.
        outcomes: of each face.
    """

    name: str
    outcomes: tuple[Outcome, ...]

    @property
    def found(self) -> int:
        """Faces found."""
        return sum(outcome.face is not None for outcome in self.outcomes)

    @property
    def wrong(self) -> int:
        """Detections where no annotated face is."""
        return sum(outcome.wrong for outcome in self.outcomes)

    def error_percent(self, landmarks: slice = slice(None)) -> float:
        """Mean error of some landmarks over the faces found, in percent of the outer-eye distance; NaN if none."""
        errors = np.array([outcome.error[landmarks] for outcome in self.outcomes])
        return 100 * float(np.nanmean(errors)) if np.isfinite(errors).any() else float("nan")

    def row(self) -> dict[str, Any]:
        """The figures by name: faces, found, wrong, and the errors in percent of the outer-eye distance."""
        row: dict[str, Any] = {"set": self.name, "faces": len(self.outcomes), "found": self.found, "wrong": self.wrong}
        row |= {"all_68": self.error_percent(), "inner_51": self.error_percent(INNER)}
        return row | {name: self.error_percent(region) for name, region in REGIONS.items()}


def evaluate_landmarks(name: str, samples: Sequence[Sample], detect: Detect, watch: Watch = silent) -> LandmarkReport:
    """Run a detector over annotated photos.

    Args:
        name: of the set.
        samples: the annotated faces; other people in their photos count as wrong detections.
        detect: photo -> faces.
        watch: told of progress.
    """
    outcomes = []
    for k, sample in enumerate(samples):
        watch(name, k, len(samples), sample.path.name)
        outcomes.append(_outcome(sample, detect(Photo(read_image(sample.path)))))
    watch(name, len(samples), len(samples), "")
    return LandmarkReport(name, tuple(outcomes))


def _outcome(sample: Sample, faces: Sequence[Face]) -> Outcome:
    error = np.full(68, np.nan)
    overlaps = [_overlap(sample, face) for face in faces]
    right = [face for face, share in zip(faces, overlaps, strict=True) if share > FOUND]
    if not right:
        return Outcome(sample, None, len(faces), error)
    face = max(right, key=lambda face: face.score)
    if face.frontal:
        error = np.hypot(*(face.points_px - sample.points_px).T) / sample.outer_eye_px
    return Outcome(sample, face, len(faces) - len(right), error)


def _overlap(sample: Sample, face: Face) -> float:
    points = face.points_px[sample.known] if face.frontal else face.points_px
    return overlap(np.concatenate([points.min(axis=0), points.max(axis=0)]), sample.box_px)


@contextmanager
def with_model(model: FmpModel) -> Iterator[Detect]:
    """The detector, as it is used for drawing, with a model that is not in a file."""
    with tempfile.TemporaryDirectory() as folder:
        settings = fmp.FmpSettings(model=str(Path(folder) / "model.npz"))
        save_model(model, settings.model)
        yield lambda photo: fmp.detect(photo, settings)


def cross_validate(
    samples: Sequence[Sample],
    scenes: Sequence[Scene],
    settings: TrainSettings,
    count: int = 5,
    helpers: Sequence[Sample] = (),
    watch: Watch = silent,
) -> LandmarkReport:
    """Train ``count`` times without some of the people, and find those.

    Args:
        samples: the annotated faces to measure on, and to train on.
        scenes: more scenes without faces, beside the photos of the people trained on.
        settings: of training.
        count: of folds.
        helpers: more faces to train on, unless of a person held out.
        watch: told of progress.

    Returns:
        The outcome of each sample under the model that never saw its person.
    """
    outcomes: list[Outcome] = []
    for k, held_out in enumerate(folds(samples, count, settings.seed)):
        watch("fold", k, count, f"{len(held_out)} people held out")
        seen = [sample for sample in [*samples, *helpers] if sample.person not in held_out]
        model = train(seen, [*of_samples(seen), *scenes], settings, watch).model
        kept = [sample for sample in samples if sample.person in held_out]
        with with_model(model) as detect:
            outcomes += evaluate_landmarks(f"fold {k + 1}", kept, detect, watch).outcomes
    watch("fold", count, count, "")
    return LandmarkReport(f"{count}-fold cross-validation", tuple(outcomes))
