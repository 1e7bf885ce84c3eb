"""A page's WebSocket goes in; its wishes are drawn as they come, and it hears what happens, until it is closed."""

from __future__ import annotations

import asyncio
import contextlib
import json
from typing import Any

from starlette.websockets import WebSocket, WebSocketDisconnect

from limner.errors import LimnerError
from limner.studio.hub import Listener
from limner.studio.live import Live
from limner.studio.studio import Studio


async def talk(socket: WebSocket, *, studio: Studio) -> None:
    """Serve one page until it goes."""
    await socket.accept()
    say, visitor = _Voice(socket), socket.scope["visitor"]
    live, listener = Live(studio, visitor, say), Listener(visitor, say)
    running = asyncio.gather(live.run(), listener.run())
    studio.hub.enter(listener)
    try:
        while not running.done():
            text = await socket.receive_text()
            try:
                live.wish(text)
            except LimnerError as error:
                await say({"type": "error", "error": str(error)}, None)
    except (WebSocketDisconnect, KeyError):
        pass
    finally:
        studio.hub.leave(listener)
        running.cancel()
        with contextlib.suppress(asyncio.CancelledError, WebSocketDisconnect, RuntimeError):
            await running


class _Voice:
    """Sends messages, each with the frame that belongs to it: no other comes between the two."""

    def __init__(self, socket: WebSocket) -> None:
        self._socket, self._turn = socket, asyncio.Lock()

    async def __call__(self, message: dict[str, Any], frame: bytes | None) -> None:
        # A newer wish calls off what is being said; a message without its frame would be told of the next one's.
        await asyncio.shield(self._both(message, frame))

    async def _both(self, message: dict[str, Any], frame: bytes | None) -> None:
        async with self._turn:
            await self._socket.send_text(json.dumps(message))
            if frame is not None:
                await self._socket.send_bytes(frame)
