"""A model file goes in, a checked flexible mixture of parts comes out, and the other way round."""

from __future__ import annotations

import functools
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from limner.errors import BadInput
from limner.storage import pack_npz, read_bytes, unpack_npz, write_whole
from limner.types import Floats, Value, frozen_array
from limner.vision.landmarks.fmp.hog import CHANNELS
from limner.vision.landmarks.fmp.pyramid import FILTER

FORMAT = "limner-fmp-1"
"""Stands in every model file; raised when the fields change."""

SHIPPED = "frontal.npz"
"""The model inside the package."""

_MOST_PARTS = 256
_MOST_COMPONENTS = 64
_MOST_FILTERS = 4096
_LARGEST = 1e4
_FILE_LIMIT = 64 * 2**20


@dataclass(frozen=True, eq=False)
class Component(Value):
    """One tree of parts: the face as seen from one side (thesis 3.2.1).

    The cost of a part at cell ``c`` when its parent is at cell ``p`` is
    ``ax dx^2 + bx dx + ay dy^2 + by dy`` with ``d = p + anchor - c``, all in cells of one level.

    Attributes:
        yaw_deg: turn of the head; positive = the nose points to image right.
        bias: added to every score of this component.
        parents: (n,) index of each part's parent, less than its own; -1 for the root, which is part 0.
        filters: (n,) which filter of the model's pool each part has.
        springs: (n, 4) ax, bx, ay, by of each part to its parent, ax and ay > 0; the root's row is 0.
        anchors: (n, 2) whole cells x, y from the parent to where the part is expected (0-based: 0, 0 is the same
            cell); the root's row is 0.
        landmarks: (n,) which landmark each part is, in iBUG-68 (68 parts) or MultiPIE-39 order (39 parts), 0-based.
    """

    yaw_deg: float
    bias: float
    parents: NDArray[np.int64]
    filters: NDArray[np.int64]
    springs: Floats
    anchors: NDArray[np.int64]
    landmarks: NDArray[np.int64]

    def __post_init__(self) -> None:
        for name in ("yaw_deg", "bias"):
            self._freeze(name, float(frozen_array(getattr(self, name), np.float64, (), f"Component.{name}")))
        self._freeze("parents", _whole(self.parents, (None,), "Component.parents"))
        n = len(self.parents)
        if not 1 <= n <= _MOST_PARTS:
            raise BadInput(f"Component: expected 1 to {_MOST_PARTS} parts, got {n}")
        for name, shape in (("filters", (n,)), ("anchors", (n, 2)), ("landmarks", (n,))):
            self._freeze(name, _whole(getattr(self, name), shape, f"Component.{name}"))
        self._freeze("springs", frozen_array(self.springs, np.float64, (n, 4), "Component.springs"))
        self._check()

    def _check(self) -> None:
        if abs(self.yaw_deg) > 180 or abs(self.bias) > _LARGEST:
            raise BadInput(f"Component: yaw {self.yaw_deg:g}, bias {self.bias:g}; expected up to 180, {_LARGEST:g}")
        children = np.arange(1, len(self.parents))
        if self.parents[0] != -1 or not ((self.parents[1:] >= 0) & (self.parents[1:] < children)).all():
            raise BadInput("Component.parents: expected -1 first, then for each part one that stands before it")
        if not np.array_equal(np.sort(self.landmarks), np.arange(len(self.parents))):
            raise BadInput(f"Component.landmarks: expected each of 0 to {len(self.parents) - 1} once")
        if (self.springs[1:, ::2] <= 0).any():
            raise BadInput("Component.springs: expected ax and ay above 0 for every part but the root")
        if np.abs(self.springs).max() > _LARGEST or np.abs(self.anchors).max() > _LARGEST:
            raise BadInput(f"Component: expected springs and anchors between -{_LARGEST:g} and {_LARGEST:g}")
        if self.springs[0].any() or self.anchors[0].any():
            raise BadInput("Component: the root (part 0) has no spring; expected zeros in springs[0] and anchors[0]")

    @property
    def rest_cells(self) -> Floats:
        """(n, 2) where each part lies when no spring is under load, x, y from the root [cells]."""
        rest = np.zeros((len(self.parents), 2))
        for i in range(1, len(rest)):
            ax, bx, ay, by = self.springs[i]
            rest[i] = rest[self.parents[i]] + self.anchors[i] + (bx / (2 * ax), by / (2 * ay))
        return rest


