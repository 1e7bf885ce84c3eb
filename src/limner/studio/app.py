"""The server's parts go in; the guarded web application comes out: page, photos, drawings, the live socket."""

from __future__ import annotations

import asyncio
import contextlib
import functools
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

from starlette.applications import Starlette
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import JSONResponse, Response

from limner.errors import LimnerError
from limner.studio import machine
from limner.studio.computer import Computer
from limner.studio.guard import Guard
from limner.studio.hub import Hub
from limner.studio.jobs import Jobs
from limner.studio.orders import Make, NotThere, WrongState
from limner.studio.queue import Queue
from limner.studio.routes import routes
from limner.studio.studio import Studio
from limner.studio.visitors import Visitors

MESSAGE_BYTES = 2**18
"""A longer message of the WebSocket is refused."""


def assembled(settings: dict[str, Any], make: Make, port: int, folder: Path, *, queued: bool) -> Studio:
    """The parts of a server.

    Args:
        settings: of the tree, where the page says nothing.
        make: from an order to what draws it.
        port: of the server.
        folder: for the job, ours alone.
        queued: whether it is a booth, where guests queue.
    """
    hub = Hub()

    def tell() -> None:
        hub.tell("job", lambda visitor: {"type": "job"} | jobs.fields(visitor))
        if studio.queue is not None:
            studio.queue.job_changed()

    def tell_queue(queue: Queue) -> None:
        hub.tell("queue", lambda visitor: {"type": "queue", "queue": queue.fields(visitor), "held": queue.held})

    jobs = Jobs(folder / "job", make, tell)
    visitors = Visitors(port)
    if jobs.owner is not None:
        visitors.expect(jobs.owner)
    studio = Studio(visitors, Computer(settings), Computer(settings, lazy=True), settings, hub, jobs)
    hub.tell("job", lambda visitor: {"type": "job"} | jobs.fields(visitor))
    if queued:
        line = Queue(jobs, lambda held, order: machine.prepared(studio, held, order), lambda: tell_queue(line))
        studio.queue = line
        tell_queue(line)
    return studio


def build(studio: Studio, tokens: dict[str, str], names: set[str]) -> Guard:
    """The application.

    Args:
        studio: what it serves.
        tokens: role -> who brings it may enter.
        names: hosts the server is called by.
    """
    life = functools.partial(_life, studio)
    errors: dict[Any, Any] = {LimnerError: _limner_error, HTTPException: _http_error, Exception: _bug}
    app = Starlette(routes=routes(studio), lifespan=life, exception_handlers=errors)
    return Guard(app, studio.visitors, tokens, names)


@contextlib.asynccontextmanager
async def _life(studio: Studio, app: Starlette) -> AsyncIterator[None]:
    await studio.computer.open()
    await studio.planner.open()
    try:
        yield
    finally:
        await studio.computer.close()
        await studio.planner.close()
        await asyncio.to_thread(studio.jobs.abandon)


async def _limner_error(request: Request, error: LimnerError) -> Response:
    own = {NotThere: 404, WrongState: 409}
    status = own.get(type(error)) or {2: 400, 3: 422, 4: 422, 5: 502}.get(error.exit_code, 500)
    return JSONResponse({"error": str(error)}, status)


async def _http_error(request: Request, error: HTTPException) -> Response:
    return JSONResponse({"error": error.detail}, error.status_code, headers=dict(error.headers or {}))


async def _bug(request: Request, error: Exception) -> Response:
    """One line for who asked; the server tells the rest in its terminal."""
    return JSONResponse({"error": f"a bug in limner: {type(error).__name__}; report it"}, 500)
