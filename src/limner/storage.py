"""Files: written whole or not at all; every type to and from JSON and npz."""

from __future__ import annotations

import contextlib
import dataclasses
import io
import json
import math
import os
import re
import tempfile
import typing
import zipfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from limner.errors import BadInput, LimnerError
from limner.types import Drawing, EdgeMap, Face, JointTrajectory, Page, Pen, PenPath, Photo, Strokes


class _Fields(typing.Protocol):
    """Whatever is a dataclass."""

    __dataclass_fields__: typing.ClassVar[dict[str, Any]]


T = TypeVar("T", bound=_Fields)

STORED = (Photo, Face, EdgeMap, Strokes, Drawing, PenPath, JointTrajectory)
"""The types that can be saved and loaded."""


def write_whole(path: str | Path, data: bytes) -> None:
    """Write ``data`` beside ``path``, then rename: a reader never sees half a file.

    Raises:
        BadInput: the folder is missing, read-only, or full.
    """
    path = Path(path)
    beside = None
    try:
        handle, beside = tempfile.mkstemp(prefix=f".{path.name[:40]}.", suffix=".part", dir=path.parent)
        with os.fdopen(handle, "wb") as file:
            file.write(data)
            os.fchmod(file.fileno(), 0o666 & ~_umask()) if hasattr(os, "fchmod") else None
        os.replace(beside, path)
    except OSError as error:
        if beside is not None:
            with contextlib.suppress(OSError):
                os.unlink(beside)
        raise BadInput(f"{path}: cannot be written ({error.strerror or error}); choose another place") from error


@contextlib.contextmanager
def whole(path: str | Path) -> Iterator[Path]:
    """A place beside ``path`` to write a file or a folder at, which then takes the place of what is at ``path``.

    Raises:
        BadInput: the folder around it is missing, read-only, or full; what was at ``path`` is still there.
    """
    path = Path(path)
    try:
        with tempfile.TemporaryDirectory(prefix=f".{path.name[:40]}.", suffix=".part", dir=path.parent) as folder:
            made = Path(folder) / path.name
            yield made
            if path.is_dir():
                # A folder with something in it cannot be renamed over.
                os.rename(path, Path(folder) / "old")
            os.replace(made, path)
    except OSError as error:
        raise BadInput(f"{path}: cannot be written ({error.strerror or error}); choose another place") from error


def make_folder(path: str | Path) -> Path:
    """The folder, made with those around it where it is not there yet.

    Raises:
        BadInput: it cannot be made.
    """
    folder = Path(path)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadInput(f"{path}: no folder can be made there ({error.strerror}); choose another") from error
    return folder


def _umask() -> int:
    mask = os.umask(0o022)
    os.umask(mask)
    return mask


def read_bytes(path: str | Path, limit: int = 512 * 2**20) -> bytes:
    """The whole file.

    Raises:
        BadInput: it cannot be read or is larger than ``limit`` bytes.
    """
    try:
        with open(path, "rb") as file:
            data = file.read(limit + 1)
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise BadInput(f"{path}: cannot be read ({reason or error})") from error
    if len(data) > limit:
        raise BadInput(f"{path}: larger than {limit // 2**20} MB, the limit for such a file")
    return data


def to_fields(value: Any) -> Any:
    """Plain lists, numbers and texts of a type, as they stand in JSON."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {field.name: to_fields(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, tuple):
        return [to_fields(item) for item in value]
    return value


def from_fields(kind: type[T], fields: Any) -> T:
    """The type from what ``to_fields`` gave.

    Raises:
        BadInput: a field is missing, unknown, or has another shape.
    """
    names = [field.name for field in dataclasses.fields(kind)]
    known = {*names, "pen"} if kind is Drawing else set(names)
    if not isinstance(fields, Mapping) or not set(fields) <= known:
        unknown = sorted(set(map(str, fields)) - known) if isinstance(fields, Mapping) else type(fields).__name__
        raise BadInput(f"{kind.__name__}: expected an object with {', '.join(names)}; got {unknown}")
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


def pack_npz(arrays: Mapping[str, Any]) -> bytes:
    """An npz archive of the arrays; the same arrays give the same bytes (no time stamps)."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, array in arrays.items():
            buffer = io.BytesIO()
            np.lib.format.write_array(buffer, np.asanyarray(array), allow_pickle=False)
            archive.writestr(zipfile.ZipInfo(f"{name}.npy"), buffer.getvalue(), zipfile.ZIP_DEFLATED)
    return out.getvalue()


def unpack_npz(data: bytes, name: str = "npz", limit: int = 2**30) -> dict[str, Any]:
    """The arrays of an npz archive; nothing in it is ever executed.

    Raises:
        BadInput: no such archive, an object array, or more than ``limit`` bytes when unpacked.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            members = archive.infolist()
            if sum(info.file_size for info in members) > limit:
                raise BadInput(f"{name}: unpacks to more than {limit // 2**20} MB, the limit")
            # Others pack a gigabyte into a kilobyte, and numpy writes none of them.
            if not {info.compress_type for info in members} <= {zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED}:
                raise BadInput(f"{name}: is packed in a way that numpy does not write; save it again")
            return {info.filename.removesuffix(".npy"): _array(archive.read(info)) for info in members}
    except LimnerError:
        raise
    except Exception as error:  # damaged archives make zipfile raise errors of many kinds
        raise BadInput(f"{name}: not a readable npz file ({error})") from error


_HEADER = re.compile(
    rb"\{'descr': '([<>|][biufU]\d{1,9})', 'fortran_order': (True|False), 'shape': \(([\d, ]*)\), \}\s*"
)


def _array(content: bytes) -> NDArray[Any]:
    """The array in an npy file (NumPy's NEP 1) of numbers or texts.

    Raises:
        ValueError: it is damaged, holds something else, or is not as long as it says.
    """
    start = 10 if content[6:7] == b"\x01" else 12
    end = start + int.from_bytes(content[8:start], "little")
    found = _HEADER.fullmatch(content[start:end])
    if content[:6] != b"\x93NUMPY" or found is None:
        raise ValueError("holds something else than plain arrays")
    dtype, shape = np.dtype(found[1].decode()), tuple(map(int, found[3].replace(b",", b" ").split()))
    if math.prod(shape) * dtype.itemsize != len(content) - end:
        raise ValueError("an array is not as long as it says")
    order: Literal["F", "C"] = "F" if found[2] == b"True" else "C"
    array = np.ndarray(shape, dtype, content, end, order=order).copy()
    if dtype.kind == "U" and array.nbytes and array.reshape(-1).view(f"{dtype.str[0]}u4").max() > 0x10FFFF:
        raise ValueError("a text is damaged")
    return array.view(np.uint8) != 0 if dtype.kind == "b" else array


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


_LINES = ("lines_px", "lines_mm")
_OBJECTS = ("page", "pens")


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
