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
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.websockets import WebSocket, WebSocketDisconnect

from limner.errors import BadInput, LimnerError
from limner.studio.guard import Guard
from limner.studio.live import Live
from limner.studio.studio import NotThere, Studio, photo_of
from limner.studio.visitors import Visitor

UPLOAD_BYTES = 40 * 2**20
"""A larger photo is refused."""

BODY_BYTES = 2**20
"""Likewise any other request."""

MESSAGE_BYTES = 2**18
"""And a message of the WebSocket."""

PAGE = Path(str(resources.files("limner.studio") / "page"))
"""The page's own files."""

Handler = Callable[[Studio, Visitor, Request], Awaitable[Response]]


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
        try:
            yield
        finally:
            await studio.computer.close()

    def at(path: str, handler: Handler, *methods: str) -> Route:
        async def endpoint(request: Request) -> Response:
            return await handler(studio, request.scope["visitor"], request)

        return Route(path, functools.wraps(handler)(endpoint), methods=list(methods) or ["GET"])

    routes = [
        Route("/", functools.partial(_page, name="booth.html" if studio.booth else "index.html")),
        Route("/operator", functools.partial(_page, name="operator.html")),
        at("/api/options", _options),
        at("/api/photo", _take_photo, "POST"),
        at("/api/photo/{name}.jpg", _photo),
        at("/api/photo/{name}", _drop_photo, "DELETE"),
        at("/api/photo/{name}/face", _place_face, "POST"),
        WebSocketRoute("/ws", functools.partial(_socket, studio=studio)),
        *([Mount("/", StaticFiles(directory=PAGE))] if PAGE.is_dir() else []),
    ]
    errors = {LimnerError: _limner_error, HTTPException: _http_error}
    app = Starlette(routes=routes, lifespan=life, exception_handlers=errors)  # type: ignore[arg-type]
    return Guard(app, studio.visitors, tokens, names)


async def _page(request: Request, *, name: str) -> Response:
    if not os.path.exists(PAGE / name):
        return PlainTextResponse(f"limner studio: {name} is not in this installation\n", 404)
    return FileResponse(PAGE / name)


async def _options(studio: Studio, visitor: Visitor, request: Request) -> Response:
    return JSONResponse(await studio.computer.ask("options"))


async def _take_photo(studio: Studio, visitor: Visitor, request: Request) -> Response:
    """Take a photo in: the bytes of its file are the body."""
    held = await studio.take(visitor, await body(request, UPLOAD_BYTES, "a photo"))
    return JSONResponse(held.about)


async def _photo(studio: Studio, visitor: Visitor, request: Request) -> Response:
    """The photo as it is shown: upright, no larger than it is worked on."""
    return Response(photo_of(visitor, request.path_params["name"]).jpeg, media_type="image/jpeg")


async def _drop_photo(studio: Studio, visitor: Visitor, request: Request) -> Response:
    """Let go of a photo."""
    if not visitor.photos.drop(request.path_params["name"]):
        raise NotThere("no such photo here")
    return Response(status_code=204)


async def _place_face(studio: Studio, visitor: Visitor, request: Request) -> Response:
    """A face by its place in the photo's faces, by 68 places, or by a box that a template is laid into."""
    held = photo_of(visitor, request.path_params["name"])
    wanted = await json_object(request)
    faces = held.about["faces"]
    if "index" in wanted:
        index = wanted["index"]
        if type(index) is not int or not 0 <= index < len(faces):
            raise BadInput(f"index: expected one of the photo's {len(faces)} faces, from 0")
        return JSONResponse({"face": faces[index]})
    size = (held.about["width"], held.about["height"])
    face = await studio.computer.ask("place", wanted=wanted, size_px=size)
    return JSONResponse({"face": face})


async def json_object(request: Request) -> dict[str, Any]:
    """The JSON object in a request's body; an empty body is an empty object.

    Raises:
        BadInput: it holds something else.
    """
    data = await body(request, BODY_BYTES, "a request")
    try:
        given = json.loads(data or b"{}")
    except (ValueError, RecursionError) as error:
        raise BadInput(f"expected a JSON object as the body ({error})") from error
    if not isinstance(given, dict):
        raise BadInput("expected a JSON object as the body")
    return given


async def body(request: Request, most: int, what: str) -> bytes:
    """The body of a request, read only as far as it may be long.

    Raises:
        HTTPException: 413.
    """
    text = f"larger than {most / 2**20:g} MB, the limit for {what}; make it smaller"
    length = request.headers.get("content-length", "0")
    if not length.isdecimal() or int(length) > most:
        raise HTTPException(413, text)
    parts, size = [], 0
    async for part in request.stream():
        size += len(part)
        if size > most:
            raise HTTPException(413, text)
        parts.append(part)
    return b"".join(parts)


async def _limner_error(request: Request, error: LimnerError) -> Response:
    status = 404 if isinstance(error, NotThere) else {2: 400, 3: 422, 4: 422, 5: 502}.get(error.exit_code, 500)
    return JSONResponse({"error": str(error)}, status)


async def _http_error(request: Request, error: HTTPException) -> Response:
    return JSONResponse({"error": error.detail}, error.status_code, headers=dict(error.headers or {}))


async def _socket(socket: WebSocket, *, studio: Studio) -> None:
    await socket.accept()
    turn = asyncio.Lock()

    async def say(message: dict[str, Any], frame: bytes | None) -> None:
        async with turn:
            await socket.send_text(json.dumps(message))
            if frame is not None:
                await socket.send_bytes(frame)

    live = Live(studio, socket.scope["visitor"], say)
    running = asyncio.create_task(live.run())
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
        running.cancel()
        with contextlib.suppress(asyncio.CancelledError, WebSocketDisconnect, RuntimeError):
            await running
