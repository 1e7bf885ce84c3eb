"""Requests of guests and of the operator of a booth go in; their place in the queue, and what he commands, come out."""

from __future__ import annotations

from typing import Any

from starlette.requests import Request
from starlette.responses import JSONResponse, Response

from limner.errors import BadInput
from limner.studio.bodies import json_object
from limner.studio.machine import commands, order_of
from limner.studio.openapi import MAYBE_TEXT, TEXT, describe, listed, thing
from limner.studio.orders import NotThere
from limner.studio.queue import Goal, Queue
from limner.studio.studio import Studio, drawing_of
from limner.studio.visitors import DRAWINGS, PHOTOS, Recent, Visitor

COUNTDOWN_S, RESET_S, TICKET_S, CANDIDATES = 3, 60, 20, 3
"""How the page of a booth behaves: seconds before the photo, of idleness before the next guest, of that once this one
has his place in the queue; drawings to choose."""


def queue_of(studio: Studio) -> Queue:
    """The queue.

    Raises:
        NotThere: this is no booth.
    """
    if studio.queue is None:
        raise NotThere("this is no booth; start it with limner studio --booth")
    return studio.queue


@describe("Anything")
async def about(studio: Studio, visitor: Visitor, request: Request) -> Response:
    """How the page of the booth behaves."""
    queue_of(studio)
    return JSONResponse(
        {"countdown_s": COUNTDOWN_S, "reset_s": RESET_S, "ticket_s": TICKET_S, "candidates": CANDIDATES}
    )


@describe(status=204)
async def leave(studio: Studio, visitor: Visitor, request: Request) -> Response:
    """A guest leaves: his photos and drawings are let go of; what he queued stays until it is drawn."""
    visitor.photos, visitor.drawings = Recent(PHOTOS), Recent(DRAWINGS)
    return Response(status_code=204)


@describe(listed(queue="Entry"))
async def queue(studio: Studio, visitor: Visitor, request: Request) -> Response:
    """The queue, and what the machine does."""
    line = queue_of(studio)
    return JSONResponse({"queue": line.fields(visitor), "held": line.held, "job": studio.jobs.fields(visitor)})


@describe("Entry", body=thing(("drawing",), drawing=TEXT, name=TEXT), status=201)
async def join(studio: Studio, visitor: Visitor, request: Request) -> Response:
    """Queue a drawing."""
    line, given = queue_of(studio), await json_object(request)
    entry = line.add(visitor, drawing_of(visitor, given.get("drawing")), given.get("name") or "")
    told = next(item for item in line.fields(visitor) if item["entry"] == entry.key)
    return JSONResponse(told, 201)


@describe(status=204)
async def withdraw(studio: Studio, visitor: Visitor, request: Request) -> Response:
    """Take back one's own drawing."""
    queue_of(studio).remove(request.path_params["entry"], visitor)
    return Response(status_code=204)


@describe(listed(queue="Entry"))
async def overview(studio: Studio, operator: Visitor, request: Request) -> Response:
    """What the operator sees."""
    return _overview(studio, operator)


def _overview(studio: Studio, operator: Visitor) -> Response:
    line = queue_of(studio)
    goal = {"to": line.goal.to, "machine": line.goal.machine, "robot": line.goal.robot}
    told: dict[str, Any] = {"queue": line.fields(operator), "held": line.held, "job": studio.jobs.fields(operator)}
    return JSONResponse(told | goal)


@describe(media="application/octet-stream")
async def lines(studio: Studio, operator: Visitor, request: Request) -> Response:
    """The frame of lines of a drawing in the queue."""
    held = queue_of(studio).entry(request.path_params["entry"]).held
    frame = await studio.computer.ask("lines", npz=held.npz)
    return Response(frame, media_type="application/octet-stream")


@describe(listed(queue="Entry"), body=thing(("to",), to=TEXT, machine=MAYBE_TEXT, robot=MAYBE_TEXT))
async def target(studio: Studio, operator: Visitor, request: Request) -> Response:
    """Choose the machine of the booth."""
    line, given = queue_of(studio), await json_object(request)
    order = order_of(given, {})
    line.goal = Goal(order.to, order.machine, order.robot)
    return _overview(studio, operator)


@describe(listed(queue="Entry"), body=thing(("entry",), entry=TEXT))
async def remove(studio: Studio, operator: Visitor, request: Request) -> Response:
    """Take anybody's drawing out of the queue."""
    line, given = queue_of(studio), await json_object(request)
    if not isinstance(given.get("entry"), str):
        raise BadInput("entry: expected the key of one in the queue")
    line.remove(given["entry"])
    return _overview(studio, operator)


@describe(listed(queue="Entry"))
async def command(studio: Studio, operator: Visitor, request: Request) -> Response:
    """Begin the next, hold or release the queue, skip, or command the machine."""
    line, name = queue_of(studio), request.path_params["command"]
    own = {"hold": lambda: line.hold(True), "release": lambda: line.hold(False), "skip": line.skip}
    known = own | commands(studio.jobs)
    if name == "next":
        await line.next()
    elif name in known:
        known[name]()
    else:
        raise NotThere(f"no such command; choose next, {', '.join(known)}")
    return _overview(studio, operator)
