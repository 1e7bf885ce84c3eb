"""Annotated faces in, the learnt cascade of `best` out."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby

import cv2
import numpy as np
from numpy.typing import NDArray

from limner.errors import BadInput
from limner.settings import SettingsGroup, setting
from limner.types import Face, Floats, Photo
from limner.vision.landmarks.fmp.dataset import Sample
from limner.vision.landmarks.fmp.scenes import read_image
from limner.vision.landmarks.mirror import MIRROR
from limner.vision.raster import Image
from limner.vision.refine.descent import LOOKS, Descent, Look, Pictures, Step, stepped, view
from limner.vision.refine.ground import grey_face
from limner.vision.refine.shape import inverse, moved, similarity, train_shape

Random = np.random.Generator
Watch = Callable[[str, int, int, str], None]

GROUPS = (slice(0, 17), slice(17, 22), slice(22, 27), slice(27, 36), slice(36, 42), slice(42, 48), slice(48, 68))
"""Features whose landmarks a detector gets wrong together."""

_BY_MACHINE = slice(17, 48)
"""Landmarks of which a machine's habits are taken out; the mouth, which moves, stays as it placed it."""


@dataclass(frozen=True)
class DescentTrainSettings(SettingsGroup):
    """How the cascade of `best` learns."""

    starts: int = setting(7, "starts of each face and of its mirror image", low=1, high=100)
    rank: int = setting(50, "directions kept of each step; more is larger and a little better", low=1, high=136)
    ridge: float = setting(0.01, "penalty on large maps; more is smoother", low=1e-6, high=10)
    habits: float = setting(0.7, "share of the starts that err as detectors do", low=0, high=1)
    turn: float = setting(0.07, "turn of the starts (sigma)", unit="rad", low=0, high=1)
    zoom: float = setting(0.07, "size of the starts (sigma of its logarithm)", low=0, high=1)
    shift: float = setting(0.05, "place of the starts (sigma)", unit="outer-eye distances", low=0, high=1)
    group: float = setting(0.035, "place of each feature (sigma)", unit="outer-eye distances", low=0, high=1)
    stretch: float = setting(0.12, "width and height of each feature (sigma of their logarithms)", low=0, high=1)
    point: float = setting(0.015, "place of each landmark (sigma)", unit="outer-eye distances", low=0, high=1)
    seed: int = setting(0, "start of the random numbers", low=0)


@dataclass(frozen=True, eq=False)
class Example:
    """A face to learn from, at the scale of corrections.

    Attributes:
        pictures: of it.
        points: (68, 2) in them.
        folder: where it is from.
        machine: whether a program placed the landmarks.
    """

    pictures: Pictures
    points: Floats
    folder: str
    machine: bool


def train_best(
    samples: Sequence[Sample], settings: DescentTrainSettings, watch: Watch, habits: Sequence[Floats] = ()
) -> Descent:
    """Learn the cascade, first from the faces that people annotated, then from all.

    Between both, what the first cascade finds on faces annotated by a machine says which habits the machine has
    (its offsets, equal in all photos of a folder); they are taken out, and the jaw is the cascade's own.

    Args:
        samples: annotated faces.
        settings: of the starts and of the regression.
        watch: told of progress.
        habits: (68, 2) how detectors are off on some faces (``detector_errors``); starts are made like these.

    Raises:
        BadInput: fewer than three faces annotated by people with all 68 landmarks.
    """
    hand = [sample for sample in samples if not sample.machine and sample.known.all()]
    if len(hand) < 3:
        raise BadInput(f"best: {len(hand)} faces annotated by people with all 68 landmarks; expected three or more")
    mean = mean_face([sample.points_px for sample in hand])
    examples = list(_examples(hand, mean))
    first = _learn(examples, mean, settings, watch, habits)
    machine = [sample for sample in samples if sample.machine and sample.known[_BY_MACHINE.start :].all()]
    if not machine:
        return first
    return _learn(examples + _unlearnt(list(_examples(machine, mean)), first), mean, settings, watch, habits)


