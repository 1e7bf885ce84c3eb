"""An address of rosbridge goes in; its messages, each a JSON object, come out of a connection that is kept alive."""

from __future__ import annotations

import contextlib
import json
import re
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any
from urllib.parse import urlsplit

from limner.errors import BadInput, DeviceFailed, MissingExtra

PORT = 9090
"""Where rosbridge listens unless told otherwise."""

LARGEST_IN = 2**20
"""Bytes of a message that is taken: joint states are small."""

LARGEST_OUT = 8 * 2**20
"""Bytes of a message that is sent: rosbridge takes 10 MB unless told otherwise."""

BACKOFF_S = (0.5, 1.0, 2.0, 4.0)
"""How long is waited before each try to connect again."""

_LOOK_S = 0.05
_LARGEST = 1e12
_NAME = re.compile(r"(/[A-Za-z][A-Za-z0-9_]*)+")


class Lost(DeviceFailed):
    """The connection has ended; a new one may be had."""


@dataclass(frozen=True)
class BridgeAddress:
    """Where rosbridge is, and which topic an arm's controller listens to."""

    url: str
    topic: str


def parse_bridge(text: str) -> BridgeAddress:
    """The parts of ``rosbridge:ws://HOST[:PORT]/TOPIC``.

    Raises:
        BadInput: it is something else.
    """
    wanted = (
        f"--to {text}: expected rosbridge:ws://HOST:PORT/CONTROLLER/command, such as"
        " rosbridge:ws://localhost:9090/left_arm_joint_trajectory_controller/command"
    )
    try:
        parts = urlsplit(text.removeprefix("rosbridge:"))
        host, port = parts.hostname, parts.port or PORT
    except ValueError as error:
        raise BadInput(wanted) from error
    plain = not (parts.query or parts.fragment or parts.username or parts.password)
    if not (text.startswith("rosbridge:") and parts.scheme in ("ws", "wss") and host and plain):
        raise BadInput(wanted)
    check_name(parts.path, f"--to {text}")
    return BridgeAddress(f"{parts.scheme}://{f'[{host}]' if ':' in host else host}:{port}", parts.path)


def check_name(name: str, what: str) -> str:
    """A name of ROS, from its root on.

    Raises:
        BadInput: it is none.
    """
    if not _NAME.fullmatch(name):
        raise BadInput(f"{what}: '{name}' is no name of ROS; expected one such as /arm_controller/command")
    return name


class Bridge:
    """A connection that speaks the protocol of rosbridge (version 2: a JSON object a message, ``op`` says what)."""

    def __init__(self, url: str, silence_s: float) -> None:
        """Prepare; nothing is connected yet.

        Raises:
            MissingExtra: websockets is not installed.
        """
        try:
            import websockets.exceptions
            import websockets.sync.client
        except ImportError as error:
            raise MissingExtra("rosbridge", "ros") from error
        self.name = url
        self._connect, self._errors = websockets.sync.client.connect, websockets.exceptions
        self._silence_s = silence_s
        self._socket: Any = None
        self._held = contextlib.ExitStack()
        self._number = 0

    def connect(self, tries: tuple[float, ...] = ()) -> None:
        """Connect, trying again after each of some times [s].

        Raises:
            DeviceFailed: nobody answers there, or somebody else.
        """
        self.close()
        for wait_s in (*tries, None):
            try:
                connection = self._connect(
                    self.name, open_timeout=self._silence_s, close_timeout=1, max_size=LARGEST_IN, proxy=None
                )
                self._socket = self._held.enter_context(connection)
            except (OSError, self._errors.WebSocketException) as error:
                if wait_s is None or isinstance(error, self._errors.InvalidHandshake):
                    raise DeviceFailed(f"{self.name}: {self._why(error)}") from error
                time.sleep(wait_s)
            else:
                return

    def send(self, op: str, **fields: Any) -> str:
        """Send an operation; gives its id.

        Raises:
            Lost: the connection has ended.
            DeviceFailed: the message is larger than rosbridge takes.
        """
        self._number += 1
        name = f"limner:{op}:{self._number}"
        text = json.dumps({"op": op, "id": name, **fields}, allow_nan=False, separators=(",", ":"))
        if len(text) > LARGEST_OUT:
            raise DeviceFailed(
                f"{self.name}: a motion of {len(text) / 2**20:.0f} MB, more than the {LARGEST_OUT // 2**20} MB that are"
                " sent at once; plan it with a larger arm.retime.sample_s, or shorter strokes"
            )
        with self._kept():
            self._socket.send(text)
        return name

    def receive(self) -> dict[str, Any] | None:
        """The next message, waiting a moment for it; None if none has come.

        Raises:
            Lost: the connection has ended.
            DeviceFailed: it says what is not rosbridge's, or that it cannot do what it was told.
        """
        try:
            with self._kept():
                text = self._socket.recv(timeout=_LOOK_S)
        except TimeoutError:
            return None
        try:
            message = json.loads(text)
        except (ValueError, RecursionError) as error:
            raise DeviceFailed(f"{self.name}: says {text[:40]!r}, which is no JSON; is rosbridge there?") from error
        if not isinstance(message, dict) or not isinstance(message.get("op"), str):
            raise DeviceFailed(f"{self.name}: says {text[:40]!r}, which is no message of rosbridge")
        if message["op"] == "status" and message.get("level") == "error":
            said = " ".join(str(message.get("msg")).split())[:200]
            raise DeviceFailed(f"{self.name}: rosbridge refuses: {said}")
        return message

    def call(self, service: str, until: Callable[[], bool]) -> None:
        """Call a service that takes nothing, such as a ``std_srvs/Trigger``, and wait for its answer.

        Raises:
            DeviceFailed: it fails, or does not answer while ``until`` holds.
            Lost: the connection has ended.
        """
        name = self.send("call_service", service=service, args={})
        while until():
            message = self.receive()
            if message and message["op"] == "service_response" and message.get("id") == name:
                values = message.get("values")
                done = not isinstance(values, dict) or values.get("success", True)
                if message.get("result") is True and done:
                    return
                said = values.get("message") if isinstance(values, dict) else values
                raise DeviceFailed(f"{self.name}: the service {service} failed: {str(said)[:200]}")
        raise DeviceFailed(f"{self.name}: the service {service} does not answer; is it there?")

    def close(self) -> None:
        """Let go of the connection; never raises."""
        self._socket = None
        with contextlib.suppress(OSError, self._errors.WebSocketException):
            self._held.close()

    @contextlib.contextmanager
    def _kept(self) -> Iterator[None]:
        if self._socket is None:
            raise Lost(f"{self.name}: not connected")
        try:
            yield
        except self._errors.ConnectionClosed as error:
            if error.sent is not None and error.sent.code == 1009:
                raise DeviceFailed(f"{self.name}: a message of more than {LARGEST_IN // 2**20} MB came") from error
            raise Lost(f"{self.name}: the connection ended") from error

    def _why(self, error: Exception) -> str:
        if isinstance(error, self._errors.WebSocketException):
            return f"something else than rosbridge is there ({' '.join(str(error).split())[:100]})"
        if isinstance(error, ConnectionRefusedError):
            return "nobody listens there; start it with: roslaunch rosbridge_server rosbridge_websocket.launch"
        if isinstance(error, TimeoutError):
            return "it does not answer; is it on, and in this network?"
        return f"the connection failed ({getattr(error, 'strerror', None) or error})"


def number(value: Any) -> float:
    """A finite number as JSON may hold it.

    Raises:
        ValueError: it is something else.
    """
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < _LARGEST:
        raise ValueError(f"{value!r:.40} is no number")
    return float(value)
