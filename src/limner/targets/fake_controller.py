"""A fake of an arm's trajectory controller: ROS messages go in, are checked and played; its joints come out."""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass
from typing import Any

import numpy as np

from limner.targets.rosbridge import CLOCKS
from limner.types import Floats

_POINT = {"positions", "velocities", "accelerations", "effort", "time_from_start"}


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


class FakeController:
    """An arm that moves as it is told, faster than a real one.

    Attributes:
        done: the motions that came, in their order.
    """

    def __init__(
        self,
        names: tuple[str, ...],
        q: Floats,
        limits: tuple[Floats, Floats, Floats, Floats],
        breaches: list[str],
        *,
        ros: str,
        pace: float,
    ) -> None:
        """An arm at rest.

        Args:
            names: of its joints.
            q: (dof,) where they are.
            limits: lower, upper, velocity, acceleration, (dof,) each.
            breaches: what must never be asked of it is added here, each a sentence.
            ros: ``1`` or ``2``, whose messages come.
            pace: how many times faster than planned it moves.
        """
        self.done: list[Heard] = []
        self._names, self._q, self._limits, self._breaches = names, q, limits, breaches
        self._clock, self._pace = CLOCKS[ros], pace
        self._playing: Heard | None = None
        self._began = self._miss_rad = 0.0
        self._lock = threading.RLock()

    @property
    def q(self) -> Floats:
        """(dof,) where the arm is now."""
        with self._lock:
            if self._playing is None:
                return self._q
            t = (time.monotonic() - self._began) * self._pace
            motion = self._playing
            if t >= motion.t_s[-1]:
                self.put(motion.q[-1] + self._miss_rad)
                return self._q
            return np.array([np.interp(t, motion.t_s, column) for column in motion.q.T])

    def put(self, q: Floats) -> None:
        """Let the arm be at rest somewhere (dof,)."""
        with self._lock:
            self._q, self._playing = q, None

    def play(self, motion: Heard, miss_rad: float = 0.0) -> None:
        """Begin a motion; it ends so far from where it should, in each joint."""
        with self._lock:
            self._playing, self._began, self._miss_rad = motion, time.monotonic(), miss_rad

    def take(self, message: dict[str, Any]) -> Heard | None:
        """The motion of a JointTrajectory, checked as rosbridge does its type, and a controller what is to be done."""
        try:
            heard = self._read(message)
        except (KeyError, TypeError, ValueError) as error:
            self._breaches.append(f"no JointTrajectory: {error}")
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
        self._breaches += [f"motion {len(self.done)}: {what}" for what, found in wrong.items() if found]
        self.done.append(heard)
        return heard

    def _read(self, message: dict[str, Any]) -> Heard:
        _keys(message, {"header", "joint_names", "points"})
        _keys(message["header"], {"stamp", "frame_id"})
        _keys(message["header"]["stamp"], set(self._clock))
        if tuple(message["joint_names"]) != self._names:
            raise ValueError(f"joints {message['joint_names']}")
        times, rows, sizes = [], [], set()
        for point in message["points"]:
            _keys(point, _POINT)
            _keys(point["time_from_start"], set(self._clock))
            whole, part = (point["time_from_start"][name] for name in self._clock)
            if not (isinstance(whole, int) and isinstance(part, int) and 0 <= part < 1_000_000_000):
                raise ValueError(f"time {whole}, {part}")
            times.append(whole + part / 1e9)
            rows.append([*point["positions"], *point["velocities"], *point["accelerations"]])
            sizes.add(tuple(len(point[name]) for name in ("positions", "velocities", "accelerations")))
        dof, values = len(self._names), np.array(rows, dtype=np.float64)
        if sizes not in ({(dof, dof, 0)}, {(dof, dof, dof)}) or not np.isfinite(values).all():
            raise ValueError("points of another size, or no numbers")
        return Heard(np.array(times), values[:, :dof], values[:, dof : 2 * dof], values[:, 2 * dof :])


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
