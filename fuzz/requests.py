"""A request to the studio goes in, as a browser or a stranger would send it; the guarded application answers it."""

from __future__ import annotations

import asyncio
import json
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from fuzz.contract import Broken
from fuzz.journals import DRAWING
from limner import storage
from limner.errors import BadInput
from limner.pipeline import Settings
from limner.studio.app import assembled, build
from limner.studio.exports import FORMATS
from limner.studio.orders import Made, Order
from limner.studio.plans import known
from limner.studio.studio import Studio
from limner.studio.visitors import HeldDrawing, HeldPhoto, Visitor

PORT, TOKEN = 9000, "token"
NPZ = storage.to_npz(DRAWING)
ABOUT = {"report": {"seconds": 1.0}, "settings": Settings().to_dict()}
FOUND = {"photo": "p", "width": 400, "height": 300, "faces": [], "notes": []}


class _Computer:
    """Has everything computed at once, to nothing."""

    async def ask(self, task: str, urgency: int = 0, /, **arguments: Any) -> Any:
        """What a page may ask of the computing process: named, and of plain data."""
        if task == "export":
            known(arguments["kind"], FORMATS, "format")
        if task in ("lines", "prepared", "export", "urdf"):
            return NPZ
        if task in ("options", "place", "robot"):
            return {}
        if task in ("keep", "draw"):
            return {"about": ABOUT, "npz": NPZ, "report": {}, "frame": b"", "settings": {}}
        return {"data": b"", "jpeg": b"", "about": FOUND, "plan": {}}


def _made(order: Order, path: str) -> Made:
    raise BadInput("there is no machine")


def _studio(folder: Path) -> tuple[Any, str]:
    """A booth with a guest and an operator in it, who have a photo and a drawing, and their cookies."""
    studio: Studio = assembled(Settings().to_dict(), _made, PORT, folder, queued=True)
    studio.computer = studio.planner = _Computer()
    cookies = []
    for role in ("visitor", "operator"):
        cookie = studio.visitors.enter(role)
        visitor = studio.visitors.known(role, cookie)
        assert isinstance(visitor, Visitor)
        visitor.photos.add("p", HeldPhoto("p", b"", b"", FOUND))
        visitor.drawings.add("d", HeldDrawing("d", "p", NPZ, ABOUT))
        cookies.append(f"{studio.visitors.cookie_name(role)}={cookie}")
    return build(studio, {"visitor": TOKEN, "operator": TOKEN}, {"localhost"}), "; ".join(cookies)


def request(data: bytes) -> None:
    """Method, path and query in the first line, headers up to an empty one, then the body: no answer is a bug's."""
    head, _, body = data.partition(b"\n\n")
    first, *lines = head.split(b"\n")
    method, _, target = first.partition(b" ")
    path, _, query = target.partition(b"?")
    headers = [(b"host", b"localhost"), *(_header(line) for line in lines)]
    with TemporaryDirectory() as folder:
        app, cookie = _studio(Path(folder))
        headers = [(name, value.replace(b"COOKIE", cookie.encode())) for name, value in headers]
        scope = {"type": "http", "method": method.decode("latin-1"), "path": _path(path), "query_string": query}
        sent = asyncio.run(_answered(app, scope | {"headers": headers}, [{"type": "http.request", "body": body}]))
    status = sent[0]["status"]
    if status >= 500 and status != 502:
        raise Broken(f"answered with {status}")
    kinds = dict(sent[0]["headers"])
    assert b"content-security-policy" in kinds
    if kinds.get(b"content-type") == b"application/json":
        json.loads(b"".join(message.get("body", b"") for message in sent[1:]))


def _header(line: bytes) -> tuple[bytes, bytes]:
    name, _, value = line.partition(b": ")
    return name.lower(), value


def _path(path: bytes) -> str:
    """As servers hand it on: unquoted, from the root."""
    return "/" + path.decode("utf-8", "replace").lstrip("/")


async def _answered(app: Any, scope: dict[str, Any], messages: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """What an application sends for a request, until it is done or waits for ever."""
    sent: list[dict[str, Any]] = []
    rest = iter(messages)

    async def receive() -> dict[str, Any]:
        for _ in range(5):  # what the message before began goes on meanwhile
            await asyncio.sleep(0)
        for message in rest:
            return message
        return {"type": f"{scope['type']}.disconnect"}

    async def send(message: dict[str, Any]) -> None:
        sent.append(message)

    await app(scope | {"scheme": "http", "server": ("localhost", PORT), "root_path": ""}, receive, send)
    return sent


def sockets(data: bytes) -> None:
    """Messages of a page through its socket, one on each line; what begins with a NUL comes as bytes."""
    said = [{"type": "websocket.connect"}]
    for line in data.split(b"\n")[:20]:
        text = {"bytes": line} if line[:1] == b"\0" else {"text": line.decode("utf-8", "replace")}
        said.append({"type": "websocket.receive"} | text)
    with TemporaryDirectory() as folder:
        app, cookie = _studio(Path(folder))
        headers = [(b"host", b"localhost"), (b"origin", b"http://localhost"), (b"cookie", cookie.encode())]
        scope = {"type": "websocket", "path": "/ws", "query_string": b"", "headers": headers, "subprotocols": []}
        sent = asyncio.run(_answered(app, scope, said))
    assert sent[0]["type"] == "websocket.accept"
    for message in sent[1:]:
        if message.get("text"):
            json.loads(message["text"], parse_constant=_no_number)


def _no_number(name: str) -> float:
    raise Broken(f"says {name}, which is no JSON")


HARNESSES = {"request": request, "socket": sockets}
