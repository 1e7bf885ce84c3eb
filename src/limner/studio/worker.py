"""The computing process: tasks come in through a pipe, one at a time; what came of each goes back."""

from __future__ import annotations

import signal
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any

from limner.errors import LimnerError

DONE, FAILED, MISSING, LEFT = "done", "failed", "missing", "left"
"""What can come of a task: its result; an error in one line; a photo that is not on the desk; it was called off."""


class CalledOff(Exception):
    """The task that is being done is not wanted any more."""


def work(pipe: Connection, unwanted: Any, settings: dict[str, Any], warm: bool) -> None:
    """Do tasks until the pipe ends.

    Args:
        pipe: (number, name, arguments) come in; (what came of it, value) goes out.
        unwanted: shared number of the task that is called off.
        settings: of the tree, where a task says nothing.
        warm: get ready for drawing after the first task.
    """
    # Ctrl-C ends the server, which then ends this.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    tasks = _Tasks(unwanted, settings)
    while True:
        try:
            number, name, arguments = pipe.recv()
            pipe.send(tasks.outcome(number, name, arguments))
        except (EOFError, OSError):
            return
        # The first thing a page asks is what it offers: it shows itself meanwhile.
        if warm:
            tasks.warm()
            warm = False


class _Tasks:
    """The desk, and which of its tasks is being done."""

    def __init__(self, unwanted: Any, settings: dict[str, Any]) -> None:
        import cv2

        from limner.pipeline import Settings
        from limner.studio.desk import Desk, NotHeld

        # Two threads on a small computer take time from whatever streams to a machine.
        cv2.setNumThreads(1)
        self._number, self._unwanted, self._not_held = 0, unwanted, NotHeld
        self._desk = Desk(Settings.from_dict(settings), self._look)

    def warm(self) -> None:
        """Load what the first photo will need, whoever calls off the task before."""
        self._number = -1
        self._desk.warm()

    def _look(self) -> None:
        if self._unwanted.value == self._number:
            raise CalledOff

    def outcome(self, number: int, name: str, arguments: dict[str, Any]) -> tuple[str, Any]:
        """What came of a task."""
        self._number = number
        try:
            task: Callable[..., Any] = getattr(self._desk, name)
            return DONE, task(**arguments)
        except CalledOff:
            return LEFT, None
        except LimnerError as error:
            return FAILED, (type(error).__name__, str(error))
        except self._not_held as error:
            return MISSING, error.args[0]
        except MemoryError:
            return FAILED, ("CannotDraw", "not enough memory for this; try a smaller photo")
        except Exception as error:  # whatever a task stumbles over, the next one is another's
            return FAILED, ("LimnerError", f"a bug in limner: {type(error).__name__}: {error}")
