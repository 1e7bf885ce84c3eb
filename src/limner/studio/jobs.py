"""Drawings to be drawn go in, one at a time; the machine draws, and what it does is told at every step.

    idle -> connecting -> running -> pausing -> paused -> running -> done
                             |-> cancelling -> cancelled   |-> error   |-> lost

The drawing, the order and the journal of what is drawn lie in a folder for as long as it is not done. So after a crash
of the studio or a power cut the job is there again, interrupted, and goes on at the right stroke.
"""

from __future__ import annotations

import asyncio
import contextlib
import dataclasses
import json
import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from limner.errors import BadInput, LimnerError
from limner.studio.orders import BUSY, COMMANDS, Made, Make, Order, Status, WrongState
from limner.studio.shelf import DRAWING, JOURNAL, ORDER, PLAN, Shelf
from limner.studio.visitors import HeldDrawing, Visitor

PATIENCE_S = 5.0
"""How long a server that ends waits for its machine to raise the pen."""

TICK_S = 1.0
"""How often the time left is told while nothing else happens."""


class Jobs:
    """The one job of the server."""

    def __init__(self, folder: Path, make: Make, tell: Callable[[], None]) -> None:
        """Take up what a server before this one left behind.

        Args:
            folder: for what must outlast the server, ours alone.
            make: from an order to what draws it.
            tell: called, in the server's thread, when anything has changed.
        """
        self.status, self.drawing = Status(), ""
        self.owner: Visitor | None = None
        self._shelf, self._make, self._tell = Shelf(folder), make, tell
        self._loop: asyncio.AbstractEventLoop | None = None
        self._thread: threading.Thread | None = None
        self._control: Any = None
        self._begins_s: list[float] = []
        self._next_pens: dict[int, str] = {}
        self._began, self._drew_s, self._shared = 0.0, 0.0, 0.0
        self._take_up()

    @property
    def may(self) -> tuple[str, ...]:
        """Which commands are allowed."""
        return COMMANDS[self.status.state]

    @property
    def busy(self) -> bool:
        """Whether the machine has work."""
        return self.status.state in BUSY

    def fields(self, visitor: Visitor | None) -> dict[str, Any]:
        """What a visitor is told."""
        mine = self.owner is not None and self.owner is visitor
        told = dataclasses.asdict(self.status)
        return told | {"may": list(self.may), "mine": mine, "drawing": self.drawing if mine else None}

    def start(self, order: Order, data: bytes, held: HeldDrawing, owner: Visitor | None) -> None:
        """Begin with a drawing.

        Args:
            order: what is to be drawn by what.
            data: npz of the drawing, or of a robot's motion.
            held: the drawing.
            owner: who wants it.

        Raises:
            WrongState: there is a job already.
        """
        self.check("start")
        self._forget()
        self.drawing, self.owner = held.name, owner
        self._shelf.write(DRAWING, data)
        self._shelf.write_owner(held, owner)
        self._shelf.write(ORDER, json.dumps(dataclasses.asdict(order)).encode())
        self._begin(order, resume=False)

    async def try_out(self, order: Order, data: bytes) -> Made:
        """What would be started, without starting it.

        Raises:
            LimnerError: why it cannot be.
        """
        return await asyncio.to_thread(self._tried, order, data)

    def _tried(self, order: Order, data: bytes) -> Made:
        try:
            with tempfile.TemporaryDirectory(prefix="limner-") as folder:
                path = Path(folder) / DRAWING
                path.write_bytes(data)
                return self._make(order, str(path))
        except OSError as error:
            raise BadInput(f"{tempfile.gettempdir()}: cannot be written ({error.strerror or error})") from error

    def pause(self) -> None:
        """Pause at the next lift of the pen."""
        self.check("pause")
        self._control.pause = True
        self._change("pausing", said="it pauses when the pen is lifted next")

    def resume(self) -> None:
        """Go on, in this run or in the journal of one before."""
        self.check("resume")
        if self.busy:
            self._control.pause = False
            self._began = time.monotonic()
            self._change("running", said="", next_pen="")
        else:
            self._begin(self._shelf.order(), resume=True)

    def cancel(self) -> None:
        """Stop with the pen up; a second time: give up on a machine that does not answer."""
        self.check("cancel")
        if self.status.state == "cancelling":
            self._change("lost", error="the machine does not answer; lift the pen by hand if it is down")
            return
        self._control.stop, self._control.pause = True, False
        self._change("cancelling", said="it stops as soon as it can, the pen up")

    def clear(self) -> None:
        """Forget a job that is over."""
        self.check("clear")
        self._forget()
        self._change("idle")

    def abandon(self) -> None:
        """The server ends: stop the machine, and wait for it a little; the journal says where to go on."""
        if self.status.state in ("idle", "done", "cancelled"):
            self._shelf.clear()
        if self._thread is not None and self._thread.is_alive() and self._control is not None:
            self._control.stop, self._control.pause = True, False
            self._thread.join(PATIENCE_S)

    def check(self, command: str) -> None:
        """Let a command pass.

        Raises:
            WrongState: it is not possible now.
        """
        waits = self._thread is not None and self._thread.is_alive() and not self.busy
        if command not in self.may or (waits and command in ("start", "resume", "clear")):
            others = ", ".join(self.may) or "nothing but wait"
            raise WrongState(f"the job is {self.status.state}: {command} is not possible now; possible: {others}")

    def _change(self, state: str, **fields: Any) -> None:
        self.status = dataclasses.replace(self.status, state=state, **fields)
        self._tell()

    def _begin(self, order: Order, *, resume: bool) -> None:
        self._loop = asyncio.get_running_loop()
        from limner.targets.send import Control

        self._control = Control()
        at = self.status.stroke if resume else 0
        self.status = Status("connecting", order.to, order.robot or order.machine or "", frame_only=order.frame_only)
        self.status.stroke = at
        self._began, self._drew_s = time.monotonic(), 0.0
        arguments = (order, self._control, resume)
        self._thread = threading.Thread(target=self._run, args=arguments, name="limner-job", daemon=True)
        self._thread.start()
        self._tell()
        self._loop.call_later(TICK_S, self._tick)

    def _run(self, order: Order, control: Any, resume: bool) -> None:
        """In the thread: everything from the order to its end."""
        # numpy and all that plans load when the first job begins, not when the server does.
        from limner.targets.journal import Journal

        try:
            made = self._make(order, str(self._shelf.folder / DRAWING))
            # Written before the machine moves: without it a job that is killed cannot be gone on with.
            plan = [made.name, float(made.seconds), [float(value) for value in made.begins_s]]
            self._shelf.write(PLAN, json.dumps(plan).encode())
            path = self._shelf.folder / JOURNAL
            journal = Journal(path, made.drawing, resume=resume and path.exists())
            self._post(self._known, made, journal.place.stroke)
            try:
                ended = made.run(
                    journal, control, lambda place, waits: self._post(self._at, place.stroke, place.vertex, waits)
                )
            finally:
                journal.close()
            self._post(self._ended, ended.stroke)
        except LimnerError as error:
            self._post(self._failed, str(error))
        except Exception as error:  # a bug in a driver must not leave a job that runs for ever
            self._post(self._failed, f"a bug in limner: {type(error).__name__}: {error}")

    def _post(self, call: Callable[..., None], *arguments: Any) -> None:
        """From the job's thread into the server's."""
        with contextlib.suppress(RuntimeError):  # the server has ended meanwhile
            assert self._loop is not None
            self._loop.call_soon_threadsafe(call, *arguments)

    def _known(self, made: Made, stroke: int) -> None:
        self._begins_s, drawing = [float(value) for value in made.begins_s], made.drawing
        changes = drawing.changes().nonzero()[0].tolist()
        self._next_pens = {place: drawing.pens[int(drawing.layer[place])].name for place in changes}
        self.status = dataclasses.replace(
            self.status, name=made.name, strokes=len(self._begins_s), seconds=made.seconds, left_s=made.seconds
        )
        self._place(stroke)
        self._shared = self.status.share
        self._tell()

    def _at(self, stroke: int, vertex: int, waits: bool) -> None:
        """The pen is up, before a stroke."""
        state = self.status.state
        self._place(stroke)
        if waits and state in ("connecting", "running", "pausing") and self._control.pause:
            self._drew_s += time.monotonic() - self._began
            pen = "" if vertex else self._next_pens.get(stroke, "")
            self._change("paused", said=f"the pen is up: now the pen '{pen}'" if pen else "the pen is up", next_pen=pen)
        elif not waits and state in ("connecting", "running", "pausing", "paused"):
            if state in ("connecting", "paused"):
                self._began = time.monotonic()
            self._change("pausing" if state == "pausing" else "running", next_pen="")

    def _place(self, stroke: int) -> None:
        self.status.stroke = stroke
        begins, whole = self._begins_s, self.status.seconds
        if stroke >= len(begins):
            self.status.share = 1.0
        elif whole > 0:
            self.status.share = min(max(0.0, begins[stroke] / whole), 1.0) if stroke else 0.0
        self._clock()

    def _clock(self) -> None:
        """Elapsed as it was; left by what it has taken so far, else as planned."""
        status = self.status
        running = status.state in ("running", "pausing", "cancelling")
        spent = self._drew_s + (time.monotonic() - self._began if running else 0.0)
        status.elapsed_s = spent
        done = status.share - self._shared
        pace = spent / (done * status.seconds) if done > 0.02 and status.seconds else 1.0
        status.left_s = max(0.0, (1 - status.share) * status.seconds * pace)

    def _tick(self) -> None:
        if self.busy and self._loop is not None:
            self._clock()
            self._tell()
            self._loop.call_later(TICK_S, self._tick)

    def _ended(self, stroke: int) -> None:
        self._thread = None  # this was the last that it does, though it may still be there for a moment
        self._place(stroke)
        if stroke >= self.status.strokes:
            self._shelf.clear()
            self._change("done", left_s=0.0, said="drawn")
        elif self.status.state != "lost":
            self._change("cancelled", said="stopped with the pen up")

    def _failed(self, text: str) -> None:
        self._thread = None
        self._change("error", error=text.replace("--resume", "going on"), said="")

    def _take_up(self) -> None:
        """What a server before this one left behind, interrupted."""
        left = self._shelf.left()
        if left is None:
            self._shelf.clear()
            return
        order, name, seconds, self._begins_s = left
        self.status = Status("interrupted", order.to, name, len(self._begins_s), seconds=seconds)
        self.status.frame_only, self.status.said = order.frame_only, "limner ended in the middle of it"
        self._place(self._shelf.last_stroke())
        self.owner = self._shelf.owner()
        self.drawing = self.owner.drawings.latest()[0].name if self.owner else ""

    def _forget(self) -> None:
        self.status, self.drawing, self.owner = Status(), "", None
        self._begins_s, self._next_pens = [], {}
        self._shelf.clear()