@dataclass(frozen=True, eq=False)
class FmpModel(Value):
    """A flexible mixture of parts: a pool of filters and one tree of parts for each view.

    Attributes:
        filters: (F, 5, 5, 32) y, x, HOG channel; float32 or float64.
        components: the views.
        threshold: scores below are no face.
        interval: levels per octave at which the model is meant to search.
        cell_px: side of a HOG cell [px].
        name: of the model.
        meta: what made it: data and credits, settings, measured numbers; anything that JSON can hold.
    """

    filters: NDArray[np.floating[Any]]
    components: tuple[Component, ...]
    threshold: float
    interval: int = 5
    cell_px: int = 4
    name: str = "unnamed"
    meta: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        dtype = np.float32 if getattr(self.filters, "dtype", None) == np.float32 else np.float64
        shape = (None, FILTER, FILTER, CHANNELS)
        self._freeze("filters", frozen_array(self.filters, dtype, shape, "FmpModel.filters"))
        self._freeze("components", tuple(self.components))
        self._freeze("threshold", float(frozen_array(self.threshold, np.float64, (), "FmpModel.threshold")))
        if abs(self.threshold) > _LARGEST:
            raise BadInput(f"FmpModel.threshold: {self.threshold:g}, expected -{_LARGEST:g} to {_LARGEST:g}")
        if not 1 <= len(self.filters) <= _MOST_FILTERS or np.abs(self.filters).max() > _LARGEST:
            raise BadInput(f"FmpModel.filters: expected 1 to {_MOST_FILTERS} with values up to {_LARGEST:g}")
        if not 1 <= len(self.components) <= _MOST_COMPONENTS:
            raise BadInput(f"FmpModel: expected 1 to {_MOST_COMPONENTS} components, got {len(self.components)}")
        for component in self.components:
            if component.filters.min() < 0 or component.filters.max() >= len(self.filters):
                raise BadInput(f"Component.filters: expected indices from 0 to {len(self.filters) - 1}")
        for name, high in (("interval", 100), ("cell_px", 64)):
            value = getattr(self, name)
            if type(value) is not int or not 1 <= value <= high:
                raise BadInput(f"FmpModel.{name}: expected a whole number from 1 to {high}, got {value!r}")

    @property
    def face_cells(self) -> float:
        """The longer side of the box around all parts of a face in its rest shape, smallest of the views [cells]."""
        return min(float(np.ptp(component.rest_cells, axis=0).max()) for component in self.components) + FILTER

    @property
    def smallest_face_px(self) -> float:
        """The smallest face (longer side of its box) that can be found without enlarging the picture [px]."""
        return self.face_cells * self.cell_px


def save_model(model: FmpModel, path: str | Path) -> None:
    """Write the model as npz; the same model gives the same bytes.

    Raises:
        BadInput: the file cannot be written.
    """
    write_whole(path, pack_model(model))


def pack_model(model: FmpModel) -> bytes:
    """The model as the bytes of an npz file: the parts of all components one after another."""
    parts = model.components
    arrays: dict[str, ArrayLike] = {
        "format": np.array(FORMAT),
        "name": np.array(model.name),
        "meta": np.array(json.dumps(dict(model.meta), sort_keys=True, allow_nan=False)),
        "threshold": np.float64(model.threshold),
        "interval": np.int64(model.interval),
        "cell_px": np.int64(model.cell_px),
        "filters": model.filters,
        "sizes": np.array([len(part.parents) for part in parts], np.int64),
        "yaw_deg": np.array([part.yaw_deg for part in parts]),
        "bias": np.array([part.bias for part in parts]),
    }
    arrays |= {f"parts.{name}": np.concatenate([getattr(part, name) for part in parts]) for name in _PER_PART}
    return pack_npz(arrays)


