"""Annotated faces and scenes without faces in; a trained flexible mixture of parts and what training reached, out."""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from limner.errors import BadInput
from limner.types import Floats
from limner.vision.landmarks.fmp import checkpoint, initial
from limner.vision.landmarks.fmp.completion import completed
from limner.vision.landmarks.fmp.dataset import Sample
from limner.vision.landmarks.fmp.examples import FLOOR, Examples, Round, Share, Watch, silent
from limner.vision.landmarks.fmp.hog import CHANNELS
from limner.vision.landmarks.fmp.layout import SIZE
from limner.vision.landmarks.fmp.learning import Learned, learning_curve
from limner.vision.landmarks.fmp.mining import levels
from limner.vision.landmarks.fmp.model import Component, FmpModel
from limner.vision.landmarks.fmp.positives import Positive, View, show, views
from limner.vision.landmarks.fmp.pyramid import FILTER
from limner.vision.landmarks.fmp.scenes import Scene, read_image
from limner.vision.landmarks.fmp.train_settings import TrainSettings as TrainSettings


@dataclass(frozen=True, eq=False)
class Trained:
    """A model and how it came about.

    Attributes:
        model: ready to be saved.
        rounds: what each round reached.
        curve: how well models of ever more of the people do on others.
        face_scores: of all views of the training faces.
        left_out: one line for each face that could not be used.
    """

    model: FmpModel
    rounds: tuple[Round, ...]
    curve: tuple[Learned, ...]
    face_scores: Floats
    left_out: Sequence[str]


def train(
    samples: Sequence[Sample],
    scenes: Sequence[Scene],
    settings: TrainSettings,
    watch: Watch = silent,
    state: Path | None = None,
    share: Share = map,
) -> Trained:
    """Train a model (thesis 3.2.1, eq. 3.4 and 3.5).

    Trees, filters and springs are first set from their statistics, part by part. Then, round by round, the faces are
    placed, the scenes are searched for what is taken for a face, and all weights are solved for together.

    Args:
        samples: faces with all 68 landmarks, or of people of whom another photo has them all; of those that a machine
            annotated only the ones fit for it (see ``completed``).
        scenes: where there is no face but the marked ones.
        settings: how.
        watch: told of progress.
        state: file that keeps what each round reached: an interrupted training goes on from there and ends the same.
        share: by what features are computed and scenes searched, for instance by the processes of a cluster.

    Raises:
        BadInput: no face, no scene, or a state of another training.
    """
    samples, left_out = completed(samples)
    if not samples or not scenes:
        raise BadInput(f"training: {len(samples)} usable faces and {len(scenes)} scenes; expected some of both")
    names = [*(str(sample.path) for sample in samples), *(scene.name for scene in scenes)]
    ticket = checkpoint.ticket(settings, names)
    rng = np.random.default_rng(settings.seed)
    scenes = [scenes[k] for k in rng.permutation(len(scenes))[: settings.scenes * max(settings.rounds, 1)]]
    faces = show_all(samples, settings, rng, watch, share)
    rounds: list[Round] = []
    if state and state.is_file():
        saved = checkpoint.load(state, ticket)
        rounds, curve = list(saved.rounds), saved.curve
        examples = Examples(saved.model, faces, scenes, settings, watch, share)
        examples.restore(saved.start, saved.placed, saved.groups, saved.alpha)
    else:
        background = initial.Background.of(
            _maps(scenes[: settings.scenes], settings, watch, share), settings.patches, rng
        )
        curve = learning_curve(faces, settings.stiffness, background, rng)
        examples = Examples(first_model(faces, background, settings), faces, scenes, settings, watch, share)
    while len(rounds) < settings.rounds:
        rounds.append(examples.round(len(rounds)))
        if state:
            checkpoint.save(examples, rounds, curve, state, ticket)
    scores, meta = examples.face_scores(), _meta(samples, settings, rounds, curve)
    model = dataclasses.replace(examples.model, threshold=_threshold(scores, rounds, settings), name="fmp", meta=meta)
    return Trained(model, tuple(rounds), curve, scores, left_out)


def _meta(
    samples: Sequence[Sample], settings: TrainSettings, rounds: Sequence[Round], curve: Sequence[Learned]
) -> dict[str, Any]:
    """What is kept with the model of how it was trained."""
    return {
        "faces": dict(Counter(_source(sample) for sample in samples)),
        "settings": settings.to_dict(),
        "rounds": [item.to_dict() for item in rounds],
        "learning_curve": [item.to_dict() for item in curve],
    }


def show_all(
    samples: Sequence[Sample], settings: TrainSettings, rng: np.random.Generator, watch: Watch, share: Share = map
) -> list[Positive]:
    """All views of all faces."""
    faces: list[Positive] = []
    each = [(sample, list(views(settings.poses, settings.views, settings.zoom, rng))) for sample in samples]
    for k, some in enumerate(share(partial(_shown, settings=settings), each)):
        watch("faces", k, len(samples), samples[k].path.name)
        faces += some
    watch("faces", len(samples), len(samples), f"{len(faces)} views")
    return faces


def _shown(of: tuple[Sample, list[View]], settings: TrainSettings) -> list[Positive]:
    sample, some = of
    return show(sample, read_image(sample.path), some, settings.eye_cells, settings.cell_px)


def first_model(faces: Sequence[Positive], background: initial.Background, settings: TrainSettings) -> FmpModel:
    """Trees, filters and springs from the statistics of each pose; its scores are log odds, in a unit that suits."""
    filters: list[Floats] = []
    components: list[Component] = []
    shared = initial.whitened_filters(faces, range(len(faces[0].cells)), background) if settings.shared else None
    if shared is not None:
        filters.append(shared[0] / SIZE)
    for k, pose in enumerate(settings.poses):
        of_pose = [face for face in faces if face.pose == k]
        start = 0 if settings.shared else sum(map(len, filters))
        some, component = initial.mixture(of_pose, start, pose.yaw_deg, settings.stiffness, background, shared)
        filters.append(some)
        components.append(component)
    pool = np.concatenate(filters).reshape(-1, FILTER, FILTER, CHANNELS)
    return FmpModel(pool, tuple(components), 0.0, settings.interval, settings.cell_px)


def _maps(scenes: Sequence[Scene], settings: TrainSettings, watch: Watch, share: Share) -> list[NDArray[np.float32]]:
    maps: list[NDArray[np.float32]] = []
    for k, some in enumerate(share(partial(_background, settings=settings), scenes)):
        watch("background", k, len(scenes), scenes[k].name)
        maps += some
    watch("background", len(scenes), len(scenes), f"{len(maps)} maps")
    return maps


def _background(scene: Scene, settings: TrainSettings) -> list[NDArray[np.float32]]:
    found, _ = levels(scene, settings.scene_px, 1, settings.cell_px)
    return [level.features for level in found if min(level.features.shape[:2]) > 2 * FILTER]


def _source(sample: Sample) -> str:
    return f"{sample.path.parent.parent.name}/{sample.path.parent.name}"


def _threshold(face_scores: Floats, rounds: Sequence[Round], settings: TrainSettings) -> float:
    """Between the scores of the faces and of what was most like one in the last round, whose scenes were new."""
    faces, worst = float(np.percentile(face_scores, 5)), rounds[-1].worst
    worst = min(faces, FLOOR if worst is None else worst)
    return worst + settings.caution * (faces - worst)
