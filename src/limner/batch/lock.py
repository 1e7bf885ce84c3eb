"""A folder goes in; while it is held, no other run may write there."""

from __future__ import annotations

import contextlib
import os
import socket
from collections.abc import Iterator
from pathlib import Path

from limner.errors import BadInput

NAME = ".lock"


@contextlib.contextmanager
def held(folder: Path) -> Iterator[str]:
    """Hold a folder.

    The system lets go of the lock when its process ends, however it ends: a file that a dead process left does not
    count, it only says that the run before was not finished.

    Yields:
        Who held it last, where that process did not end as it should; else nothing.

    Raises:
        BadInput: another process holds it, or the folder cannot be written.
    """
    path = folder / NAME
    try:
        handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
    except OSError as error:
        raise BadInput(f"{path}: cannot be written ({error.strerror}); choose another folder") from error
    try:
        before = os.read(handle, 200).decode(errors="replace").strip()
        if not _taken(handle):
            raise BadInput(f"{folder}: another run writes there ({before}); wait for its end, or choose another --out")
        _say(handle, f"process {os.getpid()} on {socket.gethostname()}")
        yield before
        _say(handle, "")
    finally:
        os.close(handle)


def _taken(handle: int) -> bool:
    import fcntl

    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        # A network file system without locks: better no lock than no drawing.
        return True
    return True


def _say(handle: int, text: str) -> None:
    with contextlib.suppress(OSError):  # who holds it is told as a courtesy, even on a full disk
        os.ftruncate(handle, 0)
        os.pwrite(handle, text.encode(), 0)
