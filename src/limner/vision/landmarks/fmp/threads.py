"""Work and its items go in; results come out in order, one item to a core and no library's own threads beside them.

A linear algebra library starts a thread a core for each small product and lets them spin; on a busy machine that takes
ten times as long as one thread alone. So its threads are held to one, and the items are shared out instead.
"""

from __future__ import annotations

import contextlib
import functools
import itertools
import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

from threadpoolctl import ThreadpoolController

Item = TypeVar("Item")
Result = TypeVar("Result")


CORES = "LIMNER_CORES"
"""Environment variable: how many cores a process may use, where that is less than the system lets it."""


def cores() -> int:
    """Cores that this process may use."""
    if os.environ.get(CORES, "").isdecimal():
        return max(1, int(os.environ[CORES]))
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def in_parallel(work: Callable[[Item], Result], items: Iterable[Item]) -> Iterator[Result]:
    """``map`` over threads; at most as many items and results are held as there are cores."""
    count = cores()
    rest = iter(items)
    with one_thread(), ThreadPoolExecutor(count) as pool:
        while some := list(itertools.islice(rest, count)):
            yield from pool.map(work, some)


@contextlib.contextmanager
def one_thread() -> Iterator[None]:
    """The linear algebra library's own threads are held to one meanwhile."""
    with _libraries().limit(limits=1, user_api="blas"):
        yield


@functools.cache
def _libraries() -> ThreadpoolController:
    """The libraries loaded when this is first asked for; finding them takes milliseconds."""
    return ThreadpoolController()
