"""What a page may send to the studio goes in: bodies of requests and messages of its socket."""

from __future__ import annotations

import asyncio
import json
from typing import Any

from starlette.exceptions import HTTPException
from starlette.requests import Request

from limner.errors import LimnerError
from limner.pipeline import Settings
from limner.studio.bodies import json_object
from limner.studio.live import checked_wish, parse_wish
from limner.studio.plans import known
from limner.studio.wishes import face_of, settings_of, template


def wish(data: bytes) -> None:
    """A message of the socket, and what the computing process makes of it before it draws."""
    _prepared(parse_wish(data.decode("utf-8", "replace")))


def _prepared(given: dict[str, Any]) -> None:
    settings_of(Settings(), given["settings"])
    if given["points_px"] is not None:
        face_of(given["points_px"], (400, 400))
    known(given["plan"].get("machine"), ("axidraw",), "machine")


def body(data: bytes) -> None:
    """The body of a request that places a face or keeps a drawing; its answer can be written as JSON."""

    async def receive() -> dict[str, Any]:
        return {"type": "http.request", "body": data, "more_body": False}

    try:
        given = asyncio.run(json_object(Request({"type": "http", "headers": []}, receive)))
        if "box_px" in given or "points_px" in given:
            points = given.get("points_px")
            face_of(template(given.get("box_px")) if points is None else points, (400, 400))
        else:
            _prepared(checked_wish(given))
    except HTTPException:
        return
    except LimnerError as error:
        json.dumps({"error": str(error)}, ensure_ascii=False).encode()
        raise


HARNESSES = {"wish": wish, "body": body}
