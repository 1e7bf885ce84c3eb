"""What all parts of the server share, and the two things most of them do: find a visitor's photo, have it computed."""

from __future__ import annotations

import secrets
from dataclasses import dataclass
from typing import Any

from limner.studio.computer import NOW, Computer, PhotoMissing
from limner.studio.hub import Hub
from limner.studio.jobs import Jobs
from limner.studio.orders import NotThere
from limner.studio.queue import Queue
from limner.studio.visitors import HeldDrawing, HeldPhoto, Visitor, Visitors


@dataclass
class Studio:
    """The server's parts.

    Attributes:
        visitors: who has a cookie.
        computer: the computing process, for what people wait for.
        planner: another one, begun when first needed, for what takes seconds: an arm's motion, films.
        settings: of the tree, where the page says nothing.
        hub: all open pages.
        jobs: the machine's.
        queue: of a booth; None: this is none.
    """

    visitors: Visitors
    computer: Computer
    planner: Computer
    settings: dict[str, Any]
    hub: Hub
    jobs: Jobs
    queue: Queue | None = None

    @property
    def booth(self) -> bool:
        """Whether guests queue and an operator commands the machine."""
        return self.queue is not None

    async def take(self, visitor: Visitor, data: bytes) -> HeldPhoto:
        """Look at a new photo, and hold it.

        Raises:
            BadInput: it is no picture that can be used.
        """
        name = secrets.token_urlsafe(9)
        found = await self.computer.ask("photo", NOW, name=name, data=data)
        held = HeldPhoto(name, found["data"], found["jpeg"], {"photo": name} | found["about"])
        visitor.photos.add(name, held)
        return held

    async def compute(
        self, visitor: Visitor, task: str, wish: dict[str, Any], urgency: int = NOW, *, slow: bool = False, **more: Any
    ) -> Any:
        """Have something computed of a photo of a visitor's.

        Args:
            visitor: whose photo it is.
            task: of ``Desk``.
            wish: names the photo.
            urgency: of the task.
            slow: by the process for what takes seconds.
            more: arguments of the task.

        Raises:
            NotThere: he has no such photo.
            LimnerError: whatever stands in the way.
        """
        held, computer = photo_of(visitor, wish.get("photo")), self.planner if slow else self.computer
        try:
            return await computer.ask(task, urgency, wish=wish, **more)
        except PhotoMissing:
            await computer.ask("photo", urgency, name=held.name, data=held.data)
            return await computer.ask(task, urgency, wish=wish, **more)

    async def keep(self, visitor: Visitor, wish: dict[str, Any]) -> HeldDrawing:
        """Draw what a visitor wishes for, and hold the drawing.

        Raises:
            LimnerError: whatever stands in the way.
        """
        made, name = await self.compute(visitor, "keep", wish), secrets.token_urlsafe(9)
        wished = {key: wish[key] for key in ("face", "points_px", "settings")}
        about = {"drawing": name, "photo": wish["photo"], "wish": wished} | made["about"]
        held = HeldDrawing(name, wish["photo"], made["npz"], about)
        visitor.drawings.add(name, held)
        return held


def drawing_of(visitor: Visitor, name: Any) -> HeldDrawing:
    """A drawing that a visitor kept.

    Raises:
        NotThere: he has no such drawing.
    """
    held = visitor.drawings.get(name) if isinstance(name, str) else None
    if held is None:
        raise NotThere("no such drawing here; it was let go of for later ones, or is another's: keep it again")
    return held


def photo_of(visitor: Visitor, name: Any) -> HeldPhoto:
    """A visitor's photo.

    Raises:
        NotThere: he has no such photo.
    """
    held = visitor.photos.get(name) if isinstance(name, str) else None
    if held is None:
        raise NotThere("no such photo here; it was let go of for later ones, or is another's: take it again")
    return held
