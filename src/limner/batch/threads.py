"""A process becomes a worker: its libraries use one thread, so that many do not fight, and it keeps freed memory."""

from __future__ import annotations

import contextlib
import ctypes
import functools
import os
from collections.abc import Iterator

from limner.vision.landmarks.fmp.threads import CORES

_VARIABLES = (CORES, "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")


@functools.cache
def hold_threads() -> None:
    """Once for a process, whether it is ours or a cluster's."""
    import cv2
    from threadpoolctl import threadpool_limits

    os.environ[CORES] = "1"
    cv2.setNumThreads(1)
    threadpool_limits(1)
    _keep_memory()


# Of glibc's malloc.h: which threshold, and ours [bytes].
_TRIM, _MMAP = (-1, 256 * 2**20), (-3, 32 * 2**20)


def _keep_memory() -> None:
    """Arrays come and go; what is freed stays with the process, for the next of them.

    Dask has its workers give back all they free (MALLOC_TRIM_THRESHOLD_), and every new array then costs page faults,
    which doubles the time of a drawing.
    """
    with contextlib.suppress(OSError, AttributeError, TypeError):  # another system's C library
        mallopt = ctypes.CDLL(None).mallopt
        for threshold in (_TRIM, _MMAP):
            mallopt(*threshold)


@contextlib.contextmanager
def single_threaded_children() -> Iterator[None]:
    """Processes started meanwhile load their libraries with one thread, which saves their memory too."""
    before = {name: os.environ.get(name) for name in _VARIABLES}
    os.environ.update(dict.fromkeys(_VARIABLES, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