_PER_PART = ("parents", "filters", "springs", "anchors", "landmarks")
_KINDS = {"format": "U", "name": "U", "meta": "U", "threshold": "f", "interval": "i", "cell_px": "i", "filters": "f"}
_KINDS |= {"sizes": "i", "yaw_deg": "f", "bias": "f", "parts.springs": "f"}
_KINDS |= {f"parts.{name}": "i" for name in _PER_PART if name != "springs"}
_SCALARS = ("format", "name", "meta", "threshold", "interval", "cell_px")


def load_model(path: str | Path) -> FmpModel:
    """Read a model file.

    Raises:
        BadInput: unreadable, damaged, or no such model.
    """
    return unpack_model(read_bytes(path, _FILE_LIMIT), str(path))


def unpack_model(data: bytes, name: str = "model") -> FmpModel:
    """The model from what ``pack_model`` gave.

    Args:
        data: bytes of an npz file.
        name: of the file, for messages.

    Raises:
        BadInput: damaged, or no such model.
    """
    arrays = unpack_npz(data, name, 4 * _FILE_LIMIT)
    for key, kind in _KINDS.items():
        if key not in arrays or arrays[key].dtype.kind != kind or (arrays[key].ndim != 0 and key in _SCALARS):
            raise BadInput(f"{name}: not a face model: '{key}' is missing or of another kind; expected {FORMAT}")
    if str(arrays["format"]) != FORMAT:
        raise BadInput(f"{name}: a face model of format '{arrays['format']!s:.40}'; expected {FORMAT}")
    try:
        meta = json.loads(str(arrays["meta"]))
    except (ValueError, RecursionError) as error:
        raise BadInput(f"{name}: the model's description is not JSON ({error})") from error
    if not isinstance(meta, dict):
        raise BadInput(f"{name}: the model's description is {type(meta).__name__}; expected a JSON object")
    try:
        return FmpModel(
            filters=arrays["filters"],
            components=_components(arrays),
            threshold=float(arrays["threshold"]),
            interval=int(arrays["interval"]),
            cell_px=int(arrays["cell_px"]),
            name=str(arrays["name"]),
            meta=meta,
        )
    except BadInput as error:
        raise BadInput(f"{name}: damaged face model ({error})") from error


def _components(arrays: Mapping[str, NDArray[Any]]) -> tuple[Component, ...]:
    sizes = arrays["sizes"]
    if sizes.ndim != 1 or not 1 <= len(sizes) <= _MOST_COMPONENTS or sizes.min() < 1 or sizes.max() > _MOST_PARTS:
        raise BadInput(f"sizes: expected 1 to {_MOST_COMPONENTS} numbers from 1 to {_MOST_PARTS}")
    for name in _PER_PART:
        if arrays[f"parts.{name}"].shape[:1] != (sizes.sum(),):
            raise BadInput(f"parts.{name}: expected {sizes.sum()} rows, got shape {arrays[f'parts.{name}'].shape}")
    for name in ("yaw_deg", "bias"):
        if arrays[name].shape != sizes.shape:
            raise BadInput(f"{name}: expected {len(sizes)} numbers, got shape {arrays[name].shape}")
    ends = np.cumsum(sizes)[:-1]
    columns = {name: np.split(arrays[f"parts.{name}"], ends) for name in _PER_PART}
    return tuple(
        Component(
            yaw_deg=float(arrays["yaw_deg"][k]),
            bias=float(arrays["bias"][k]),
            **{name: column[k] for name, column in columns.items()},
        )
        for k in range(len(sizes))
    )


def _whole(value: ArrayLike, shape: tuple[int | None, ...], name: str) -> NDArray[np.int64]:
    array = np.asarray(value)
    if array.dtype.kind not in "iu":
        raise BadInput(f"{name}: expected whole numbers, got {array.dtype}")
    return frozen_array(array, np.int64, shape, name)


@functools.cache
def default_model() -> FmpModel:
    """The model inside the package.

    Raises:
        BadInput: this installation lacks it.
    """
    file = resources.files(__package__) / SHIPPED
    if not file.is_file():
        raise BadInput(f"face model: {SHIPPED} is not in this installation; train one with `limner train`")
    return unpack_model(file.read_bytes(), SHIPPED)
