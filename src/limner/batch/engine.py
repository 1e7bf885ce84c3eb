"""How many processes, or the address of a cluster, goes in; what runs tasks, and how many at a time, comes out."""

from __future__ import annotations

import contextlib
import itertools
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor, Future
from dataclasses import dataclass
from typing import TypeVar

from limner.batch.workers import WorkerDied, Workers

Item = TypeVar("Item")
Result = TypeVar("Result")

_AHEAD = 8
"""Tasks that are given out or done ahead of the oldest that is not, for each worker: a slow photo holds nobody up."""


@dataclass(frozen=True)
class Engine:
    """What does the work.

    Attributes:
        executor: runs tasks elsewhere than in this thread.
        width: how many it runs at a time.
        died: what a task raises whose workers died.
        far: whether tasks run where this machine's files may be out of sight.
    """

    executor: Executor
    width: int
    died: tuple[type[Exception], ...] = (WorkerDied,)
    far: bool = False

    @property
    def ahead(self) -> int:
        """How many tasks may be under way, given out or done out of turn."""
        return _AHEAD * self.width


@contextlib.contextmanager
def local_engine(workers: int) -> Iterator[Engine]:
    """Processes of this machine; all are ended at the end, at once where that is an error."""
    executor = Workers(workers)
    try:
        yield Engine(executor, workers)
    except BaseException:  # whatever ends it, Ctrl-C too
        executor.shutdown(cancel_futures=True)
        raise
    executor.shutdown()


def in_order(engine: Engine, work: Callable[[Item], Result], items: Iterable[Item]) -> Iterator[Result]:
    """``map`` by an engine: results in the order of the items, of which a bounded number is held."""
    rest = iter(items)
    window: deque[Future[Result]] = deque()
    for item in itertools.islice(rest, engine.ahead):
        window.append(engine.executor.submit(work, item))
    try:
        while window:
            result = window.popleft().result()
            for item in itertools.islice(rest, 1):
                window.append(engine.executor.submit(work, item))
            yield result
    finally:
        for future in window:
            future.cancel()
