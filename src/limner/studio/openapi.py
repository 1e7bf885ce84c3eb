"""The routes of the studio go in; their description for programs comes out (OpenAPI 3.1)."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterable
from typing import Any, TypeVar

from starlette.routing import BaseRoute, Route

from limner import __version__

Handler = TypeVar("Handler", bound=Callable[..., Any])
Schema = dict[str, Any]

TEXT: Schema = {"type": "string"}
NUMBER: Schema = {"type": "number"}
MAYBE_TEXT: Schema = {"type": ["string", "null"]}
POINTS: Schema = {
    "type": "array",
    "minItems": 68,
    "maxItems": 68,
    "items": {"type": "array", "minItems": 2, "maxItems": 2, "items": NUMBER},
}
BOX: Schema = {"type": "array", "minItems": 4, "maxItems": 4, "items": NUMBER}


def thing(required: Iterable[str] = (), **properties: Schema) -> Schema:
    """The schema of an object; more properties are allowed."""
    return {"type": "object", "required": sorted(required), "properties": properties}


def listed(**lists: str) -> Schema:
    """The schema of an object of lists of known things."""
    return thing(lists, **{name: {"type": "array", "items": ref(what)} for name, what in lists.items()})


def ref(name: str) -> Schema:
    """One of ``SCHEMAS``."""
    return {"$ref": f"#/components/schemas/{name}"}


_FACE = thing(("points_px", "box_px"), box_px=BOX, score=NUMBER, yaw_deg=NUMBER, detector=TEXT)
_WISH = thing(
    ("photo",), photo=TEXT, face={"type": "integer", "minimum": 0, "maximum": 999}, settings={"type": "object"}
)

SCHEMAS: dict[str, Schema] = {
    "Error": thing(("error",), error=TEXT),
    "Face": _FACE,
    "Photo": thing(
        ("photo", "width", "height", "faces", "notes"),
        photo=TEXT,
        width={"type": "integer"},
        height={"type": "integer"},
        faces={"type": "array", "items": ref("Face")},
        notes={"type": "array", "items": TEXT},
        error=TEXT,
    ),
    "Wish": _WISH,
    "Drawing": thing(
        ("drawing", "photo", "report", "settings", "wish"),
        drawing=TEXT,
        photo=TEXT,
        report={"type": "object"},
        settings={"type": "object"},
        wish={"type": "object"},
    ),
    "Order": thing(
        ("drawing", "to"), drawing=TEXT, to=TEXT, machine=MAYBE_TEXT, robot=MAYBE_TEXT, frame_only={"type": "boolean"}
    ),
    "Job": thing(
        ("state", "may", "strokes", "stroke", "share", "seconds", "elapsed_s", "left_s", "mine"),
        state=TEXT,
        may={"type": "array", "items": TEXT},
        drawing=MAYBE_TEXT,
        target=TEXT,
        name=TEXT,
        strokes={"type": "integer"},
        stroke={"type": "integer"},
        share={"type": "number", "minimum": 0, "maximum": 1},
        seconds=NUMBER,
        elapsed_s=NUMBER,
        left_s=NUMBER,
        frame_only={"type": "boolean"},
        error=MAYBE_TEXT,
        said=TEXT,
        next_pen=TEXT,
        mine={"type": "boolean"},
    ),
    "Check": thing(
        ("name", "seconds", "strokes", "ready", "ask"),
        name=TEXT,
        seconds=NUMBER,
        strokes={"type": "integer"},
        ready=TEXT,
        ask={"type": "array", "items": TEXT},
    ),
    "Target": thing(("address", "kind", "label", "state"), address=TEXT, kind=TEXT, label=TEXT, state=TEXT, help=TEXT),
    "Entry": thing(
        ("entry", "name", "state", "place", "left_s", "mine"),
        entry=TEXT,
        name=TEXT,
        state=TEXT,
        place={"type": "integer"},
        left_s=NUMBER,
        mine={"type": "boolean"},
    ),
    "Anything": {"type": "object"},
}
"""What goes to and fro."""


def describe(
    answer: str | Schema | None = None, *, body: str | Schema | None = None, media: str = "", status: int = 200
) -> Callable[[Handler], Handler]:
    """Say of a handler what it takes and gives.

    Args:
        answer: schema, or the name of one, of what it gives as JSON; None: bytes, or nothing.
        body: of what it takes as JSON; None: nothing; "bytes": a file.
        media: type of what it gives instead of JSON; empty for nothing.
        status: of success.
    """

    def keep(handler: Handler) -> Handler:
        handler.__dict__["described"] = (answer, body, media, status)
        return handler

    return keep


def document(routes: Iterable[BaseRoute]) -> dict[str, Any]:
    """The description of all routes below ``/api``."""
    paths: dict[str, dict[str, Any]] = {}
    for route in routes:
        if isinstance(route, Route) and route.path.startswith("/api"):
            for method in sorted((route.methods or set()) - {"HEAD"}):
                paths.setdefault(route.path, {})[method.lower()] = _operation(route)
    return {
        "openapi": "3.1.0",
        "info": {"title": "limner studio", "version": __version__},
        "security": [{"cookie": []}],
        "paths": paths,
        "components": {
            "schemas": SCHEMAS,
            "securitySchemes": {"cookie": {"type": "apiKey", "in": "cookie", "name": "limner_visitor_PORT"}},
        },
    }


def _operation(route: Route) -> dict[str, Any]:
    answer, body, media, status = route.endpoint.__dict__.get("described", ("Anything", None, "", 200))
    done: dict[str, Any] = {"description": "done"}
    if answer is not None:
        done["content"] = {"application/json": {"schema": _schema(answer)}}
    elif media:
        done["content"] = {media: {"schema": {}}}
    wrong = {"description": "why not", "content": {"application/json": {"schema": ref("Error")}}}
    summary = (inspect.getdoc(route.endpoint) or "").partition("\n")[0]
    told: dict[str, Any] = {"summary": summary, "responses": {str(status): done, "4XX": wrong, "502": wrong}}
    if names := re.findall(r"{(\w+)}", route.path):
        told["parameters"] = [{"name": name, "in": "path", "required": True, "schema": TEXT} for name in names]
    if body == "bytes":
        told["requestBody"] = {"required": True, "content": {"application/octet-stream": {"schema": {}}}}
    elif body is not None:
        told["requestBody"] = {"required": True, "content": {"application/json": {"schema": _schema(body)}}}
    return told


def _schema(what: str | Schema) -> Schema:
    return ref(what) if isinstance(what, str) else what
