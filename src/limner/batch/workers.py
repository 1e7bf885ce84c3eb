"""Tasks go in; their results come out of N processes of this machine, of which any may die."""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
import threading
from collections.abc import Callable
from concurrent.futures import CancelledError, Executor, Future, ThreadPoolExecutor
from multiprocessing.connection import Connection
from typing import Any, TypeVar

from limner.batch.threads import hold_threads, single_threaded_children
from limner.errors import DeviceFailed, LimnerError

Result = TypeVar("Result")

ATTEMPTS = 2
"""A task whose worker dies is done once more, by a new worker."""

_NO_DELAY_S = 5.0


class WorkerDied(LimnerError):
    """The processes that did a task died of it, or were killed."""


class Workers(Executor):
    """N processes, each with one task at a time, so that whoever dies takes one task with it.

    They start when first needed. A thread of this process stands for each, and waits for it.
    """

    def __init__(self, count: int) -> None:
        self._threads = ThreadPoolExecutor(count, "limner-worker")
        self._mine = threading.local()
        self._children: set[_Child] = set()
        self._lock = threading.Lock()
        self._closed = False

    def submit(self, fn: Callable[..., Result], /, *args: Any, **kwargs: Any) -> Future[Result]:
        """As of any executor; the function is found by its name in the worker."""
        task = pickle.dumps((fn, args, kwargs), pickle.HIGHEST_PROTOCOL)
        return self._threads.submit(self._done, task)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the workers: at once where futures are cancelled, else when all is done."""
        self._closed = cancel_futures
        if cancel_futures:
            self._end()
        self._threads.shutdown(wait, cancel_futures=cancel_futures)
        self._end()

    def pids(self) -> list[int]:
        """Of the workers that run."""
        with self._lock:
            return [child.pid for child in self._children]

    def _end(self) -> None:
        with self._lock:
            children, self._children = self._children, set()
        for child in children:
            child.end()

    def _done(self, task: bytes) -> Any:
        why = ""
        for _ in range(ATTEMPTS):
            child = self._child()
            try:
                good, result = child.do(task)
            except (EOFError, OSError):
                self._forget(child)
                why = child.why()
                continue
            if not good:
                raise result
            return result
        raise WorkerDied(f"its worker died, and so did the next ({why}); a smaller photo may do")

    def _child(self) -> _Child:
        child: _Child | None = getattr(self._mine, "child", None)
        if child is not None:
            return child
        with self._lock:
            if self._closed:
                raise CancelledError
            child = self._mine.child = _Child()
            self._children.add(child)
        return child

    def _forget(self, child: _Child) -> None:
        self._mine.child = None
        with self._lock:
            self._children.discard(child)
        child.end()


class _Child:
    """One process, and the pipe to it."""

    def __init__(self) -> None:
        context = multiprocessing.get_context("spawn")
        self._pipe, other = context.Pipe()
        self._process = context.Process(target=_serve, args=(other,), daemon=True, name="limner-worker")
        with single_threaded_children():
            self._process.start()
        other.close()
        self.pid = self._process.pid or 0
        self._ready = False

    def do(self, task: bytes) -> tuple[bool, Any]:
        """Whether it went well, and the result or the error.

        Raises:
            EOFError, OSError: the process is dead.
            DeviceFailed: it never came to live.
        """
        if not self._ready:
            try:
                self._pipe.recv_bytes()
            except (EOFError, OSError) as error:
                self.end()
                raise DeviceFailed(f"a worker process could not be started ({self.why()})") from error
            self._ready = True
        self._pipe.send_bytes(task)
        good, result = pickle.loads(self._pipe.recv_bytes())
        return bool(good), result

    def end(self) -> None:
        """Kill it and wait for its end."""
        self._process.kill()
        self._process.join(_NO_DELAY_S)

    def why(self) -> str:
        """How it ended, in words."""
        code = self._process.exitcode
        if code == -signal.SIGKILL:
            return "killed by signal 9, as where memory runs out"
        return f"killed by signal {-code}" if code is not None and code < 0 else f"exit code {code}"


def _serve(pipe: Connection) -> None:
    """The life of a worker: tasks from the pipe, results into it, until its other end closes."""
    # Ctrl-C reaches every process of the terminal; what it means is decided in one.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        pipe.send_bytes(b"ready")
        while True:
            task = pipe.recv_bytes()
            pipe.send_bytes(_answered(task))
    except (EOFError, OSError):
        os._exit(0)


def _answered(task: bytes) -> bytes:
    fn, args, kwargs = pickle.loads(task)
    return pickle.dumps(answer(fn, *args, **kwargs), pickle.HIGHEST_PROTOCOL)


def answer(fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> tuple[bool, Any]:
    """Whether a task went well, and its result or its error, in a form that can go to another process."""
    hold_threads()
    try:
        return True, fn(*args, **kwargs)
    except Exception as error:  # whatever it is goes on to who waits
        # What led to it may hold anything, open files too.
        error.__cause__ = error.__context__ = None
        bare = error.with_traceback(None)
    try:
        pickle.loads(pickle.dumps(bare))
    except Exception:  # whatever copying its parts leads to
        return False, RuntimeError(f"{type(bare).__name__}: {bare}")
    return False, bare
