"""A reader and bytes go in; nothing comes out where the reader keeps its promise, else the error that breaks it."""

from __future__ import annotations

import contextlib
import logging
import os
import signal
import tempfile
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from unittest import mock

from limner.errors import LimnerError

Reader = Callable[[bytes], object]

LONGEST_LINE = 2000
"""Characters of an error: it is to be read."""

CPU_S = 10.0
"""Of the processor, for any input of a few kilobytes."""


class Broken(AssertionError):
    """A reader did what it must not."""


def check(reader: Reader, data: bytes) -> bool:
    """Hand bytes to a reader: it gives a value, or raises a ``LimnerError`` of one line, in time; no more is said.

    Returns:
        Whether it gave a value.

    Raises:
        Broken: it took too long, its error is not one line, or something was logged for the terminal.
        Exception: whatever else it raised.
    """
    with warnings.catch_warnings(), _in_time(), _in_silence():
        warnings.simplefilter("error")
        try:
            reader(data)
        except LimnerError as error:
            text = str(error)
            if not text or not text.isprintable() or len(text) > LONGEST_LINE:
                raise Broken(f"an error that is not one line: {text[:200]!r}") from error
            return False
    return True


@contextlib.contextmanager
def _in_silence() -> Iterator[None]:
    """What libraries log and nobody takes up would stand in the terminal beside the error."""
    said: list[str] = []

    class Heard(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            said.append(record.getMessage())

    unheard = mock.patch.object(logging.root, "handlers", [])  # as in a terminal, where nobody listens
    with unheard, mock.patch.object(logging, "lastResort", Heard(logging.WARNING)):
        yield
    if said:
        raise Broken(f"says {said[0]!r}")


@contextlib.contextmanager
def _in_time() -> Iterator[None]:
    """Processor time, not the clock's: a busy machine is no failure."""

    def late(number: int, frame: Any) -> None:
        raise Broken(f"took more than {CPU_S:g} s of the processor")

    before = signal.signal(signal.SIGPROF, late)
    signal.setitimer(signal.ITIMER_PROF, CPU_S)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)


@contextlib.contextmanager
def file_of(data: bytes, name: str) -> Iterator[Path]:
    """A file of these bytes, gone afterwards."""
    shared = "/dev/shm" if os.path.isdir("/dev/shm") else None
    with tempfile.TemporaryDirectory(dir=shared) as folder:
        path = Path(folder) / name
        path.write_bytes(data)
        yield path
