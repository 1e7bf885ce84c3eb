"""The address of a Dask scheduler goes in; an engine that runs tasks on its workers comes out."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Executor, Future
from typing import Any, TypeVar

from limner import __version__
from limner.batch.engine import Engine
from limner.batch.workers import answer
from limner.errors import BadInput, DeviceFailed, MissingExtra

Result = TypeVar("Result")

_PATIENCE = "30s"
_LARGEST = "512MiB"


@contextlib.contextmanager
def cluster_engine(address: str) -> Iterator[Engine]:
    """Connect to a running scheduler; its workers need the same version of limner.

    A task whose worker dies is given to another; one that killed as many as the scheduler allows
    (``distributed.scheduler.allowed-failures``, by default 3) is given up.

    Raises:
        MissingExtra: ``distributed`` is not installed.
        BadInput: nobody answers, there are no workers, or they have another limner.
    """
    try:
        import dask
        from distributed import Client, KilledWorker
    except ImportError as error:
        raise MissingExtra("--scheduler", "cluster") from error
    # Photos that are sent along are large, and there are never more under way than the workers can take.
    with dask.config.set({"distributed.admin.large-graph-warning-threshold": _LARGEST}):
        client = _connected(Client, address)
        try:
            executor = _Far(client.get_executor(pure=False))
            yield Engine(executor, _threads(client, address), (KilledWorker,), far=True)
        except CancelledError as error:
            raise DeviceFailed(f"--scheduler {address}: the connection was lost; run again when it is back") from error
        finally:
            # Closing forgets the tasks of this client: nothing goes on behind our back.
            client.close()


class _Far(Executor):
    """Tasks on the workers; their errors come back bare, as a worker can hardly send all that led to them."""

    def __init__(self, executor: Any) -> None:
        self._executor = executor

    def submit(self, fn: Callable[..., Result], /, *args: Any, **kwargs: Any) -> Future[Result]:
        """As of any executor."""
        outcome: Future[Result] = Future()
        far = self._executor.submit(answer, fn, *args, **kwargs)
        far.add_done_callback(lambda done: _hand_on(done, outcome))
        return outcome


def _hand_on(done: Future[tuple[bool, Any]], outcome: Future[Any]) -> None:
    if not outcome.set_running_or_notify_cancel():
        return
    try:
        good, result = done.result()
    except BaseException as error:  # calling off too goes on to who waits
        outcome.set_exception(error)
        return
    if good:
        outcome.set_result(result)
    else:
        outcome.set_exception(result)


def _connected(kind: Any, address: str) -> Any:
    try:
        return kind(address, timeout=_PATIENCE, set_as_default=False)
    except (OSError, TimeoutError, ValueError) as error:
        raise BadInput(
            f"--scheduler {address}: cannot be reached ({' '.join(str(error).split()) or 'no answer'});"
            " expected the address that `dask scheduler` prints, such as tcp://host:8786"
        ) from error


def _threads(client: Any, address: str) -> int:
    """How many tasks the workers run at a time."""
    count = sum(client.nthreads().values())
    if not count:
        raise BadInput(f"--scheduler {address}: has no workers; start some with `dask worker {address} --nthreads 1`")
    try:
        versions = client.run(_version)
    except Exception as error:  # whatever a worker raises that lacks it
        raise BadInput(f"--scheduler {address}: its workers lack limner {__version__} ({error})") from error
    if other := {name: version for name, version in versions.items() if version != __version__}:
        name, version = next(iter(other.items()))
        raise BadInput(f"--scheduler {address}: its worker {name} has limner {version}, expected {__version__}")
    return int(count)


def _version() -> str:
    return __version__
