"""Where to listen goes in; the studio is served there until it is ended."""

from __future__ import annotations

import contextlib
import errno
import importlib
import ipaddress
import secrets
import socket
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from limner.errors import BadInput, MissingExtra
from limner.studio.folder import own_folder
from limner.studio.orders import Make

PORT, TRIES = 8765, 20
"""Where it listens, and how many ports after that are tried."""


_SERVER: dict[str, Any] = {
    "log_level": "error",
    "access_log": False,
    "ws": "websockets-sansio",
    "ws_per_message_deflate": False,
    "server_header": False,
    "timeout_graceful_shutdown": 2,
}


@dataclass(frozen=True)
class Address:
    """Where the studio is.

    Attributes:
        url: with the token.
        operator_url: of the booth's operator; None without a booth.
        loopback: whether only this computer can reach it.
    """

    url: str
    operator_url: str | None
    loopback: bool


def serve(
    settings: dict[str, Any], make: Make, host: str, port: int | None, *, booth: bool, ready: Callable[[Address], None]
) -> None:
    """Serve until Ctrl-C.

    Args:
        settings: of the tree, where the page says nothing.
        make: from an order to what draws it.
        host: name or address to listen on.
        port: to listen on; None: the first free one from ``PORT`` on.
        booth: serve the booth.
        ready: told where, once it listens.

    Raises:
        BadInput: it cannot listen there.
        MissingExtra: the extra ``studio`` is not installed.
    """
    try:
        import uvicorn

        importlib.import_module("websockets")  # uvicorn answers no WebSocket without it, and says so nowhere

        from limner.studio.app import MESSAGE_BYTES, assembled, build
    except ImportError as error:
        raise MissingExtra("limner studio", "studio") from error
    listening = _listen(host, port)
    port = listening.getsockname()[1]
    tokens = {role: secrets.token_urlsafe(24) for role in ("visitor", "operator")[: 1 + booth]}
    app = build(assembled(settings, make, port, own_folder(), queued=booth), tokens, names_of(host))
    config = uvicorn.Config(app, ws_max_size=MESSAGE_BYTES, **_SERVER)
    ready(_address(host, port, tokens))
    # Ctrl-C is how one ends it; uvicorn raises it again when all is closed.
    with contextlib.suppress(KeyboardInterrupt):
        uvicorn.Server(config).run(sockets=[listening])


def _address(host: str, port: int, tokens: dict[str, str]) -> Address:
    shown = f"[{host}]" if ":" in host else {"0.0.0.0": socket.gethostname(), "": "127.0.0.1"}.get(host, host)
    base = f"http://{shown}:{port}"
    operator = f"{base}/operator?token={tokens['operator']}" if "operator" in tokens else None
    return Address(f"{base}/?token={tokens['visitor']}", operator, _is_loopback(host))


def names_of(host: str) -> set[str]:
    """What a server that listens there may be called."""
    own = {"127.0.0.1", "localhost", "::1"}
    if _is_loopback(host):
        return own
    return own | {host.lower(), socket.gethostname().lower(), "*"}


def _is_loopback(host: str) -> bool:
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host.lower() == "localhost"


def _listen(host: str, port: int | None) -> socket.socket:
    wanted = [port] if port is not None else [*range(PORT, PORT + TRIES), 0]
    for each in wanted:
        try:
            family = socket.getaddrinfo(host, each, type=socket.SOCK_STREAM)[0]
            listening = socket.socket(family[0], socket.SOCK_STREAM)
        except OSError as error:
            raise BadInput(
                f"--host {host}: no such place on this computer ({error.strerror}); try 127.0.0.1"
            ) from error
        try:
            listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            listening.bind(family[4])
            listening.listen(128)
        except OSError as error:
            listening.close()
            if error.errno != errno.EADDRINUSE:
                raise BadInput(
                    f"--host {host} --port {each}: cannot listen there ({error.strerror}); choose another"
                ) from error
        else:
            return listening
    raise BadInput(f"--port {port}: is in use by another program; choose another, or leave --port out")
