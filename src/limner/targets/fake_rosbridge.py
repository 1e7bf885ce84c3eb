"""A fake of an arm behind rosbridge: messages go in, are checked strictly and played; joint states come out."""

from __future__ import annotations

import contextlib
import json
import threading
import time
from dataclasses import dataclass, field
from types import TracebackType
from typing import Any, Self

import numpy as np

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
_POINT = {"positions", "velocities", "accelerations", "effort", "time_from_start"}
_EVERY_S = 0.004


@dataclass(frozen=True, eq=False)
class Heard:
    """A motion that came.

    Attributes:
        t_s: (n,) times from its start.
        q, qd: (n, dof).
        qdd: (n, dof), or (n, 0) where the points come without accelerations.
    """

    t_s: Floats
    q: Floats
    qd: Floats
    qdd: Floats


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
        done: the motions that came, in their order.
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

        self._names, self._q, self._limits, self._topic = names, q, limits, topic
        self._ros, self._pace, self._fault, self._fault_at, self._services = ros, pace, fault, motion, services
        self.done: list[Heard] = []
        self.breaches: list[str] = []
        self.called: list[str] = []
        self.stops = self.connections = 0
        self._began = 0.0
        self._playing: Heard | None = None
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
        with self._lock:
            if self._playing is None:
                return self._q
            t = (time.monotonic() - self._began) * self._pace
            motion = self._playing
            if t >= motion.t_s[-1]:
                self._q = motion.q[-1] + (0.1 if self._faulty("astray") else 0.0)
                self._playing = None
                return self._q
            return np.array([np.interp(t, motion.t_s, column) for column in motion.q.T])

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
            self._q, self._playing = self.q, None
            return
        heard = self._checked(message["msg"])
        if heard is None:
            return
        self.done.append(heard)
        if self._faulty("refuse"):
            error = {
                "op": "status",
                "level": "error",
                "id": message.get("id"),
                "msg": "publish: wrong type\nof message",
            }
            client.socket.send(json.dumps(error))
        elif not self._faulty("deaf"):
            self._playing, self._began = heard, time.monotonic()
        if self._faulty("drop"):
            self._fault = ""
            client.socket.close()
        if self._faulty("die"):
            # The thread that is to end cannot wait for its own end.
            threading.Thread(target=self._server.shutdown).start()

    def _checked(self, message: dict[str, Any]) -> Heard | None:
        """The motion, as rosbridge checks a message's type, and a controller what it is to do."""
        try:
            heard = self._read(message)
        except (KeyError, TypeError, ValueError) as error:
            self.breaches.append(f"no JointTrajectory: {error}")
            return None
        lower, upper, velocity, acceleration = (1.02 * limit for limit in self._limits)
        step = np.diff(heard.t_s)[:, None]
        wrong = {
            "comes while another runs": self._playing is not None and self.q is not self._q,
            "does not begin at 0": heard.t_s[0] != 0,
            "times do not increase": bool((step <= 0).any()),
            "steps of more than 50 ms": bool((step > 0.0501).any()),
            "begins elsewhere than the arm is": bool(np.abs(heard.q[0] - self.q).max() > 0.02),
            "ends while moving": bool(np.abs(heard.qd[[0, -1]]).max() > 1e-6),
            "leaves the limits": bool(((heard.q < lower) | (heard.q > upper)).any()),
            "is too fast": bool((np.abs(heard.qd) > velocity).any())
            or bool((np.abs(np.diff(heard.q, axis=0)) > velocity * step + 1e-9).any()),
            "accelerates too much": bool((np.abs(_accelerations(heard)) > acceleration).any()),
        }
        self.breaches += [f"motion {len(self.done)}: {what}" for what, found in wrong.items() if found]
        return heard

    def _read(self, message: dict[str, Any]) -> Heard:
        clock = CLOCKS[self._ros]
        _keys(message, {"header", "joint_names", "points"})
        _keys(message["header"], {"stamp", "frame_id"})
        _keys(message["header"]["stamp"], set(clock))
        if tuple(message["joint_names"]) != self._names:
            raise ValueError(f"joints {message['joint_names']}")
        times, rows, sizes = [], [], set()
        for point in message["points"]:
            _keys(point, _POINT)
            _keys(point["time_from_start"], set(clock))
            whole, part = (point["time_from_start"][name] for name in clock)
            if not (isinstance(whole, int) and isinstance(part, int) and 0 <= part < 1_000_000_000):
                raise ValueError(f"time {whole}, {part}")
            times.append(whole + part / 1e9)
            rows.append([*point["positions"], *point["velocities"], *point["accelerations"]])
            sizes.add(tuple(len(point[name]) for name in ("positions", "velocities", "accelerations")))
        dof, values = len(self._names), np.array(rows, dtype=np.float64)
        if sizes not in ({(dof, dof, 0)}, {(dof, dof, dof)}) or not np.isfinite(values).all():
            raise ValueError("points of another size, or no numbers")
        return Heard(np.array(times), values[:, :dof], values[:, dof : 2 * dof], values[:, 2 * dof :])

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


def _accelerations(heard: Heard) -> Floats:
    """(21, n - 1, dof) on the way from point to point: along quintics, or cubics where no accelerations are given."""
    step, u = np.maximum(np.diff(heard.t_s), 1e-9)[:, None], np.linspace(0, 1, 21)[:, None, None]
    way = np.diff(heard.q, axis=0)
    v0, v1 = step * heard.qd[:-1], step * heard.qd[1:]
    if not heard.qdd.size:
        return np.asarray((6 * way - 4 * v0 - 2 * v1 + 6 * u * (v0 + v1 - 2 * way)) / step**2)
    a0, a1 = step**2 * heard.qdd[:-1], step**2 * heard.qdd[1:]
    c3 = 10 * way - 6 * v0 - 4 * v1 - 1.5 * a0 + 0.5 * a1
    c4 = -15 * way + 8 * v0 + 7 * v1 + 1.5 * a0 - a1
    c5 = 6 * way - 3 * v0 - 3 * v1 - 0.5 * a0 + 0.5 * a1
    return np.asarray((a0 + 6 * u * c3 + 12 * u**2 * c4 + 20 * u**3 * c5) / step**2)


def _keys(thing: dict[str, Any], expected: set[str]) -> None:
    if set(thing) != expected:
        raise ValueError(f"fields {sorted(thing)}, expected {sorted(expected)}")
