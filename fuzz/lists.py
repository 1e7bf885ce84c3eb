"""Bytes of a list go in, to be read as photos to draw, points probed on a table, or a manifest of drawings."""

from __future__ import annotations

import io
from pathlib import Path

from fuzz.contract import Reader, file_of
from limner.batch import manifest, source
from limner.batch.listing import photos_of
from limner.cli.arm import read_calibration
from limner.errors import LimnerError
from limner.storage import read_bytes


def _calibration(suffix: str) -> Reader:
    def read(data: bytes) -> None:
        with file_of(data, f"points{suffix}") as path:
            read_calibration(str(path))

    return read


def _photos(suffix: str) -> Reader:
    def read(data: bytes) -> None:
        with file_of(data, f"photos{suffix}") as path:
            _look(list(photos_of([str(path)], io.BytesIO())))

    return read


def piped(data: bytes) -> None:
    """Names on standard input."""
    _look(list(photos_of(["-"], io.BytesIO(data))))


def _look(names: list[str]) -> None:
    """What a batch does with names, as far as no file of this computer has one of them."""
    for name in [name for name in names if "://" not in name and not Path(name).is_absolute()][:20]:
        source.stamp(f"nowhere/{name}")
        try:
            source.face_beside(f"nowhere/{name}")
            read_bytes(f"nowhere/{name}")
        except LimnerError:
            continue


def manifests(data: bytes) -> None:
    """A manifest, on its way to Parquet."""
    with file_of(data, manifest.CSV) as path:
        manifest.to_parquet(path.parent)


HARNESSES = {
    "calibration-json": _calibration(".json"),
    "calibration-csv": _calibration(".csv"),
    "photos-txt": _photos(".txt"),
    "photos-csv": _photos(".csv"),
    "photos-piped": piped,
    "manifest": manifests,
}
