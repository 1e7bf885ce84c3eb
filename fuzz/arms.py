"""What an arm's controller says goes in; the parts of the drivers that take it up listen."""

from __future__ import annotations

import socket
from types import SimpleNamespace

import numpy as np

from fuzz.contract import Broken
from limner.targets import bridge, ur
from limner.targets.bridge import parse_bridge
from limner.targets.rosbridge import Rosbridge, RosbridgeSettings
from limner.types import JointTrajectory

NAMES = ("a", "b")
MOTION = JointTrajectory(
    NAMES, [0.0, 0.02], np.zeros((2, 2)), np.zeros((2, 2)), np.zeros((2, 2)), [False, False], [-1, -1]
)


class _Socket:
    """A connection on which every line of the data is a message."""

    def __init__(self, data: bytes) -> None:
        self._messages, self.now, self._reads = iter(data.split(b"\n")), 0.0, 0

    def send(self, text: str) -> None:
        """Heard by nobody."""

    def recv(self, timeout: float) -> str:
        """The next message; then nothing, while time passes."""
        self._reads += 1
        if self._reads > 10_000:
            raise Broken("listens for ever")
        self.now += timeout
        for message in self._messages:
            return message.decode("utf-8", "replace")
        raise TimeoutError


def rosbridge_messages(data: bytes) -> None:
    """Messages of rosbridge, from its answer to the end of a motion."""
    said = _Socket(data)
    address = parse_bridge("rosbridge:ws://localhost:9090/arm/command")
    route = SimpleNamespace(
        to_stroke=lambda q, index: MOTION, stroke=lambda index: MOTION, home=lambda at: MOTION, tips=None
    )
    settings = RosbridgeSettings(before="/begin", stop="/stop")
    arm = Rosbridge(address, route, settings, NAMES, "base", clock=lambda: said.now)
    arm._bridge.connect = lambda tries=(): setattr(arm._bridge, "_socket", said)
    try:
        arm.open()
        arm.draw(0, lambda: False)
        arm.home()
    finally:
        assert isinstance(arm.abort(), bool)
        arm.close()


def ur_reports(data: bytes) -> None:
    """What the program on an arm says over the connection it opens to us: the first byte is the size of the pieces."""
    ours, theirs = socket.socketpair()
    control, controller = socket.socketpair()
    listener = socket.create_server(("127.0.0.1", 0))
    reports = ur._Reports(listener)
    reports._heard[ours] = b""
    step = 1 + (data[0] if data else 0) * 16
    try:
        for at in range(1, min(len(data), 8 * step), step):
            theirs.sendall(data[at : at + step])
            for word, rest in reports.next(control, "token"):
                if word == "done":
                    ur._positions(rest)
    except BrokenPipeError:
        pass  # it has heard enough
    finally:
        reports.close()
        for end in (ours, theirs, control, controller, listener):
            end.close()


def addresses(data: bytes) -> None:
    """Addresses of machines as people write them."""
    from limner.targets.connect import parse_address

    text = data.decode("utf-8", "replace")
    kind, _, rest = text.partition(" ")
    {"ur": ur.parse_host, "bridge": bridge.parse_bridge}.get(kind, parse_address)(rest)


HARNESSES = {"rosbridge": rosbridge_messages, "ur": ur_reports, "addresses": addresses}
