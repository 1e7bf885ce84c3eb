"""What became of each photo goes in; what is known of it already comes out, after a crash too."""

from __future__ import annotations

import contextlib
import json
import os
import sqlite3
import time
import typing
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from limner.batch.manifest import Row
from limner.errors import BadInput

NAME = ".state.sqlite"

_COMMIT_S = 1.0
_VERSION = 1

_TABLES = """
CREATE TABLE IF NOT EXISTS stamps (photo BLOB PRIMARY KEY, stamp TEXT NOT NULL, digest TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS done (content TEXT PRIMARY KEY, mark TEXT, figures TEXT NOT NULL, tile BLOB NOT NULL);
"""


class Known(NamedTuple):
    """What became of a photo before.

    Attributes:
        mark: of the settings; None where they were others than now.
        figures: its row, but for the photo's name.
        tile: of the contact sheet; may be empty.
    """

    mark: str | None
    figures: dict[str, Any]
    tile: bytes


class State:
    """A database in the output folder; it holds nothing in memory, and is written about once a second."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._written = time.monotonic()
        self._base = sqlite3.connect(path, isolation_level=None)

    @classmethod
    @contextlib.contextmanager
    def opened(cls, folder: Path) -> Iterator[State]:
        """The state of an output folder.

        Raises:
            BadInput: it cannot be read or written, or was written by another version.
        """
        state = cls(folder / NAME)
        try:
            with state._telling():
                state._prepare()
            yield state
            state.commit()
        finally:
            with contextlib.suppress(sqlite3.Error):
                state._base.close()

    def _prepare(self) -> None:
        # Losing power may cost the last second, never the file.
        self._base.execute("PRAGMA synchronous = NORMAL")
        (version,) = self._base.execute("PRAGMA user_version").fetchone()
        if version not in (0, _VERSION):
            raise BadInput(f"{self._path}: was written by another version of limner; choose another --out")
        self._base.executescript(f"{_TABLES} PRAGMA user_version = {_VERSION};")
        self._base.execute("BEGIN")

    def digest(self, photo: str, stamp: str) -> str | None:
        """The hash of a photo, if its stamp is still the one it was known by."""
        query = "SELECT digest FROM stamps WHERE photo = ? AND stamp = ?"
        with self._telling():
            found = self._base.execute(query, (os.fsencode(photo), stamp)).fetchone()
        return found[0] if found and isinstance(found[0], str) else None

    def keep_digest(self, photo: str, stamp: str, digest: str) -> None:
        """Remember the hash of a photo."""
        self._put("INSERT OR REPLACE INTO stamps VALUES (?, ?, ?)", os.fsencode(photo), stamp, digest)

    def forget_other(self, mark: str) -> None:
        """Take as not done what was drawn with other settings: its files are about to be written over."""
        self._put("UPDATE done SET mark = NULL WHERE mark != ?", mark)
        self.commit()

    def done(self, content: str) -> Known | None:
        """What became of a content before, whatever the settings were; None also where that is damaged."""
        query = "SELECT mark, figures, tile FROM done WHERE content = ?"
        with self._telling():
            found = self._base.execute(query, (content,)).fetchone()
        return _known(*found) if found else None

    def keep_done(self, content: str, known: Known) -> None:
        """Remember what became of it."""
        figures = json.dumps(known.figures)
        self._put("INSERT OR REPLACE INTO done VALUES (?, ?, ?, ?)", content, known.mark, figures, known.tile)

    def commit(self) -> None:
        """Write now."""
        with self._telling():
            # A full disk has rolled it back already.
            if self._base.in_transaction:
                self._base.execute("COMMIT")
            self._base.execute("BEGIN")
        self._written = time.monotonic()

    def _put(self, statement: str, *values: object) -> None:
        with self._telling():
            self._base.execute(statement, values)
        if time.monotonic() - self._written > _COMMIT_S:
            self.commit()

    @contextlib.contextmanager
    def _telling(self) -> Iterator[None]:
        try:
            yield
        except (sqlite3.Error, UnicodeDecodeError) as error:  # what SQLite says of a damaged file quotes it
            raise BadInput(f"{self._path}: cannot be read or written ({error}); choose another place") from error


def _known(mark: object, text: Any, tile: object) -> Known | None:
    try:
        figures = json.loads(text)
    except (TypeError, ValueError, RecursionError):
        return None
    if not (isinstance(figures, dict) and {"drawing", "error"} <= set(figures) <= set(_FIGURES)):
        return None
    if not all(isinstance(value, _FIGURES[name]) for name, value in figures.items()):
        return None
    if not isinstance(tile, bytes) or figures["drawing"] != os.path.basename(figures["drawing"]):
        return None
    return Known(mark if isinstance(mark, str) else None, figures, tile)


_FIGURES = {name: kind for name, kind in typing.get_type_hints(Row).items() if name not in ("photo", "hash")}
