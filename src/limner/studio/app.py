"""The server's parts go in; the guarded web application comes out: page, photos, drawings, the live socket."""

from __future__ import annotations

import asyncio
import contextlib
import functools
import json
import os
from collections.abc import AsyncIterator, Awaitable, Callable
from importlib import resources
from pathlib import Path
from typing import Any

from starlette.applications import Starlette
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import FileResponse, JSONResponse, PlainTextResponse, Response
from starlette.routing import BaseRoute, Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.websockets import WebSocket, WebSocketDisconnect

from limner.errors import LimnerError
from limner.studio import booth, drawings, machine, photos
from limner.studio.computer import Computer
from limner.studio.guard import Guard
from limner.studio.hub import Hub, Listener
from limner.studio.jobs import Jobs
from limner.studio.live import Live
from limner.studio.openapi import describe, document
from limner.studio.orders import Make, WrongState
from limner.studio.queue import Queue
from limner.studio.studio import NotThere, Studio
from limner.studio.visitors import Visitor, Visitors

MESSAGE_BYTES = 2**18
"""A longer message of the WebSocket is refused."""

PAGE = Path(str(resources.files("limner.studio") / "page"))
"""The page's own files."""

Handler = Callable[[Studio, Visitor, Request], Awaitable[Response]]


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

    @contextlib.asynccontextmanager
    async def life(app: Starlette) -> AsyncIterator[None]:
        await studio.computer.open()
        await studio.planner.open()
        try:
            yield
        finally:
            await studio.computer.close()
            await studio.planner.close()
            await asyncio.to_thread(studio.jobs.abandon)

    def at(path: str, handler: Handler, *methods: str) -> Route:
        async def endpoint(request: Request) -> Response:
            return await handler(studio, request.scope["visitor"], request)

        return Route(path, functools.wraps(handler)(endpoint), methods=list(methods) or ["GET"])

    routes: list[BaseRoute] = [
        Route("/", functools.partial(_page, name="booth.html" if studio.booth else "index.html")),
        Route("/operator", functools.partial(_page, name="operator.html")),
        at("/api/options", _options),
        at("/api/photo", photos.take, "POST"),
        at("/api/photo/{name}.jpg", photos.show),
        at("/api/photo/{name}", photos.about),
        at("/api/photo/{name}", photos.drop, "DELETE"),
        at("/api/photo/{name}/face", photos.place_face, "POST"),
        at("/api/drawing", drawings.keep, "POST"),
        at("/api/drawings", drawings.recent),
        at("/api/drawing/{name}.lines", drawings.lines),
        at("/api/drawing/{name}", drawings.drop, "DELETE"),
        at("/api/export/{file}", drawings.export),
        at("/api/robot/{name}.json", drawings.robot),
        at("/api/robot/{name}.urdf", drawings.urdf),
        at("/api/job", machine.job),
        at("/api/job", machine.start, "POST"),
        at("/api/job/check", machine.check, "POST"),
        at("/api/job/{command}", machine.command, "POST"),
        at("/api/targets", machine.targets),
        at("/api/booth", booth.about),
        at("/api/leave", booth.leave, "POST"),
        at("/api/queue", booth.queue),
        at("/api/queue", booth.join, "POST"),
        at("/api/queue/{entry}", booth.withdraw, "DELETE"),
        at("/api/operator/queue", booth.overview),
        at("/api/operator/targets", machine.targets),
        at("/api/operator/options", _options),
        at("/api/operator/drawing/{entry}.lines", booth.lines),
        at("/api/operator/target", booth.target, "POST"),
        at("/api/operator/remove", booth.remove, "POST"),
        at("/api/operator/{command}", booth.command, "POST"),
        WebSocketRoute("/ws", functools.partial(_socket, studio=studio)),
        WebSocketRoute("/ws/operator", functools.partial(_socket, studio=studio)),
        *([Mount("/", StaticFiles(directory=PAGE))] if PAGE.is_dir() else []),
    ]
    errors: dict[Any, Any] = {LimnerError: _limner_error, HTTPException: _http_error, Exception: _bug}
    described = document(routes)
    routes.insert(0, Route("/api/openapi.json", lambda request: JSONResponse(described)))
    app = Starlette(routes=routes, lifespan=life, exception_handlers=errors)
    return Guard(app, studio.visitors, tokens, names)


async def _page(request: Request, *, name: str) -> Response:
    if not os.path.exists(PAGE / name):
        return PlainTextResponse(f"limner studio: {name} is not in this installation\n", 404)
    return FileResponse(PAGE / name)


@describe("Anything")
async def _options(studio: Studio, visitor: Visitor, request: Request) -> Response:
    """All that the page offers: settings, sliders, presets, styles, machines, formats."""
    return JSONResponse(await studio.computer.ask("options"))


async def _limner_error(request: Request, error: LimnerError) -> Response:
    own = {NotThere: 404, WrongState: 409}
    status = own.get(type(error)) or {2: 400, 3: 422, 4: 422, 5: 502}.get(error.exit_code, 500)
    return JSONResponse({"error": str(error)}, status)


async def _http_error(request: Request, error: HTTPException) -> Response:
    return JSONResponse({"error": error.detail}, error.status_code, headers=dict(error.headers or {}))


async def _bug(request: Request, error: Exception) -> Response:
    """One line for who asked; the server tells the rest in its terminal."""
    return JSONResponse({"error": f"a bug in limner: {type(error).__name__}; report it"}, 500)


async def _socket(socket: WebSocket, *, studio: Studio) -> None:
    await socket.accept()
    turn = asyncio.Lock()

    async def say(message: dict[str, Any], frame: bytes | None) -> None:
        async with turn:
            await socket.send_text(json.dumps(message))
            if frame is not None:
                await socket.send_bytes(frame)

    live, listener = Live(studio, socket.scope["visitor"], say), Listener(socket.scope["visitor"], say)
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