def detector_errors(points_px: Floats, truth_px: Floats, mean: Floats) -> tuple[Floats, Floats]:
    """How a detector is off on a face (68, 2), in the frame of the mean face, and in the mirror."""
    error = _upright(points_px, points_px, mean) - _upright(truth_px, truth_px, mean)
    return error, (error * [-1, 1])[MIRROR]


def mean_face(faces: Sequence[Floats]) -> Floats:
    """The mean face (68, 2), outer-eye distance 1, origin between the outer eye corners."""
    mean = train_shape(faces).mean
    corners = mean[[36, 45]]
    placed: Floats = (mean - corners.mean(axis=0)) / np.hypot(*(corners[1] - corners[0]))
    return placed


def _examples(samples: Sequence[Sample], mean: Floats) -> Iterator[Example]:
    for sample in samples:
        known = sample.known
        points = np.where(known[:, None], sample.points_px, 0.0)
        points[~known] = moved(mean, similarity(mean[known], points[known]))[~known]
        face = Face(points, np.concatenate([points.min(axis=0), points.max(axis=0) + 1]))
        grey = grey_face(Photo(read_image(sample.path)), face)
        yield Example(Pictures(grey.image), grey.points, str(sample.path.parent), sample.machine)


def _unlearnt(examples: Sequence[Example], model: Descent) -> list[Example]:
    """The machine's examples without its habits."""
    result = []
    for _, members in groupby(sorted(examples, key=lambda each: each.folder), key=lambda each: each.folder):
        group = list(members)
        found = [model.run(each.pictures, each.points) for each in group]
        habits = np.median(
            [_upright(each.points, each.points, model.mean) - _upright(run, each.points, model.mean)
             for each, run in zip(group, found, strict=True)],
            axis=0,
        )  # fmt: skip
        habits = (habits + (habits * [-1, 1])[MIRROR]) / 2
        for each, run in zip(group, found, strict=True):
            points = each.points.copy()
            back = inverse(similarity(each.points, model.mean))[:, :2]
            points[_BY_MACHINE] -= habits[_BY_MACHINE] @ back.T
            points[:17] = run[:17]
            result.append(dataclasses.replace(each, points=points))
    return result


def _upright(points: Floats, face: Floats, mean: Floats) -> Floats:
    return moved(points, similarity(face, mean))


def _learn(
    examples: Sequence[Example], mean: Floats, settings: DescentTrainSettings, watch: Watch, habits: Sequence[Floats]
) -> Descent:
    random = np.random.default_rng(settings.seed)
    shapes = [_upright(each.points, each.points, mean) for each in examples if not each.machine]
    truths: list[Floats] = []
    pictures: list[Pictures] = []
    at: list[Floats] = []
    for example in examples:
        for each in (example, _flipped(example)):
            for number in range(settings.starts):
                pictures.append(Pictures(_lit(each.pictures.image, random)) if number else each.pictures)
                truths.append(each.points)
                at.append(_start(each.points, shapes, habits, mean, settings, random))
    steps: list[Step] = []
    for number, look in enumerate(LOOKS):
        watch("step", number, len(LOOKS), f"{len(examples)} faces, {len(at)} starts")
        step, at = _step(pictures, truths, at, mean, look, settings)
        steps.append(step)
    watch("step", len(LOOKS), len(LOOKS), "")
    return Descent(mean, tuple(steps))


def _flipped(example: Example) -> Example:
    image = np.ascontiguousarray(example.pictures.image[:, ::-1])
    points = (np.array([image.shape[1] - 1, 0]) + np.array([-1, 1]) * example.points)[MIRROR]
    return dataclasses.replace(example, pictures=Pictures(image), points=points)


