"""Rows of figures, one for each photo, go in; the manifest as CSV, row by row, and as Parquet come out."""

from __future__ import annotations

import csv
import importlib
import io
import os
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, fields
from pathlib import Path

from limner.errors import BadInput, MissingExtra

CSV = "manifest.csv"
PARQUET = "manifest.parquet"


@dataclass(frozen=True)
class Row:
    """What became of one photo of the list.

    Attributes:
        photo: as named.
        hash: SHA-256 of its bytes; empty where they could not be read.
        drawing: name of the SVG in the output folder; photos of one content share it.
        faces: found in it; the largest is drawn.
        strokes, points: of the drawing.
        ink_mm, travel_mm: pen-down and pen-up length.
        seconds: that drawing it took.
        error: one line; empty where it was drawn.
    """

    photo: str
    hash: str = ""
    drawing: str = ""
    faces: int | None = None
    strokes: int | None = None
    points: int | None = None
    ink_mm: float | None = None
    travel_mm: float | None = None
    seconds: float | None = None
    error: str = ""


COLUMNS = tuple(field.name for field in fields(Row))
_WHOLE, _REAL = ("faces", "strokes", "points"), ("ink_mm", "travel_mm", "seconds")


class Manifest:
    """A CSV file that has whole rows only, at any time; a name that is no UTF-8 is written with escapes."""

    def __init__(self, path: Path, file: io.FileIO) -> None:
        self._path, self._file = path, file
        self._put(",".join(COLUMNS) + "\r\n")

    @classmethod
    @contextmanager
    def written(cls, path: Path) -> Iterator[Manifest]:
        """A new manifest in place of one that may be there.

        Raises:
            BadInput: it cannot be written.
        """
        with ExitStack() as held:
            try:
                file = held.enter_context(open(path, "wb", buffering=0))
            except OSError as error:
                raise BadInput(f"{path}: cannot be written ({error.strerror}); choose another place") from error
            yield cls(path, file)

    def add(self, row: Row) -> None:
        """Write a row.

        Raises:
            BadInput: it cannot be written; nothing of it is left.
        """
        text = io.StringIO()
        csv.writer(text).writerow(_written(getattr(row, name)) for name in COLUMNS)
        self._put(text.getvalue())

    def _put(self, text: str) -> None:
        at, data = self._file.tell(), text.encode(errors="backslashreplace")
        try:
            while data:
                data = data[self._file.write(data) :]
        except OSError as error:
            os.ftruncate(self._file.fileno(), at)
            raise BadInput(f"{self._path}: cannot be written ({error.strerror}); choose another place") from error


def _written(value: object) -> object:
    return f"{value:.3f}" if isinstance(value, float) else value


def check_parquet() -> None:
    """Say before any work that Parquet cannot be written.

    Raises:
        MissingExtra: pyarrow is not installed.
    """
    try:
        importlib.import_module("pyarrow.parquet")
    except ImportError as error:
        raise MissingExtra("--parquet", "cluster") from error


def to_parquet(folder: Path) -> Path:
    """The manifest of a folder as Parquet beside it; a block of rows in memory at a time.

    Raises:
        BadInput: it cannot be written.
    """
    import pyarrow as arrow
    from pyarrow import csv as arrow_csv, parquet

    kinds = dict.fromkeys(_WHOLE, arrow.int64()) | dict.fromkeys(_REAL, arrow.float64())
    convert = arrow_csv.ConvertOptions(
        column_types={name: kinds.get(name, arrow.string()) for name in COLUMNS}, null_values=[""]
    )
    parse = arrow_csv.ParseOptions(newlines_in_values=True)
    path, part = folder / PARQUET, folder / f".{PARQUET}.part"
    try:
        with (
            arrow_csv.open_csv(folder / CSV, parse_options=parse, convert_options=convert) as blocks,
            parquet.ParquetWriter(part, blocks.schema) as writer,
        ):
            for block in blocks:
                writer.write_batch(block)
        os.replace(part, path)
    except (OSError, ValueError) as error:  # pyarrow's of a damaged table are ValueErrors
        part.unlink(missing_ok=True)
        raise BadInput(f"{path}: cannot be written ({error}); choose another place") from error
    return path
