"""Faces, scenes and a first model in; weights that set them apart, better with every round, out."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from limner.types import Floats
from limner.vision.landmarks.fmp.latent import place
from limner.vision.landmarks.fmp.layout import Layout, features
from limner.vision.landmarks.fmp.mining import Negative, levels, mine
from limner.vision.landmarks.fmp.model import FmpModel
from limner.vision.landmarks.fmp.positives import Positive
from limner.vision.landmarks.fmp.scenes import Scene
from limner.vision.landmarks.fmp.solver import Problem, Report
from limner.vision.landmarks.fmp.train_settings import TrainSettings

Watch = Callable[[str, int, int, str], None]
"""Told of progress: what is being done, how much of it is done, of how much, and a few words."""


Share = Callable[[Callable[[Any], Any], Iterable[Any]], Iterable[Any]]
"""``map``, or what does the same by many processes; what it is given can be pickled."""


def silent(what: str, done: int, total: int, note: str) -> None:
    """Tell nobody."""


@dataclass(frozen=True)
class Round:
    """What one round of training reached.

    Attributes:
        faces, negatives: examples that the weights were solved for.
        new: how many of the negatives this round brought.
        worst: the highest score of what touches no face, before solving; None when all is far below the margin.
        solution: objective and duality gap.
    """

    faces: int
    negatives: int
    new: int
    worst: float | None
    solution: Report

    def to_dict(self) -> dict[str, Any]:
        """Plain values, the gap among them."""
        return dataclasses.asdict(self) | {"gap": self.solution.gap}


class Placed(NamedTuple):
    """Where an example's parts are.

    Attributes:
        source: number of the face or scene.
        level: of the scene's pyramid; 0 for a face.
        component: which mixture.
        cells: (n, 2) x, y of the parts.
    """

    source: int
    level: int
    component: int
    cells: NDArray[np.int64]


Found = list[tuple[int, Negative]]
"""Negatives, each with the number of its scene."""


class Examples:
    """The examples met so far, the faces first, and the model that they make.

    Attributes:
        model: so far.
        start: weights that the solution is drawn to (before the share ``prior`` is taken of them).
        placed: of each example.
        problem: their features and dual variables.
    """

    def __init__(
        self,
        model: FmpModel,
        faces: Sequence[Positive],
        scenes: Sequence[Scene],
        settings: TrainSettings,
        watch: Watch = silent,
        share: Share = map,
    ) -> None:
        self.model, self.faces, self.scenes, self.settings, self.watch = model, faces, scenes, settings, watch
        self.share = share
        self.layout = Layout.of(model.components)
        self.placed: list[Placed] = []
        self.start = self.layout.pack(model)
        self.problem = self._empty()

    def _empty(self) -> Problem:
        prior = self.start * self.settings.prior if self.settings.prior else None
        return Problem(self.layout.penalty(prior), self.layout.columns)

    def round(self, number: int) -> Round:
        """Place the faces, gather negatives, solve; the first round also sets the scale on which margins are 1."""
        placed = [self._best(face) for face in self.faces]
        if number == 0:
            right, middle = np.percentile([score for score, _ in placed], (_FACES_BELOW, 50)).tolist()
            spread = max(middle - right, abs(right) / 10, 1e-9)
            found = self._calibrate(right, spread, self._first(right, spread))
        else:
            found = self._gather(FLOOR, self._of_round(number))
        self._put_faces([place for _, place in placed])
        hard = found if number == 0 else [item for item in found if item[1].found.score >= -1]
        for scene, negative in hard:
            at = Placed(scene, negative.found.level, negative.found.component, negative.found.cells)
            self._put(at, negative.features, self._group(at))
        count, report = len(self.problem) - len(self.faces), self._solve()
        worst = max((negative.found.score for _, negative in found if negative.clear), default=None)
        return Round(len(self.faces), count, len(hard), worst, report)

    def face_scores(self) -> Floats:
        """Score of each face where it is placed best."""
        return np.array([self._best(face)[0] for face in self.faces])

    def restore(self, start: Floats, placed: Sequence[Placed], groups: Sequence[int], alpha: Floats) -> None:
        """Take up examples, their slacks and dual variables again, with their features computed anew."""
        self.start, count = start, len(self.faces)
        self.problem = self._empty()
        self._put_faces(placed[:count])
        self.watch("restored", 0, len(placed), "")
        held: dict[int, dict[int, NDArray[np.float32]]] = {}
        for k, at in enumerate(placed[count:]):
            if at.source not in held:
                held = {at.source: self._maps(at.source)}
            level = held[at.source][at.level]
            self._put(at, features(self.model.components[at.component], level, at.cells), groups[count + k])
            self.watch("restored", count + k + 1, len(placed), "")
        self.problem.alpha = alpha.copy()

    def _maps(self, scene: int) -> dict[int, NDArray[np.float32]]:
        maps, _ = levels(self.scenes[scene], self.settings.scene_px, self.settings.interval, self.settings.cell_px)
        return {level.index: level.features for level in maps}

    def _best(self, face: Positive) -> tuple[float, Placed]:
        """The best place for the mixture of the face's pose."""
        component = self.model.components[face.pose]
        score, cells = place(component, self.model.filters, face, self.settings.overlap)
        return score, Placed(0, 0, face.pose, cells)

    def _of_round(self, number: int) -> list[int]:
        """The scenes that a round looks through: others than those before, as long as there are."""
        count = min(self.settings.scenes, len(self.scenes))
        return [(number * count + k) % len(self.scenes) for k in range(count)]

    def _gather(self, floor: float, scenes: Sequence[int]) -> Found:
        settings, found = self.settings, Found()
        work = partial(_mined, model=self.model, floor=floor, settings=settings)
        mined = self.share(work, [self.scenes[k] for k in scenes])
        self.watch("negatives", 0, len(scenes), "0 found")
        for done, (k, new) in enumerate(zip(scenes, mined, strict=True)):
            self.watch("negatives", done, len(scenes), f"{len(found)} found")
            held = self.problem.megabytes + sum(negative.features.nbytes for _, negative in found) / 2**20
            if held > settings.memory_mb:
                break
            found += [(k, negative) for negative in new]
        self.watch("negatives", len(scenes), len(scenes), f"{len(found)} found")
        return found

    def _first(self, right: float, spread: float) -> Found:
        """What the first model, whose scores have any scale, takes for faces most: from the floor that finds enough."""
        some, floor = self._of_round(0)[::_PROBED], right
        for steps in _FIRST_STEPS:
            floor = right - steps * spread
            if len({scene for scene, _ in self._gather(floor, some)}) > len(some) / 2:
                break
        return self._gather(floor, self._of_round(0))

    def _calibrate(self, right: float, spread: float, found: Found) -> Found:
        """Scale the first model so that all but a few of the faces score 1 and the most face-like negative -1.

        Where these are too near to each other, or the wrong way round, the spread of the faces sets the scale.

        Args:
            right: score that all but a few of the faces reach.
            spread: from there to the median face.
            found: negatives.

        Returns:
            What was found, with the new scores.
        """
        wrong = max((negative.found.score for _, negative in found), default=right - spread)
        scale = 2 / max(right - wrong, spread / _SPREAD)
        components = tuple(
            dataclasses.replace(part, springs=part.springs * scale, bias=1 + (part.bias - right) * scale)
            for part in self.model.components
        )
        filters = (self.model.filters * scale).astype(np.float32)
        self.model = dataclasses.replace(self.model, filters=filters, components=components)
        self.start = self.layout.pack(self.model)
        self.problem = self._empty()
        return [(scene, negative.scored(1 + (negative.found.score - right) * scale)) for scene, negative in found]

    def _put_faces(self, placed: Sequence[Placed]) -> None:
        first = len(self.problem) == 0
        self.placed[: len(self.faces)] = placed
        cost = self.settings.cost * self.settings.positive_weight
        for k, (face, at) in enumerate(zip(self.faces, placed, strict=True)):
            row = features(self.model.components[at.component], face.features, at.cells)
            if first:
                self.problem.add(at.component, row, 1, k, cost)
            else:
                self.problem.replace(k, at.component, row, 1)

    def _put(self, at: Placed, row: NDArray[np.float32], group: int) -> None:
        self.placed.append(at)
        self.problem.add(at.component, row, -1, group, self.settings.cost)

    def _group(self, at: Placed) -> int:
        """Negatives with their root at one place of a scene share a slack."""
        first = len(self.faces)
        same = (k for k, other in enumerate(self.placed[first:], first) if _one_place(at, other))
        k = next(same, None)
        return max(self.problem.groups) + 1 if k is None else self.problem.groups[k]

    def _solve(self) -> Report:
        def tell(at: Report) -> None:
            self.watch("solution", 0, 1, f"objective {at.primal:.4g}, gap {at.gap:.3f}")

        report = self.problem.solve(self.settings.gap, seed=self.settings.seed, watch=tell)
        self.watch("solution", 1, 1, f"objective {report.primal:.4g}, gap {report.gap:.3f}")
        self.model = self.layout.unpack(self.problem.weights(), self.model)
        idle = (self.problem.alpha == 0) & (self.problem.lacks() < -_SAFE)
        idle[: len(self.faces)] = False
        self.problem.keep(~idle)
        self.placed = [at for at, drop in zip(self.placed, idle, strict=True) if not drop]
        return report


def _mined(scene: Scene, model: FmpModel, floor: float, settings: TrainSettings) -> list[Negative]:
    return mine(scene, model, floor, settings.scene_px, settings.interval, settings.per_scene)


_FACES_BELOW = 5
"""Percentage of the faces that may score below the margin of the first model."""

_FIRST_STEPS = (1.5, 3, 6, 12, 24)
"""Floors that the first search for negatives tries, below those faces, in their distances from the median face."""

_PROBED = 8
"""One scene of so many is searched to choose that floor."""

_SPREAD = 4
"""The median face scores at most twice as much above the margin."""

FLOOR = -2.0
"""Scenes are searched for what scores higher, to know how far what is no face stays below the margin."""

_SAFE = 0.5
"""A negative that is beyond its margin by this much and holds nothing up is forgotten."""


def _one_place(a: Placed, b: Placed) -> bool:
    return (a.source, a.level) == (b.source, b.level) and bool((a.cells[0] == b.cells[0]).all())