def _lit(image: Image, random: Random) -> Image:
    """The picture in another light, and sometimes less sharp."""
    brightness, contrast, gamma = np.exp(random.normal(0, [0.15, 0.15, 0.3])).tolist()
    lit = np.clip(255 * brightness * (contrast * (image / 255 - 0.5) + 0.5), 0, 255)
    lit = 255 * (lit / 255) ** gamma
    sharp = random.random() < 0.6
    share = random.uniform(0.25, 0.8)
    if not sharp:
        size = image.shape[1], image.shape[0]
        small = cv2.resize(lit, None, fx=share, fy=share, interpolation=cv2.INTER_AREA)
        lit = cv2.resize(small, size, interpolation=cv2.INTER_LINEAR)
    return np.asarray(lit, np.float32)


def _start(
    points: Floats,
    shapes: Sequence[Floats],
    habits: Sequence[Floats],
    mean: Floats,
    settings: DescentTrainSettings,
    random: Random,
) -> Floats:
    """Where a detector might have put the landmarks: wrong as detectors are, or as anything might be."""
    shape = _upright(points, points, mean)
    if len(habits) and random.random() < settings.habits:
        shape = shape + random.uniform(0.2, 1.2) * habits[int(random.integers(len(habits)))]
    else:
        shape = _distorted(shape, shapes[int(random.integers(len(shapes)))], settings, random)
    turn, zoom = random.normal(0, settings.turn), np.exp(random.normal(0, settings.zoom))
    matrix = zoom * np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    centre = shape.mean(axis=0)
    placed = (shape - centre) @ matrix.T + centre + random.normal(0, settings.shift, 2)
    return moved(placed, inverse(similarity(points, mean)))


def _distorted(shape: Floats, other: Floats, settings: DescentTrainSettings, random: Random) -> Floats:
    """Part of another's shape, and each feature displaced, stretched and rough."""
    shape = shape + random.uniform(0, 1) * (other - shape)
    for group in GROUPS:
        middle = shape[group].mean(axis=0)
        stretch = np.exp(random.normal(0, settings.stretch, 2))
        shape[group] = middle + random.normal(0, settings.group, 2) + stretch * (shape[group] - middle)
    rough: Floats = shape + random.normal(0, settings.point, shape.shape)
    return rough


def _step(
    pictures: Sequence[Pictures],
    truths: Sequence[Floats],
    at: Sequence[Floats],
    mean: Floats,
    look: Look,
    settings: DescentTrainSettings,
) -> tuple[Step, list[Floats]]:
    """Ridge regression from what is seen to the move that is still missing, and where it leads."""
    affines = [similarity(points, look.place(mean)) for points in at]
    views, moves = [], []
    for picture, truth, points, affine in zip(pictures, truths, at, affines, strict=True):
        views.append(view(picture, points, affine, look))
        moves.append((moved(truth, affine) - moved(points, affine)).ravel() / look.unit_px)
    seen, missing = np.stack(views), np.stack(moves)
    middle, mean_move = seen.mean(axis=0), missing.mean(axis=0)
    weights = _ridge(seen - middle, missing - mean_move, settings.ridge)
    left, strength, right = np.linalg.svd(weights, full_matrices=False)
    basis = (left * strength)[:, : settings.rank].astype(np.float32)
    mix = right[: settings.rank].astype(np.float32)
    step = Step(look, basis, mix, (mean_move - middle @ basis @ mix).astype(np.float32))
    return step, [stepped(*each, step) for each in zip(at, affines, views, strict=True)]


def _ridge(seen: NDArray[np.float32], missing: Floats, penalty: float) -> Floats:
    """Weights (views, 136); solved over the starts, of which there are fewer than views."""
    gram = (seen @ seen.T).astype(np.float64)
    gram[np.diag_indices(len(gram))] += penalty * len(gram)
    return np.asarray(seen.T @ np.linalg.solve(gram, missing).astype(np.float32), np.float64)
