"""A file of landmarks placed by hand or found before (.json, .pts, .csv) goes in, faces come out, largest first."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from limner.errors import BadInput
from limner.storage import from_fields, read_bytes
from limner.types import Face, frozen_array

NAME = "file"
_FILE_LIMIT = 16 * 2**20
_FARTHEST_PX = 1e6


def read_faces(path: str | Path) -> tuple[Face, ...]:
    """Read landmarks.

    ``.json`` is what ``limner face --json`` prints, or one saved face. ``.pts`` is iBUG's format, in which the first
    pixel is 1, 1. ``.csv`` has one landmark ``x,y`` a line, perhaps under a heading, the first pixel 0, 0.

    Raises:
        BadInput: unreadable, another format, or no landmarks in it.
    """
    readers: dict[str, Callable[[str], tuple[Face, ...]]] = {".json": _json, ".pts": _pts, ".csv": _csv}
    if not str(path):
        raise BadInput("landmarks: no file given; name a .json (of `limner face`), .pts or .csv")
    suffix = Path(path).suffix.lower()
    if suffix not in readers:
        raise BadInput(f"{path}: cannot read landmarks from '{suffix}'; choose {', '.join(readers)}")
    try:
        faces = readers[suffix](read_bytes(path, _FILE_LIMIT).decode("utf-8-sig"))
        for face in faces:
            _check_range(face)
    except UnicodeDecodeError as error:
        raise BadInput(f"{path}: not a text file (byte {error.start} is no UTF-8)") from error
    except BadInput as error:
        raise error if str(error).startswith(str(path)) else BadInput(f"{path}: {error}") from error
    return tuple(sorted(faces, key=_area, reverse=True))


def _json(text: str) -> tuple[Face, ...]:
    try:
        content = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise BadInput(f"not JSON ({error})") from error
    if not isinstance(content, Mapping) or not {"faces", "points_px"} & set(content):
        raise BadInput("expected an object with 'faces', as `limner face --json` prints, or with 'points_px'")
    faces = content.get("faces", [content])
    if not isinstance(faces, list):
        raise BadInput(f"'faces': expected a list, got {type(faces).__name__}")
    return tuple(_from_object(face) for face in faces)


def _from_object(fields: Any) -> Face:
    if isinstance(fields, Mapping) and "points_px" in fields and "box_px" not in fields:
        return _face(fields["points_px"])
    return from_fields(Face, fields)


def _pts(text: str) -> tuple[Face, ...]:
    head, brace, rest = text.partition("{")
    body, end, after = rest.partition("}")
    if not brace or not end or after.strip():
        raise BadInput("not a .pts file: expected the points between { and }")
    known = dict(line.split(":", 1) for line in head.splitlines() if ":" in line)
    points = _rows(body.split("\n"), None)
    if known.get("n_points", "").strip() != str(len(points)):
        raise BadInput(f"not a .pts file: expected a line 'n_points: {len(points)}' for its {len(points)} points")
    return (_face(np.array(points) - 1),)


def _csv(text: str) -> tuple[Face, ...]:
    lines = text.splitlines()
    heading = bool(lines) and lines[0].replace(" ", "").lower() in ("x,y", "x_px,y_px")
    return (_face(_rows(lines[heading:], ",")),)


def _rows(lines: list[str], separator: str | None) -> list[tuple[float, float]]:
    rows = []
    for line in filter(str.strip, lines):
        try:
            x, y = line.split(separator)
            rows.append((float(x), float(y)))
        except ValueError as error:
            raise BadInput(f"expected two numbers, x and y, got '{line.strip():.40}'") from error
    return rows


def _face(points: Any) -> Face:
    points = frozen_array(points, np.float64, (None, 2), "landmarks")
    box = np.concatenate([points.min(axis=0), points.max(axis=0)]) if len(points) else np.array([0, 0, 1, 1])
    return Face(points, box, detector=NAME)


def _check_range(face: Face) -> None:
    farthest = max(np.abs(face.points_px).max(), np.abs(face.box_px).max())
    if farthest > _FARTHEST_PX:
        raise BadInput(f"landmarks: expected places up to {_FARTHEST_PX:g} px, got {farthest:g}")


def _area(face: Face) -> float:
    return float(np.prod(face.box_px[2:] - face.box_px[:2]))
