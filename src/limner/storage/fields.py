"""A type of ``limner.types`` goes in; its fields, JSON, npz or a file come out; and back."""

from __future__ import annotations

import dataclasses
import json
import typing
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from limner.errors import BadInput
from limner.storage.files import read_bytes, write_whole
from limner.storage.npz import pack_npz, unpack_npz
from limner.types import Drawing, EdgeMap, Face, JointTrajectory, Page, Pen, PenPath, Photo, Strokes


class _Fields(typing.Protocol):
    """Whatever is a dataclass."""

    __dataclass_fields__: typing.ClassVar[dict[str, Any]]


T = TypeVar("T", bound=_Fields)

STORED = (Photo, Face, EdgeMap, Strokes, Drawing, PenPath, JointTrajectory)
"""The types that can be saved and loaded."""

_LINES = ("lines_px", "lines_mm")
_OBJECTS = ("page", "pens")


def to_fields(value: Any) -> Any:
    """Plain lists, numbers and texts of a type, as they stand in JSON."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {field.name: to_fields(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, tuple):
        return [to_fields(item) for item in value]
    return value


def _type_of(fields: Any) -> str:
    """Which type that is stored has these fields; nothing if none."""
    if not isinstance(fields, Mapping):
        return ""
    names = [kind.__name__ for kind in STORED if set(fields) == {field.name for field in dataclasses.fields(kind)}]
    return f"a {names[0]}" if names else ""


def from_fields(kind: type[T], fields: Any) -> T:
    """The type from what ``to_fields`` gave.

    Raises:
        BadInput: a field is missing, unknown, or has another shape.
    """
    names = [field.name for field in dataclasses.fields(kind)]
    known = {*names, "pen"} if kind is Drawing else set(names)
    if not isinstance(fields, Mapping) or not set(fields) <= known:
        unknown = sorted(set(map(str, fields)) - known) if isinstance(fields, Mapping) else type(fields).__name__
        got = _type_of(fields) or unknown
        raise BadInput(f"{kind.__name__}: expected an object with {', '.join(names)}; got {got}")
    given = dict(fields)
    if kind is Drawing and "pen" in given:  # as drawings of one pen were once stored
        given["pens"] = [given.pop("pen")]
    if "page" in given:
        given["page"] = from_fields(Page, given["page"])
    if isinstance(given.get("pens"), list):
        given["pens"] = tuple(from_fields(Pen, pen) for pen in given["pens"])
    try:
        return kind(**given)
    except (TypeError, ValueError, AttributeError, OverflowError) as error:
        raise BadInput(f"{kind.__name__}: {error}; expected the fields {', '.join(names)}") from error


def to_json(value: Any) -> str:
    """One JSON object of the type's fields."""
    return json.dumps(to_fields(value), allow_nan=False)


def from_json(kind: type[T], text: str | bytes) -> T:
    """The type from JSON text.

    Raises:
        BadInput: no JSON, or not of this type.
    """
    return from_fields(kind, _json(text, kind.__name__))


def _json(text: str | bytes, name: str) -> Any:
    try:
        return json.loads(text)
    except (ValueError, RecursionError) as error:
        raise BadInput(f"{name}: not JSON ({error})") from error


def to_npz(value: Any) -> bytes:
    """The fields as npz, lines as one array with their ends; the same value gives the same bytes."""
    arrays: dict[str, Any] = {}
    for field in dataclasses.fields(value):
        item = getattr(value, field.name)
        if field.name in _LINES:
            arrays[field.name] = np.concatenate([np.empty((0, 2)), *item])
            arrays[f"{field.name}.end"] = np.cumsum([len(line) for line in item], dtype=np.int64)
        elif field.name in _OBJECTS:
            arrays[field.name] = np.array(json.dumps(to_fields(item)))
        else:
            arrays[field.name] = np.array(item if not isinstance(item, tuple) or item else np.empty(0, "U1"))
    return pack_npz(arrays)


def from_npz(kind: type[T], data: bytes) -> T:
    """The type from what ``to_npz`` gave.

    Raises:
        BadInput: no npz, or not of this type.
    """
    arrays = unpack_npz(data, kind.__name__)
    fields: dict[str, Any] = {}
    for key, array in arrays.items():
        if key.endswith(".end"):
            continue
        if key in _LINES:
            ends = arrays.get(f"{key}.end", np.empty(0, np.int64))
            if ends.ndim != 1 or ends.dtype.kind != "i" or array.ndim != 2:
                raise BadInput(f"{kind.__name__}: {key} and {key}.end are not lines and their ends")
            fields[key] = tuple(np.split(array, ends[:-1]) if len(ends) else ())
        elif key in (*_OBJECTS, "pen"):
            fields[key] = _json(str(array), f"{kind.__name__}.{key}") if array.ndim == 0 else {}
        elif array.dtype.kind == "U":
            fields[key] = tuple(array.tolist()) if array.ndim else str(array)
        else:
            fields[key] = array if array.ndim else array.item()
    return from_fields(kind, fields)


def save(value: Any, path: str | Path) -> None:
    """Save a type as ``.json`` or ``.npz``, by the path's suffix.

    Raises:
        BadInput: another suffix, or the file cannot be written.
    """
    suffix = Path(path).suffix.lower()
    if suffix == ".json":
        write_whole(path, (to_json(value) + "\n").encode())
    elif suffix == ".npz":
        write_whole(path, to_npz(value))
    else:
        raise BadInput(f"{path}: cannot save as '{suffix}'; choose .json or .npz")


def load(kind: type[T], path: str | Path) -> T:
    """Load a type from ``.json`` or ``.npz``.

    Raises:
        BadInput: another suffix, unreadable, or not of this type.
    """
    if kind not in STORED:
        raise BadInput(f"{typing.cast(Any, kind).__name__}: cannot be loaded; expected a type of limner.types")
    suffix = Path(path).suffix.lower()
    if suffix not in (".json", ".npz"):
        raise BadInput(f"{path}: cannot load '{suffix}'; expected .json or .npz")
    data = read_bytes(path)
    return from_json(kind, data) if suffix == ".json" else from_npz(kind, data)
