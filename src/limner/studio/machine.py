"""Requests about the machine go in: start, pause, stop; what it does, what may be done and where machines are, out."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any

from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import JSONResponse, Response

from limner.errors import BadInput, MissingExtra
from limner.studio.bodies import json_object
from limner.studio.jobs import Jobs
from limner.studio.openapi import describe, listed
from limner.studio.orders import NotThere, Order
from limner.studio.studio import Studio, drawing_of
from limner.studio.visitors import HeldDrawing, Visitor

CHECKLIST = {
    "plotter": ("The paper lies and is held.", "The pen is in the machine.", "Nobody reaches into it."),
    "arm": (
        "The sheet lies where it was planned.",
        "Nobody is within reach of the arm.",
        "The stop button is at hand.",
    ),
}
"""What people confirm before a machine moves."""

SIMULATORS = (
    ("sim:", "plotter", "A simulated plotter", "at the machine's own pace"),
    ("sim:20", "plotter", "A simulated plotter, fast", "twenty times as fast"),
    ("sim:", "arm", "A simulated arm", "with servos, gravity and a sprung pen, at its own pace"),
    ("sim:20", "arm", "A simulated arm, fast", "up to twenty times as fast"),
)
"""Machines that are always there."""


NOTHING_SAID = "a serial port that does not say what is plugged in"


@describe("Job")
async def job(studio: Studio, visitor: Visitor, request: Request) -> Response:
    """What the machine does."""
    return _told(studio, visitor)


def _told(studio: Studio, visitor: Visitor) -> Response:
    return JSONResponse(studio.jobs.fields(visitor))


@describe(listed(targets="Target"))
async def targets(studio: Studio, visitor: Visitor, request: Request) -> Response:
    """Where machines are."""
    simulated = [
        {"address": address, "kind": kind, "label": label, "state": "ready", "help": about}
        for address, kind, label, about in SIMULATORS
    ]
    return JSONResponse({"targets": simulated + await asyncio.to_thread(_ports)})


def _ports() -> list[dict[str, str]]:
    from limner.targets.serial_link import ports

    try:
        found = ports()
    except MissingExtra as error:
        about = {"address": "", "kind": "plotter", "label": "Serial plotters"}
        return [about | {"state": "not connected", "help": str(error)}]
    return [
        {
            "address": f"{'ebb' if axidraw else 'grbl'}:{name}",
            "kind": "plotter",
            "label": f"{'AxiDraw' if axidraw else 'GRBL plotter'} at {name}",
            "state": "ready",
            # What the system says of a bare port.
            "help": NOTHING_SAID if about in ("", "n/a") else about,
        }
        for name, about, axidraw in found
    ]


@describe("Job", body="Order", status=201)
async def start(studio: Studio, visitor: Visitor, request: Request) -> Response:
    """Have a drawing drawn."""
    _not_in_a_booth(studio, visitor)
    given = await json_object(request)
    held = drawing_of(visitor, given.get("drawing"))
    order = order_of(given, held.about["settings"])
    studio.jobs.check("start")
    data = await prepared(studio, held, order)
    studio.jobs.start(order, data, held, visitor)
    return JSONResponse(studio.jobs.fields(visitor), 201)


@describe("Check", body="Order")
async def check(studio: Studio, visitor: Visitor, request: Request) -> Response:
    """What would be started, and what must be so before it is; nothing moves."""
    given = await json_object(request)
    held = drawing_of(visitor, given.get("drawing"))
    order = order_of(given, held.about["settings"])
    made = await studio.jobs.try_out(order, await prepared(studio, held, order))
    kind = "arm" if order.robot else "plotter"
    told = {"name": made.name, "seconds": float(made.seconds), "strokes": len(made.begins_s), "ready": made.ready}
    return JSONResponse(told | {"ask": list(CHECKLIST[kind])})


@describe("Job")
async def command(studio: Studio, visitor: Visitor, request: Request) -> Response:
    """Pause, resume, cancel or clear."""
    _not_in_a_booth(studio, visitor)
    done = commands(studio.jobs).get(request.path_params["command"])
    if done is None:
        raise NotThere("no such command; choose pause, resume, cancel or clear")
    done()
    return _told(studio, visitor)


def commands(jobs: Jobs) -> dict[str, Callable[[], None]]:
    """What the machine can be told while it has a job."""
    return {"pause": jobs.pause, "resume": jobs.resume, "cancel": jobs.cancel, "clear": jobs.clear}


def _not_in_a_booth(studio: Studio, visitor: Visitor) -> None:
    if studio.booth and visitor.role != "operator":
        raise HTTPException(403, "in a booth only its operator commands the machine; queue the drawing")


def order_of(given: dict[str, Any], settings: dict[str, Any]) -> Order:
    """An order from what the page asks for.

    Args:
        given: the request.
        settings: tree of the drawing's, or none yet.

    Raises:
        BadInput: no address, or something else where a name belongs.
    """
    to, machine, robot = (given.get(name) or None for name in ("to", "machine", "robot"))
    if not isinstance(to, str) or len(to) > 300:
        raise BadInput("to: expected the address of a machine, such as sim: or grbl:/dev/ttyUSB0")
    for name, value in (("machine", machine), ("robot", robot)):
        if value is not None and (not isinstance(value, str) or value.lower().endswith((".toml", ".urdf"))):
            raise BadInput(f"{name}: expected one of the names that the menu offers")
    if machine is None and to.startswith("sim:"):
        machine = settings.get("machine")
    return Order(to, machine, robot, settings, bool(given.get("frame_only")))


async def prepared(studio: Studio, held: HeldDrawing, order: Order) -> bytes:
    """What is sent of a drawing: itself, or an arm's motion; or its frame."""
    found: bytes = await studio.planner.ask(
        "prepared", npz=held.npz, robot=order.robot, settings=order.settings, frame_only=order.frame_only
    )
    return found
