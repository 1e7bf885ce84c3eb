"""The address of a Dask scheduler goes in; an engine that runs tasks on its workers comes out."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from typing import Any

from limner import __version__
from limner.batch.engine import Engine
from limner.errors import BadInput, MissingExtra

_PATIENCE = "10s"
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
            executor = client.get_executor(pure=False)
            yield Engine(executor, _threads(client, address), (KilledWorker,), far=True)
            executor.shutdown()
        finally:
            # Closing forgets the tasks of this client: nothing goes on behind our back.
            client.close()


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
    except Exception as error:
        raise BadInput(f"--scheduler {address}: its workers lack limner {__version__} ({error})") from error
    if other := {name: version for name, version in versions.items() if version != __version__}:
        name, version = next(iter(other.items()))
        raise BadInput(f"--scheduler {address}: its worker {name} has limner {version}, expected {__version__}")
    return int(count)


def _version() -> str:
    return __version__
