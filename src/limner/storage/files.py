"""Files: written whole or not at all, read whole and only up to a size."""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path

from limner.errors import BadInput


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
