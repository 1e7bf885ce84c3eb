"""A request goes in; its body, within limits, comes out as bytes or as a JSON object."""

from __future__ import annotations

import json
from typing import Any

from starlette.exceptions import HTTPException
from starlette.requests import Request

from limner.errors import BadInput

UPLOAD_BYTES = 40 * 2**20
"""A larger photo is refused."""

BODY_BYTES = 2**20
"""Likewise any other request."""

_DIGITS = 20  # of a length; thousands would be no number to Python


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
    if not length.isdecimal() or len(length) > _DIGITS or int(length) > most:
        raise HTTPException(413, text)
    parts, size = [], 0
    async for part in request.stream():
        size += len(part)
        if size > most:
            raise HTTPException(413, text)
        parts.append(part)
    return b"".join(parts)
