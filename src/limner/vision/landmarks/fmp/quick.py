"""A picture and a model go in; the faces that a search everywhere would find come out, with a fraction of the work.

Stiff templates propose where a face may be. There, and only there, all parts are matched, in the same cells and with
the same sums as in the whole search, on to the neighbouring level or view as long as the score grows. When several of
the likeliest places in a row hold no face, the rest is not looked at.

All of it is done one thing after the other: maps this small take less time than two threads lose waiting for each
other between the many short steps, and the second thread would mostly look at places that then need no look.
"""

from __future__ import annotations

import functools
import itertools
from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike, NDArray

from limner.types import Floats
from limner.vision.landmarks.fmp.coarse import Proposal, Templates, distinct
from limner.vision.landmarks.fmp.hog import Array
from limner.vision.landmarks.fmp.inference import EVERYTHING, Detection, SearchSettings, suppress
from limner.vision.landmarks.fmp.matching import Forest
from limner.vision.landmarks.fmp.model import FmpModel
from limner.vision.landmarks.fmp.pyramid import (
    FILTER,
    PAD,
    Scaled,
    padded_size,
    part_of,
    scaled_pictures,
    wanted_steps,
)
from limner.vision.landmarks.fmp.response import responses
from limner.vision.landmarks.fmp.threads import one_thread

_PATIENCE = 4
"""So many proposals in a row that hold no face end the search."""

_MOST = 50
"""Proposals that are looked at, at most."""

_PER_OCTAVE = 2
"""Levels per octave on which the templates look."""

_MARGIN_CELLS = 8
"""How far beyond its place at rest a part may be at first; where it touches that, it may go as far again."""

_WIDENINGS = 3
"""So often at most."""

_NEAR_DEG = 20.0
"""Views so close to each other are compared."""

_FAR_DEG = 35.0
"""Views so close to each other are compared, on neighbouring levels too, where a face is found."""

_HOPEFUL = 0.4
"""From a place is climbed on if its score lies so far on the way from that of the usual proposal to the threshold."""


def search_quickly(
    image: Array, model: FmpModel, settings: SearchSettings = EVERYTHING, most: int | None = None
) -> list[Detection]:
    """``inference.search`` for faces that stand out: same result on them; the search ends at the ``most``-th."""
    places = _Places(image, model, settings)
    with one_thread():
        faces = list(itertools.islice(places.faces(settings.least_score(model), settings.overlap), most))
    return suppress(faces, image.shape[:2], settings.overlap)


class _Places:
    """Looks for a model's faces at single places of a picture's pyramid."""

    def __init__(self, image: Array, model: FmpModel, settings: SearchSettings) -> None:
        self._model, self._interval = model, settings.levels_per_octave(model)
        self._dtype = np.dtype(settings.dtype)
        self._steps = wanted_steps(image.shape[:2], self._interval, model.cell_px, settings.scale_range_px)
        pictures = scaled_pictures(np.asarray(image, self._dtype), self._interval, self._steps)
        self._pictures = {scaled.step: scaled for scaled in pictures}
        self._templates = Templates.of(model, self._dtype)
        self._forest = functools.cache(lambda view: Forest([model.components[view]]))

    def faces(self, threshold: float, overlap: float) -> Iterator[Detection]:
        """The best configuration at each proposal that holds a face and lies on no other."""
        found: list[Floats] = []
        failed = 0
        proposals = self._proposals()
        usual = float(np.median([proposal.score for proposal in proposals])) if proposals else threshold
        hopeful = threshold - (1 - _HOPEFUL) * max(0.0, threshold - usual)
        for proposal in proposals:
            if _covered(proposal.box_px, found, overlap):
                continue
            face = self._climb(proposal, hopeful, threshold)
            new = face is not None and not _covered(face.box, found, overlap)
            failed = 0 if new else failed + 1
            if face is not None:
                found.append(face.box)
                yield face
            if failed == _PATIENCE:
                return

    def _proposals(self) -> list[Proposal]:
        stride = max(1, round(self._interval / _PER_OCTAVE))
        some = sorted({*self._steps[::stride], *self._steps[-1:]})
        return distinct([place for step in some for place in self._templates.propose(self._pictures[step])], _MOST)

    def _climb(self, proposal: Proposal, hopeful: float, threshold: float) -> Detection | None:
        """The best configuration from a proposal on, each level and view from the best root so far."""
        looked = {(proposal.step, proposal.view)}
        best = self._look(proposal.step, proposal.view, np.array(proposal.root_px), hopeful)
        while best and (ahead := [near for near in self._near(best, threshold) if near not in looked]):
            looked.add(ahead[0])
            best = self._look(*ahead[0], best.points_px[0], best.score) or best
        return best if best and best.score >= threshold else None

    def _near(self, found: Detection, threshold: float) -> Iterator[tuple[int, int]]:
        """The levels and views next to that of a configuration; more where it is a face."""
        step, components = found.level - self._interval - 1, self._model.components
        face = found.score >= threshold
        yield from ((near, found.component) for near in (step + 1, step - 1) if near in self._steps)
        for view, component in enumerate(components):
            turn = abs(component.yaw_deg - components[found.component].yaw_deg)
            if turn <= (_FAR_DEG if face else _NEAR_DEG):
                yield from (
                    (near, view)
                    for near in (step, step + 1, step - 1)
                    if near in self._steps and (face or near == step)
                )

    def _look(self, step: int, view: int, root_px: Floats, least: float) -> Detection | None:
        """The best configuration of a view on a level around a root, if its score is above the least."""
        picture, box = self._pictures[step], self._templates.boxes[view]
        cell = (root_px - picture.corner_px) / (self._model.cell_px * picture.pixel_px)
        root = np.rint(cell - (1 - PAD + FILTER / 2)).astype(np.int64)
        low, high = root + box[:2], root + box[2:]
        size = padded_size(picture, self._model.cell_px)
        for _ in range(_WIDENINGS):
            first, last = np.clip(low - _MARGIN_CELLS, 0, size), np.clip(high + _MARGIN_CELLS, 0, size)
            if (last - first < FILTER).any():
                return None
            found = self._match(picture, view, first, last, least)
            if found is None:
                return None
            low, high = found.cells.min(axis=0), found.cells.max(axis=0) + FILTER
            if ((low > first) | (first == 0)).all() and ((high < last) | (last == size)).all():
                break
        return found

    def _match(
        self, picture: Scaled, view: int, first: NDArray[np.int64], last: NDArray[np.int64], least: float
    ) -> Detection | None:
        """The best configuration inside a box of cells, if its score is above the least."""
        level = part_of(picture, self._interval, self._model.cell_px, self._dtype, (first, last))
        fits = responses(level.features, self._model.filters[self._model.components[view].filters])
        match = self._forest(view).match(fits)
        roots = match.roots[0]
        y, x = np.unravel_index(int(roots.argmax()), roots.shape)
        if roots[y, x] <= least:
            return None
        cells = match.places(0, np.array([[x, y]]))[0]
        points = level.centres_px(cells)
        return Detection(float(roots[y, x]), view, level.index, level.scale_px, cells + first, points)


def _covered(box: ArrayLike, faces: list[Floats], overlap: float) -> bool:
    """Whether one of the faces' boxes shares more than ``overlap`` of its area, or of the box's, with it."""
    box = np.asarray(box)
    for face in faces:
        shared = np.clip(np.minimum(box[2:], face[2:]) - np.maximum(box[:2], face[:2]), 0, None).prod()
        if shared > overlap * min((box[2:] - box[:2]).prod(), (face[2:] - face[:2]).prod()):
            return True
    return False
