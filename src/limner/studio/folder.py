"""The user's folder for what must outlast the studio goes in; a part of it that no other studio uses comes out."""

from __future__ import annotations

import atexit
import contextlib
import os
import tempfile
from pathlib import Path

_LOCKS: list[int] = []


def own_folder() -> Path:
    """A folder of this studio's own, the same as its predecessor's; one that goes at exit where that is in use.

    It lies in ``$XDG_STATE_HOME``, else ``~/.local/state`` (XDG Base Directory Specification).
    """
    # RuntimeError: nobody knows where this user is at home.
    with contextlib.suppress(OSError, RuntimeError):
        base = Path(os.environ.get("XDG_STATE_HOME") or Path.home() / ".local" / "state") / "limner" / "studio"
        base.mkdir(mode=0o700, parents=True, exist_ok=True)
        if _locked(base / "lock"):
            return base
    passing = tempfile.TemporaryDirectory(prefix="limner-studio-")
    atexit.register(passing.cleanup)
    return Path(passing.name)


def _locked(path: Path) -> bool:
    """Whether the file is ours until this process ends, however it does."""
    try:
        import fcntl
    except ImportError:  # Windows: a file that is open cannot be removed by another
        with contextlib.suppress(OSError):
            path.unlink()
        with contextlib.suppress(OSError):
            _LOCKS.append(os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o600))
            return True
        return False
    lock = os.open(path, os.O_RDWR | os.O_CREAT, 0o600)
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        os.close(lock)
        return False
    _LOCKS.append(lock)
    return True
