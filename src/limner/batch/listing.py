"""What the user named (folders, globs, lists, ``-``, URLs) goes in; the photos come out one by one, none opened yet."""

from __future__ import annotations

import csv
import glob
import os
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import BinaryIO

from limner.batch import remote
from limner.errors import BadInput

PICTURES = (
    *(".jpg", ".jpeg", ".jpe", ".mpo", ".png", ".webp", ".avif", ".heic", ".heif", ".tif", ".tiff"),
    *(".bmp", ".dib", ".gif", ".ppm", ".pgm", ".pnm", ".jp2"),
)
"""What counts as a photo in a folder; a file that is named itself may be called anything."""

LISTS = (".txt", ".lst", ".csv")
"""Files that name photos."""

COLUMNS = ("photo", "path", "file", "filename", "image", "name")
"""Headings of the column of a CSV list that holds the photos, the first that is there; else its first column."""

STDIN = "-"
_BLOCK = 2**16


def check_words(words: Sequence[str]) -> None:
    """Say at once which of the words name nothing.

    Raises:
        BadInput: a file, folder or pattern that is not there.
    """
    if not words:
        raise BadInput("batch: no photos named; give files, folders, patterns, a .txt or .csv list, URLs, or -")
    for word in words:
        named = word == STDIN or remote.is_url(word) or os.path.lexists(word)
        if not named and next(glob.iglob(word, recursive=True), None) is None:
            raise BadInput(f"{word}: no such file, folder or pattern of files")


def photos_of(words: Sequence[str], stdin: BinaryIO, leave_out: Path | None = None) -> Iterator[str]:
    """Paths and URLs of photos, in the order named, those of a folder by name; listed only as far as asked for.

    Of a folder, the names in one folder at a time are held in memory; of a list, a line.

    Args:
        words: files, folders, patterns with ``*``, lists (see ``LISTS``), URLs, ``-`` for names on stdin.
        stdin: read for ``-``: a name on each line, or after each a NUL as ``find -print0`` writes.
        leave_out: a folder that is not looked into.

    Raises:
        BadInput: a list or an URL cannot be read, or is no list.
    """
    for word in words:
        if word == STDIN:
            yield from _names(stdin)
        elif remote.is_url(word):
            yield from remote.listed(word, PICTURES)
        elif os.path.isdir(word):
            yield from _in_folder(word, leave_out)
        elif os.path.lexists(word):
            yield from _in_list(word) if word.lower().endswith(LISTS) else [word]
        else:
            yield from _matching(word, leave_out)


def _matching(pattern: str, leave_out: Path | None) -> Iterator[str]:
    for path in sorted(glob.iglob(pattern, recursive=True)):
        if os.path.isdir(path):
            continue
        if path.lower().endswith(PICTURES) and not _inside(path, leave_out):
            yield path


def _inside(path: str, folder: Path | None) -> bool:
    return folder is not None and os.path.abspath(path).startswith(f"{os.path.abspath(folder)}{os.sep}")


def _in_folder(top: str, leave_out: Path | None) -> Iterator[str]:
    own = os.path.realpath(leave_out) if leave_out else None
    for folder, below, names in os.walk(top):
        below[:] = sorted(name for name in below if _shown(name) and os.path.realpath(f"{folder}/{name}") != own)
        for name in sorted(names):
            if _shown(name) and name.lower().endswith(PICTURES):
                yield os.path.join(folder, name)


def _shown(name: str) -> bool:
    return not name.startswith(".")


def _in_list(path: str) -> Iterator[str]:
    """The photos a list names; relative ones from the list's folder."""
    base = os.path.dirname(path)
    try:
        if path.lower().endswith(".csv"):
            with open(path, encoding="utf-8-sig", errors="surrogateescape", newline="") as text:
                yield from (_from(base, name) for name in _column(text))
        else:
            with open(path, "rb") as file:
                yield from (_from(base, name) for name in _names(file))
    except (OSError, csv.Error) as error:
        raise BadInput(f"{path}: cannot be read as a list of photos ({error})") from error


def _from(base: str, name: str) -> str:
    return name if remote.is_url(name) else os.path.join(base, name)


def _column(lines: Iterable[str]) -> Iterator[str]:
    rows = csv.reader(lines)
    first = next(rows, None)
    if first is None:
        return
    headings = [heading.strip().lower() for heading in first]
    known = [name for name in COLUMNS if name in headings]
    which = headings.index(known[0]) if known else 0
    for row in rows if known else _with(first, rows):
        if len(row) > which and row[which]:
            yield row[which]


def _with(first: list[str], rest: Iterable[list[str]]) -> Iterator[list[str]]:
    yield first
    yield from rest


def _names(file: BinaryIO) -> Iterator[str]:
    """Names as they arrive, each ended by NUL where there is one in the first block, else by the end of its line."""
    read = getattr(file, "read1", file.read)
    block = read(_BLOCK)
    end = b"\0" if b"\0" in block else b"\n"
    rest = b""
    while block:
        *whole, rest = (rest + block).split(end)
        if len(rest) > _BLOCK:
            raise BadInput(f"a name of more than {_BLOCK} bytes; expected a list of photos, one on each line")
        yield from (os.fsdecode(name) for name in map(_bare, whole) if name)
        block = read(_BLOCK)
    if _bare(rest):
        yield os.fsdecode(_bare(rest))


def _bare(name: bytes) -> bytes:
    return name.removesuffix(b"\r")
