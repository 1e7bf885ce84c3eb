"""Guests' drawings go in, in turn; the machine gets one after the other, when its operator says so or by itself."""

from __future__ import annotations

import asyncio
import contextlib
import secrets
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import Any

from limner.errors import BadInput, CannotDraw, LimnerError
from limner.studio.jobs import Jobs
from limner.studio.orders import NotThere, Order, WrongState
from limner.studio.visitors import HeldDrawing, Visitor

MOST, EACH, OVER = 40, 3, 20
"""How many may wait, of those one guest's, and how many that are over are still shown."""

NAME_LETTERS = 40

WAITING, DRAWING, DONE, SKIPPED = "waiting", "drawing", "done", "skipped"


@dataclass(eq=False)
class Entry:
    """A drawing in the queue.

    Attributes:
        key: under which it is asked for.
        name: what its guest is called, perhaps empty.
        held: the drawing.
        owner: the guest.
        state: one of ``WAITING``, ``DRAWING``, ``DONE``, ``SKIPPED``.
    """

    key: str
    name: str
    held: HeldDrawing
    owner: Visitor
    state: str = WAITING


@dataclass(frozen=True)
class Goal:
    """The machine of a booth: address, and the profile of a plotter or the name of an arm."""

    to: str = "sim:"
    machine: str | None = None
    robot: str | None = None


