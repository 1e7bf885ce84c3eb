"""A fake of an arm behind rosbridge: messages go in, are checked strictly and played; joint states come out."""

from __future__ import annotations

import contextlib
import json
import threading
import time
from dataclasses import dataclass, field
from types import TracebackType
from typing import Any, Self

from limner.targets.fake_controller import FakeController, Heard
from limner.targets.ros_points import split_time
from limner.targets.rosbridge import CLOCKS
from limner.types import Floats

BRIDGE_FAULTS = ("silence", "deaf", "refuse", "nonsense", "nan", "astray", "drop", "die", "huge")
"""Says no joint states; ignores a motion; answers it with an error; says what is no JSON; tells NaN; ends elsewhere;
hangs up once; hangs up for good; says too much at once."""

_REQUIRED = {
    "advertise": {"topic", "type"},
    "publish": {"topic", "msg"},
    "subscribe": {"topic"},
    "unsubscribe": {"topic"},
    "call_service": {"service"},
}
_EVERY_S = 0.004


@dataclass
class _Client:
    """One connection: what it has advertised, and what it hears."""

    socket: Any
    advertised: dict[str, str] = field(default_factory=dict)
    subscribed: set[str] = field(default_factory=set)
    told_at: float = 0.0


class FakeRosbridge:
    """A server on the loopback, its arm faster than a real one; other clients can listen along.

    Attributes:
        arm: what moves.
        breaches: what a driver must never do, each a sentence.
        stops: how often it was told to hold the arm.
        called: services that were called.
        connections: how many there have been.
    """

    def __init__(
        self,
        names: tuple[str, ...],
        q: Floats,
        limits: tuple[Floats, Floats, Floats, Floats],
        topic: str,
        *,
        ros: str = "1",
        pace: float = 1.0,
        fault: str = "",
        motion: int = -1,
        services: tuple[str, ...] = (),
    ) -> None:
        """A fake at rest.

        Args:
            names: of its joints.
            q: (dof,) where they are.
            limits: lower, upper, velocity, acceleration, (dof,) each.
            topic: of its controller.
            ros: ``1`` or ``2``.
            pace: how many times faster than planned it moves.
            fault: one of ``BRIDGE_FAULTS``.
            motion: number of the one with which it happens.
            services: that it has; any other is said to be missing.
        """
        from websockets.sync.server import serve

        self.breaches: list[str] = []
        self.arm = FakeController(names, q, limits, self.breaches, ros=ros, pace=pace)
        self._names, self._topic, self._ros = names, topic, ros
        self._fault, self._fault_at, self._services = fault, motion, services
        self.called: list[str] = []
        self.stops = self.connections = 0
        self._clients: list[_Client] = []
        self._lock = threading.RLock()
        self._server: Any = serve(self._serve, "127.0.0.1", 0, max_size=10_000_000)
        self.port = int(self._server.socket.getsockname()[1])
        self._thread = threading.Thread(target=self._server.serve_forever, daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._server.shutdown()
        for client in list(self._clients):
            client.socket.close()
        self._thread.join()

    @property
    def q(self) -> Floats:
        """(dof,) where the arm is now."""
        return self.arm.q

    @property
    def done(self) -> list[Heard]:
        """The motions that came, in their order."""
        return self.arm.done

    def _faulty(self, fault: str) -> bool:
        return self._fault == fault and len(self.done) > self._fault_at

    def _serve(self, socket: Any) -> None:
        from websockets.exceptions import ConnectionClosed

        client = _Client(socket)
        self._clients.append(client)
        self.connections += 1
        with contextlib.suppress(ConnectionClosed):
            while True:
                with contextlib.suppress(TimeoutError):
                    self._take(client, socket.recv(timeout=_EVERY_S))
                self._tell(client)
        self._clients.remove(client)

    def _take(self, client: _Client, text: str | bytes) -> None:
        try:
            message = json.loads(text, parse_constant=lambda name: self.breaches.append(f"says {name}"))
            op = message["op"]
            missing = _REQUIRED[op] - set(message)
        except (ValueError, KeyError, TypeError):
            self.breaches.append(f"says no operation: {text[:60]!r}")
            return
        if missing:
            self.breaches.append(f"{op} without {', '.join(sorted(missing))}")
            return
        with self._lock:
            getattr(self, f"_{op}")(client, message)

    def _advertise(self, client: _Client, message: dict[str, Any]) -> None:
        client.advertised[message["topic"]] = message["type"]
        wanted = "trajectory_msgs/JointTrajectory" if self._ros == "1" else "trajectory_msgs/msg/JointTrajectory"
        if message["topic"] == self._topic and message["type"] != wanted:
            self.breaches.append(f"advertises a {message['type']}, expected {wanted}")

    def _subscribe(self, client: _Client, message: dict[str, Any]) -> None:
        client.subscribed.add(message["topic"])

    def _unsubscribe(self, client: _Client, message: dict[str, Any]) -> None:
        client.subscribed.discard(message["topic"])

    def _call_service(self, client: _Client, message: dict[str, Any]) -> None:
        self.called.append(message["service"])
        there = message["service"] in self._services
        values = {"success": True, "message": ""} if there else "there is no such service"
        answer = {"op": "service_response", "service": message["service"], "values": values, "result": there}
        client.socket.send(json.dumps(answer | ({"id": message["id"]} if "id" in message else {})))

    def _publish(self, client: _Client, message: dict[str, Any]) -> None:
        topic = message["topic"]
        if topic not in client.advertised:
            self.breaches.append(f"publishes on {topic} without advertising it")
        for other in self._clients:
            if topic in other.subscribed:
                other.socket.send(json.dumps({"op": "publish", "topic": topic, "msg": message["msg"]}))
        if topic == self._topic:
            self._command(client, message)

    def _command(self, client: _Client, message: dict[str, Any]) -> None:
        if message["msg"].get("points") == []:
            self.stops += 1
            self.arm.put(self.q)
            return
        heard = self.arm.take(message["msg"])
        if heard is None:
            return
        if self._faulty("refuse"):
            text = "publish: wrong type\nof message"
            error = {"op": "status", "level": "error", "id": message.get("id"), "msg": text}
            client.socket.send(json.dumps(error))
        elif not self._faulty("deaf"):
            self.arm.play(heard, miss_rad=0.1 if self._faulty("astray") else 0.0)
        if self._faulty("drop"):
            self._fault = ""
            client.socket.close()
        if self._faulty("die"):
            # The thread that is to end cannot wait for its own end.
            threading.Thread(target=self._server.shutdown).start()

    def _tell(self, client: _Client) -> None:
        """Joint states, to who wants them."""
        if "/joint_states" not in client.subscribed or time.monotonic() - client.told_at < _EVERY_S:
            return
        if self._faulty("silence"):
            return
        client.told_at = time.monotonic()
        if self._faulty("nonsense"):
            client.socket.send("<html>")
        q = [float("nan")] * len(self._names) if self._faulty("nan") else self.q.tolist()
        names = [*self._names, "x" * 2**20] if self._faulty("huge") else [*self._names, "gripper"]
        state = {
            "header": {"stamp": split_time(time.monotonic_ns(), CLOCKS[self._ros]), "frame_id": ""},
            "name": names,
            "position": [*q, 0.0],
            "velocity": [],
            "effort": [],
        }
        client.socket.send(json.dumps({"op": "publish", "topic": "/joint_states", "msg": state}))
