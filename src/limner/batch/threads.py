"""Nothing goes in; after it, the libraries of this process use one thread: as many processes as cores do not fight."""

from __future__ import annotations

import contextlib
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
