"""The server's parts go in; what is answered at which address comes out: pages, the interface for programs, sockets."""

from __future__ import annotations

import functools
import os
from collections.abc import Awaitable, Callable
from importlib import resources
from pathlib import Path

from starlette.requests import Request
from starlette.responses import FileResponse, JSONResponse, PlainTextResponse, Response
from starlette.routing import BaseRoute, Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles

from limner.studio import booth, drawings, machine, photos
from limner.studio.openapi import describe, document
from limner.studio.studio import Studio
from limner.studio.talk import talk
from limner.studio.visitors import Visitor

PAGE = Path(str(resources.files("limner.studio") / "page"))
"""The page's own files."""

Handler = Callable[[Studio, Visitor, Request], Awaitable[Response]]


@describe("Anything")
async def _options(studio: Studio, visitor: Visitor, request: Request) -> Response:
    """All that the page offers: settings, sliders, presets, styles, machines, formats."""
    return JSONResponse(await studio.computer.ask("options"))


API: tuple[tuple[str, str, Handler], ...] = (
    ("GET", "/api/options", _options),
    ("POST", "/api/photo", photos.take),
    ("GET", "/api/photo/{name}.jpg", photos.show),
    ("GET", "/api/photo/{name}", photos.about),
    ("DELETE", "/api/photo/{name}", photos.drop),
    ("POST", "/api/photo/{name}/face", photos.place_face),
    ("POST", "/api/drawing", drawings.keep),
    ("GET", "/api/drawings", drawings.recent),
    ("GET", "/api/drawing/{name}.lines", drawings.lines),
    ("DELETE", "/api/drawing/{name}", drawings.drop),
    ("GET", "/api/export/{file}", drawings.export),
    ("GET", "/api/robot/{name}.json", drawings.robot),
    ("GET", "/api/robot/{name}.urdf", drawings.urdf),
    ("GET", "/api/job", machine.job),
    ("POST", "/api/job", machine.start),
    ("POST", "/api/job/check", machine.check),
    ("POST", "/api/job/{command}", machine.command),
    ("GET", "/api/targets", machine.targets),
    ("GET", "/api/booth", booth.about),
    ("POST", "/api/leave", booth.leave),
    ("GET", "/api/queue", booth.queue),
    ("POST", "/api/queue", booth.join),
    ("DELETE", "/api/queue/{entry}", booth.withdraw),
    ("GET", "/api/operator/queue", booth.overview),
    ("GET", "/api/operator/targets", machine.targets),
    ("GET", "/api/operator/options", _options),
    ("GET", "/api/operator/drawing/{entry}.lines", booth.lines),
    ("POST", "/api/operator/target", booth.target),
    ("POST", "/api/operator/remove", booth.remove),
    ("POST", "/api/operator/{command}", booth.command),
)
"""Method, address and handler; where two fit, the first answers."""


def routes(studio: Studio) -> list[BaseRoute]:
    """All addresses; those for programs are described at ``/api/openapi.json``."""
    programs = [_route(studio, *each) for each in API]
    described = document(programs)
    return [
        Route("/api/openapi.json", lambda request: JSONResponse(described)),
        Route("/", functools.partial(_page, name="booth.html" if studio.booth else "index.html")),
        Route("/operator", functools.partial(_page, name="operator.html")),
        *programs,
        *(WebSocketRoute(path, functools.partial(talk, studio=studio)) for path in ("/ws", "/ws/operator")),
        *([Mount("/", StaticFiles(directory=PAGE))] if PAGE.is_dir() else []),
    ]


def _route(studio: Studio, method: str, path: str, handler: Handler) -> Route:
    async def endpoint(request: Request) -> Response:
        return await handler(studio, request.scope["visitor"], request)

    return Route(path, functools.wraps(handler)(endpoint), methods=[method])


async def _page(request: Request, *, name: str) -> Response:
    if not os.path.exists(PAGE / name):
        return PlainTextResponse(f"limner studio: {name} is not in this installation\n", 404)
    return FileResponse(PAGE / name)