class Queue:
    """The queue of a booth.

    Attributes:
        entries: in turn.
        held: whether the operator must say when the next begins, such as after he has put in paper.
        goal: the machine.
    """

    def __init__(
        self, jobs: Jobs, prepared: Callable[[HeldDrawing, Order], Awaitable[bytes]], tell: Callable[[], None]
    ) -> None:
        """An empty queue.

        Args:
            jobs: the machine's.
            prepared: what is sent of a drawing.
            tell: called when anything has changed.
        """
        self.entries: list[Entry] = []
        self.held, self.goal = True, Goal()
        self._jobs, self._prepared, self._tell = jobs, prepared, tell
        self._beginning: asyncio.Task[None] | None = None
        self._preparing: Entry | None = None

    def fields(self, visitor: Visitor) -> list[dict[str, Any]]:
        """What a visitor sees of it."""
        told, left, place = [], 0.0, 0
        for entry in self.entries:
            waits = entry.state == WAITING
            place += waits
            if entry.state == DRAWING:
                left += self._jobs.status.left_s
            elif waits:
                left += entry.held.about["report"]["seconds"]
            own = {"entry": entry.key, "name": entry.name, "state": entry.state, "mine": entry.owner is visitor}
            told.append(
                own | {"place": place if waits else 0, "left_s": left if entry.state in (DRAWING, WAITING) else 0}
            )
        return told

    def add(self, visitor: Visitor, held: HeldDrawing, name: Any) -> Entry:
        """Queue a drawing.

        Raises:
            BadInput: no name for a guest.
            CannotDraw: too many wait.
        """
        if not isinstance(name, str) or len(name) > NAME_LETTERS or not name.isprintable():
            raise BadInput(f"name: expected at most {NAME_LETTERS} letters")
        waiting = [entry for entry in self.entries if entry.state == WAITING]
        if len(waiting) >= MOST:
            raise CannotDraw(f"queue: {MOST} drawings wait already; come again a little later")
        if sum(entry.owner is visitor for entry in waiting) >= EACH:
            raise CannotDraw(f"queue: {EACH} of yours wait already; take one back, or wait for it")
        entry = Entry(secrets.token_urlsafe(9), name.strip(), held, visitor)
        over = [entry for entry in self.entries if entry.state in (DONE, SKIPPED)]
        for old in over[:-OVER]:
            self.entries.remove(old)
        self.entries.append(entry)
        self._tell()
        self._go_on()
        return entry

    def remove(self, key: Any, owner: Visitor | None = None) -> None:
        """Take back a drawing that waits.

        Args:
            key: of the entry.
            owner: whose it must be; None: anybody's.

        Raises:
            NotThere: there is no such entry.
            WrongState: it is being drawn.
        """
        entry = self.entry(key)
        if owner is not None and entry.owner is not owner:
            raise NotThere("no such entry in the queue")
        if entry.state == DRAWING:
            raise WrongState("it is being drawn; skip it to stop that")
        self.entries.remove(entry)
        self._tell()

    def entry(self, key: Any) -> Entry:
        """An entry by its key.

        Raises:
            NotThere: there is none.
        """
        found = [entry for entry in self.entries if entry.key == key]
        if not found:
            raise NotThere("no such entry in the queue")
        return found[0]

    async def next(self) -> None:
        """Begin the next.

        Raises:
            WrongState: the machine has work, or nobody waits.
            LimnerError: it cannot be drawn; it is skipped.
        """
        self._jobs.check("start")
        waiting = [entry for entry in self.entries if entry.state == WAITING]
        if not waiting or self._drawing():
            raise WrongState("queue: nobody waits" if not waiting else "queue: one is being drawn")
        entry, settings = waiting[0], waiting[0].held.about["settings"]
        machine = self.goal.machine or (settings["machine"] if self.goal.to.startswith("sim:") else None)
        order = Order(self.goal.to, machine, self.goal.robot, settings)
        entry.state = DRAWING
        try:
            data = await self._in_time(entry, order)
            self._jobs.start(order, data, entry.held, entry.owner)
        except LimnerError:
            # Of what cannot be prepared, or was skipped meanwhile, the state says so.
            entry.state = WAITING if entry.state == DRAWING else entry.state
            raise
        finally:
            self._tell()

    async def _in_time(self, entry: Entry, order: Order) -> bytes:
        """What is sent of an entry; an arm's motion takes seconds, in which its operator may think better of it."""
        self._preparing = entry
        try:
            data = await self._prepared(entry.held, order)
        except LimnerError:
            entry.state = SKIPPED
            raise
        finally:
            self._preparing = None
        if entry.state != DRAWING:
            raise WrongState("queue: it was skipped before it began")
        return data

    def hold(self, held: bool) -> None:
        """Whether the operator says when the next begins."""
        self.held = held
        self._tell()
        self._go_on()

    def skip(self) -> None:
        """Stop what is being drawn, else pass over who is next.

        Raises:
            WrongState: there is neither.
        """
        entry = self._drawing() or next((entry for entry in self.entries if entry.state == WAITING), None)
        if entry is None:
            raise WrongState("queue: there is nothing to skip")
        if entry.state == DRAWING and "cancel" in self._jobs.may:
            self._jobs.cancel()
        entry.state = SKIPPED
        self._tell()

    def job_changed(self) -> None:
        """The job is in another state: perhaps it is done, and another may begin."""
        entry = self._drawing()
        # While one is prepared the machine still tells of the one before.
        if entry is not None and entry is not self._preparing and self._jobs.status.state in ("done", "idle"):
            entry.state = DONE if self._jobs.status.state == "done" else SKIPPED
            self._tell()
        self._go_on()

    def _drawing(self) -> Entry | None:
        return next((entry for entry in self.entries if entry.state == DRAWING), None)

    def _go_on(self) -> None:
        free = self._jobs.status.state in ("idle", "done", "cancelled") and not self._drawing()
        waiting = any(entry.state == WAITING for entry in self.entries)
        if self.held or not free or not waiting or (self._beginning is not None and not self._beginning.done()):
            return
        self._beginning = asyncio.get_running_loop().create_task(self._by_itself())

    async def _by_itself(self) -> None:
        """Begin the first that can be drawn; the others are skipped."""
        with contextlib.suppress(LimnerError):
            while not self.held and not self._drawing():
                with contextlib.suppress(CannotDraw):
                    await self.next()
