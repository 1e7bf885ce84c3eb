"""What all open pages shall know goes in; each gets the latest of it, as fast as it takes it."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from typing import Any

from limner.studio.visitors import Visitor

Say = Callable[[dict[str, Any], bytes | None], Awaitable[None]]
"""Sends a message, and perhaps a frame after it."""

Telling = Callable[[Visitor], dict[str, Any]]
"""A message as a visitor may see it; its ``type`` says what it takes the place of."""


class Listener:
    """One open page: of each type of message only the latest waits for it."""

    def __init__(self, visitor: Visitor, say: Say) -> None:
        """A page.

        Args:
            visitor: whose it is.
            say: sends a message.
        """
        self._visitor, self._say = visitor, say
        self._waiting: dict[str, dict[str, Any]] = {}
        self._something = asyncio.Event()

    def tell(self, telling: Telling) -> None:
        """Have a message sent soon."""
        message = telling(self._visitor)
        self._waiting[message["type"]] = message
        self._something.set()

    async def run(self) -> None:
        """Send until cancelled."""
        while True:
            await self._something.wait()
            self._something.clear()
            waiting, self._waiting = self._waiting, {}
            for message in waiting.values():
                await self._say(message, None)


class Hub:
    """All open pages."""

    def __init__(self) -> None:
        self._listeners: set[Listener] = set()
        self._latest: dict[str, Telling] = {}

    def enter(self, listener: Listener) -> None:
        """A page opens: it hears what the others heard last."""
        self._listeners.add(listener)
        for telling in self._latest.values():
            listener.tell(telling)

    def leave(self, listener: Listener) -> None:
        """A page is closed."""
        self._listeners.discard(listener)

    def tell(self, kind: str, telling: Telling) -> None:
        """Tell everybody.

        Args:
            kind: type of the message.
            telling: makes it for a visitor.
        """
        self._latest[kind] = telling
        for listener in self._listeners:
            listener.tell(telling)
