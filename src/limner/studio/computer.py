"""Tasks go in from all visitors; they are done in a process of their own, the most urgent first, and answered."""

from __future__ import annotations

import asyncio
import contextlib
import ctypes
import heapq
import multiprocessing
import os
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from limner.errors import BadInput, CannotDraw, DeviceFailed, LimnerError, NoFace, NothingToDraw
from limner.studio.worker import DONE, FAILED, LEFT, MISSING, work

LIMIT_S = 60.0
"""A task that computes for longer is broken off, and its process with it."""

PATIENCE = 10
"""How many times as long it may take on a machine that is busy with other things."""

NOW, SOON, LATER = 0, 1, 2
"""Urgency: what somebody waits for, such as a preview; what he will look at next; what may follow."""

_DIED = "died"


class PhotoMissing(LimnerError):
    """The process does not hold that photo, since it is new or has held others meanwhile."""


@dataclass(order=True)
class _Task:
    urgency: int
    number: int
    name: str = field(compare=False)
    arguments: dict[str, Any] = field(compare=False)
    answer: asyncio.Future[Any] = field(compare=False)


class Computer:
    """The computing process, kept alive.

    Attributes:
        starts: how often a process was started.
    """

    def __init__(self, settings: dict[str, Any], limit_s: float = LIMIT_S, *, lazy: bool = False) -> None:
        """Nothing is started yet.

        Args:
            settings: of the tree, where a task says nothing.
            limit_s: of a task, in time of computing.
            lazy: start the process for the first task, not when opened.
        """
        self._lazy = lazy
        self.starts = 0
        self._settings, self._limit_s = settings, limit_s
        self._context = multiprocessing.get_context("spawn")
        self._unwanted = self._context.RawValue(ctypes.c_longlong, 0)
        self._thread = ThreadPoolExecutor(1, "computer")
        self._waiting: list[_Task] = []
        self._something = asyncio.Event()
        self._number = self._doing = 0
        self._process: Any = None
        self._pipe: Any = None
        self._loop: asyncio.Task[None] | None = None

    async def open(self) -> None:
        """Start; the process warms up meanwhile."""
        self._loop = asyncio.create_task(self._serve())

    async def close(self) -> None:
        """End the process, whatever it does."""
        if self._loop is not None:
            self._loop.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await self._loop
        if self._process is not None:
            # Its end wakes the thread that waits for its answer.
            self._process.kill()
        self._thread.shutdown()
        self._kill()

    @property
    def pid(self) -> int | None:
        """Of the process."""
        return self._process.pid if self._process is not None else None

    async def ask(self, name: str, urgency: int = NOW, /, **arguments: Any) -> Any:
        """Have a task of ``Desk`` done.

        A caller that is cancelled calls the task off: at once if it waits, else before its next stage.

        Raises:
            LimnerError: what the task raised.
            PhotoMissing: its photo must be handed over anew.
        """
        self._number += 1
        task = _Task(urgency, self._number, name, arguments, asyncio.get_running_loop().create_future())
        heapq.heappush(self._waiting, task)
        self._something.set()
        try:
            return await task.answer
        except asyncio.CancelledError:
            if self._doing == task.number:
                self._unwanted.value = task.number
            raise

    async def _serve(self) -> None:
        loop = asyncio.get_running_loop()
        if not self._lazy:
            await loop.run_in_executor(self._thread, self._start)
        while True:
            await self._something.wait()
            if not self._waiting:
                self._something.clear()
                continue
            task = heapq.heappop(self._waiting)
            if task.answer.cancelled():
                continue
            self._doing = task.number
            outcome, value = await loop.run_in_executor(self._thread, self._exchange, task)
            if outcome == _DIED and not task.answer.cancelled():
                # Perhaps another's task broke it: one more try.
                outcome, value = await loop.run_in_executor(self._thread, self._exchange, task)
            _answer(task.answer, outcome, value)

    def _exchange(self, task: _Task) -> tuple[str, Any]:
        """One task to the process and what came of it back; in the thread."""
        if self._process is None or not self._process.is_alive():
            self._start()
        try:
            self._pipe.send((task.number, task.name, task.arguments))
            if self._in_time():
                outcome, value = self._pipe.recv()
                return outcome, value
            text = f"this took longer than {self._limit_s:g} s and was broken off; ask for less"
            self._kill()
            return FAILED, ("CannotDraw", text)
        except (EOFError, OSError):
            self._kill()
            return _DIED, None

    def _in_time(self) -> bool:
        """Wait for an answer, unless the task is broken."""
        began, before_s = time.monotonic(), _computed_s(self._process.pid)
        while not self._pipe.poll(min(self._limit_s, 1.0)):
            passed = time.monotonic() - began
            computed = _computed_s(self._process.pid) - before_s
            if passed > PATIENCE * self._limit_s or min(passed, computed) > self._limit_s:
                return False
        return True

    def _start(self) -> None:
        self._pipe, theirs = self._context.Pipe()
        # One that is begun for a task is waited for already.
        arguments = (theirs, self._unwanted, self._settings, not self._lazy and not self.starts)
        self._process = self._context.Process(target=work, args=arguments, name="limner-computer", daemon=True)
        self._process.start()
        theirs.close()
        self.starts += 1

    def _kill(self) -> None:
        if self._process is not None:
            self._process.kill()
            self._process.join()
            self._pipe.close()
            self._process = None


def _computed_s(pid: int) -> float:
    """How long a process has computed; where the system does not tell it as Linux does, the time that passes."""
    try:
        told = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
        return (int(told[11]) + int(told[12])) / os.sysconf("SC_CLK_TCK")
    except OSError:
        return time.monotonic()


def _answer(answer: asyncio.Future[Any], outcome: str, value: Any) -> None:
    if answer.done():
        return
    if outcome == DONE:
        answer.set_result(value)
    elif outcome == LEFT:
        answer.cancel()
    elif outcome == MISSING:
        answer.set_exception(PhotoMissing(str(value)))
    elif outcome == FAILED:
        answer.set_exception(_error(*value))
    else:
        answer.set_exception(LimnerError("the computing broke down twice over this; try another photo or setting"))


def _error(kind: str, text: str) -> LimnerError:
    """An error of ``limner.errors`` by its name; one that takes more than its text comes as its parent."""
    known = {error.__name__: error for error in (BadInput, NoFace, CannotDraw, NothingToDraw, DeviceFailed)}
    return (BadInput if kind == "MissingExtra" else known.get(kind, LimnerError))(text)
