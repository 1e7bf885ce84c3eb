"""Requests about drawings go in: to keep one, to save one as a file, to see a robot; data and files come out."""

from __future__ import annotations

from starlette.requests import Request
from starlette.responses import JSONResponse, Response

from limner.studio.bodies import json_object
from limner.studio.computer import SOON
from limner.studio.live import checked_wish
from limner.studio.openapi import describe, listed
from limner.studio.orders import NotThere
from limner.studio.studio import Studio, drawing_of
from limner.studio.visitors import Visitor

MEDIA = {"svg": "image/svg+xml", "png": "image/png", "gif": "image/gif", "mp4": "video/mp4", "json": "application/json"}
"""Of formats that browsers know; the rest are bytes."""

PICTURE = "picture.png"
"""What a style in colours makes of the photo before there are lines; it needs the photo, so it is no format."""


@describe("Drawing", body="Wish", status=201)
async def keep(studio: Studio, visitor: Visitor, request: Request) -> Response:
    """Keep the drawing of a wish, for sending and saving."""
    held = await studio.keep(visitor, checked_wish(await json_object(request)))
    return JSONResponse(held.about, 201)


@describe(listed(drawings="Drawing"))
async def recent(studio: Studio, visitor: Visitor, request: Request) -> Response:
    """The drawings that were kept, the latest first."""
    return JSONResponse({"drawings": [held.about for held in visitor.drawings.latest()]})


@describe(media="application/octet-stream")
async def lines(studio: Studio, visitor: Visitor, request: Request) -> Response:
    """The frame of lines of a drawing that was kept."""
    held = drawing_of(visitor, request.path_params["name"])
    frame = await studio.computer.ask("lines", npz=held.npz)
    return Response(frame, media_type="application/octet-stream")


@describe(status=204)
async def drop(studio: Studio, visitor: Visitor, request: Request) -> Response:
    """Let go of a drawing."""
    if not visitor.drawings.drop(request.path_params["name"]):
        raise NotThere("no such drawing here")
    return Response(status_code=204)


@describe(media="*/*")
async def export(studio: Studio, visitor: Visitor, request: Request) -> Response:
    """A drawing that was kept, as a file."""
    name, _, kind = request.path_params["file"].partition(".")
    held = drawing_of(visitor, name)
    saved = {"Content-Disposition": f'attachment; filename="portrait.{kind}"'}
    if kind == PICTURE:
        wish = checked_wish(held.about["wish"] | {"photo": held.photo})
        data = await studio.compute(visitor, "picture", wish, SOON, slow=True)
        return Response(data, media_type="image/png", headers=saved)
    by = {name: request.query_params.get(name) for name in ("machine", "robot")}
    data = await studio.planner.ask("export", SOON, npz=held.npz, kind=kind, settings=held.about["settings"], **by)
    return Response(data, media_type=MEDIA.get(kind, "application/octet-stream"), headers=saved)


@describe("Anything")
async def robot(studio: Studio, visitor: Visitor, request: Request) -> Response:
    """A robot's joints and shapes."""
    return JSONResponse(await studio.planner.ask("robot", name=request.path_params["name"]))


@describe(media="application/xml")
async def urdf(studio: Studio, visitor: Visitor, request: Request) -> Response:
    """A robot's URDF."""
    return Response(await studio.planner.ask("urdf", name=request.path_params["name"]), media_type="application/xml")
