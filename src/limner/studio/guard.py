"""A request goes in; it reaches the studio if it comes from its own page, with a cookie, by its own name, or nowhere.

Loopback alone protects nobody: any page in another tab can reach it. So every request, WebSockets too, must name this
server in Host (else a stranger's name may have been bound to this address), must come from this server's page (Origin,
Sec-Fetch-Site), and must carry the cookie that only a visit with the printed token sets.
"""

from __future__ import annotations

import ipaddress
import secrets
from collections.abc import Iterable
from urllib.parse import parse_qs, urlencode

from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import cookie_parser
from starlette.responses import JSONResponse, PlainTextResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from limner.studio.visitors import Visitors

CSP = (
    "default-src 'self'; img-src 'self' blob:; media-src 'self' blob:; style-src 'self'; frame-ancestors 'none';"
    " base-uri 'none'; form-action 'none'"
)
"""What the page may load: nothing from elsewhere, no script or style within the page itself."""

HEADERS = {
    "content-security-policy": CSP,
    "x-content-type-options": "nosniff",
    "x-frame-options": "DENY",
    "referrer-policy": "no-referrer",
    "cross-origin-resource-policy": "same-origin",
    "cross-origin-opener-policy": "same-origin",
    "cache-control": "no-store",
}
"""Of every answer."""

OPERATOR = ("/operator", "/api/operator", "/ws/operator")
"""What only the operator of a booth may see and do."""

_DOORS = {"/": "visitor", "/operator": "operator"}


class Guard:
    """The middleware around everything.

    Attributes:
        visitors: who has a cookie.
    """

    def __init__(self, app: ASGIApp, visitors: Visitors, tokens: dict[str, str], names: Iterable[str]) -> None:
        """Stand before an app.

        Args:
            app: what is guarded.
            visitors: who has a cookie; new ones are added here.
            tokens: of each role, ``visitor`` and perhaps ``operator``: who brings it gets a cookie.
            names: hosts this server is called by; any address goes too when it contains ``*``.
        """
        self._app, self.visitors, self._tokens = app, visitors, tokens
        self._names = {name.lower() for name in names}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Let a request through, or answer it here."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        answer = self._refusal(scope) or self._entrance(scope) or self._stranger(scope)
        if answer is not None:
            await answer(scope, receive, _with_headers(send))
            return
        await self._app(scope, receive, _with_headers(send))

    def _refusal(self, scope: Scope) -> Response | None:
        """400 for another name, 403 for another page."""
        headers = Headers(scope=scope)
        if not self._is_own_name(headers.get("host", "")):
            return _refused(scope, "this server is not called that; open the address that limner studio printed", 400)
        origin = headers.get("origin")
        if origin is None:
            # A browser sends Origin with every WebSocket; so what has none hides it.
            foreign = scope["type"] == "websocket"
        else:
            foreign = origin.lower() not in {f"{kind}://{headers['host'].lower()}" for kind in ("http", "https")}
        site = headers.get("sec-fetch-site", "none")
        entering = scope["type"] == "http" and scope["method"] == "GET" and scope["path"] in _DOORS
        if foreign or (site not in ("same-origin", "none") and not entering):
            return _refused(scope, "another page may not do this", 403)
        return None

    def _is_own_name(self, host: str) -> bool:
        name = host.lower()
        name = name.partition("]")[0].lstrip("[") if name.startswith("[") else name.partition(":")[0]
        return name in self._names or ("*" in self._names and _is_address(name))

    def _entrance(self, scope: Scope) -> Response | None:
        """A cookie for who brings the token; then on without it, so that it stands in no history."""
        if scope["type"] != "http" or scope["method"] != "GET" or scope["path"] not in _DOORS:
            return None
        query = parse_qs(scope["query_string"].decode("latin-1"))
        role = _DOORS[scope["path"]]
        given, wanted = query.pop("token", [""])[0], self._tokens.get(role)
        if not given or wanted is None or not secrets.compare_digest(given.encode(), wanted.encode()):
            return None
        rest = urlencode(query, doseq=True)
        answer = RedirectResponse(scope["path"] + (f"?{rest}" if rest else ""), 303)
        if self._known(scope, role) is None:
            cookie = self.visitors.enter(role)
            answer.set_cookie(self.visitors.cookie_name(role), cookie, httponly=True, samesite="strict", path="/")
        return answer

    def _stranger(self, scope: Scope) -> Response | None:
        """401 for who has no cookie; else the request is told who it is."""
        operator = scope["path"].startswith(OPERATOR)
        role = "operator" if operator else "visitor"
        visitor = self._known(scope, role)
        # The page's own files are no secret of a visitor: an operator needs them too.
        if visitor is None and not operator and not scope["path"].startswith(("/api", "/ws")):
            visitor = self._known(scope, "operator") if scope["path"] != "/" else None
        if visitor is None:
            return _refused(scope, "no entry: open the address that limner studio printed, with its token", 401)
        scope["visitor"] = visitor
        return None

    def _known(self, scope: Scope, role: str) -> object | None:
        cookies = cookie_parser(Headers(scope=scope).get("cookie", ""))
        return self.visitors.known(role, cookies.get(self.visitors.cookie_name(role), ""))


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


def _refused(scope: Scope, text: str, status: int) -> Response:
    if scope["path"].startswith("/api"):
        return JSONResponse({"error": text}, status)
    return PlainTextResponse(text + "\n", status)


def _with_headers(send: Send) -> Send:
    """Send, with ``HEADERS`` in every answer, refused WebSockets too."""

    async def sending(message: Message) -> None:
        if message["type"] in ("http.response.start", "websocket.http.response.start"):
            headers = MutableHeaders(scope=message)
            for name, value in HEADERS.items():
                headers[name] = value
        await send(message)

    return sending
