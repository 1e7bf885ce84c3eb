"""Motions of an arm of Universal Robots go in, stroke by stroke; the arm follows them, reporting the end of each."""

from __future__ import annotations

import contextlib
import re
import secrets
import socket
import time
from collections.abc import Callable, Sequence

import numpy as np

from limner.errors import BadInput, DeviceFailed
from limner.targets import urscript
from limner.targets.link import readable
from limner.targets.target import NotConnected, Route
from limner.targets.urscript import UrSettings
from limner.types import Floats, JointTrajectory

PORT = 30002
"""Where a controller takes programs, as its maker publishes."""

SILENCE_S = 10.0
"""An arm that says nothing for so long, beyond what its program takes, is not heard from again."""

SLACK = 1.5
"""An arm may take so many times what was planned: somebody may have turned down its speed."""

_LOOK_S = 0.05
_OFF_RAD = 0.02


def parse_host(text: str) -> tuple[str, int]:
    """Host and port of ``ur:HOST`` or ``ur:HOST:PORT``; an IPv6 address stands in brackets.

    Raises:
        BadInput: it is neither.
    """
    found = re.fullmatch(r"ur:(?:\[([\da-fA-F:.]+(?:%\w+)?)\]|([^:\s/\[\]]+))(?::(\d{1,5}))?", text)
    if not found or not 0 < int(found[3] or PORT) < 65536:
        raise BadInput(
            f"--to {text}: expected ur:HOST or ur:HOST:PORT (such as ur:192.168.0.10 or ur:[fd00::10]),"
            " rosbridge:ws://HOST:PORT/TOPIC, or fake:"
        )
    return found[1] or found[2], int(found[3] or PORT)


class Ur:
    """An arm at the other end of a network.

    Every program opens a connection back to us, says that it has begun, moves, says where it has ended. Only then does
    the next one go out.
    """

    def __init__(self, host: str, port: int, route: Route, settings: UrSettings, silence_s: float = SILENCE_S) -> None:
        self.name = f"[{host}]:{port}" if ":" in host else f"{host}:{port}"
        self._address, self._route, self._settings, self._silence_s = (host, port), route, settings, silence_s
        self._control: socket.socket | None = None
        self._listener: socket.socket | None = None
        self._q: Floats | None = None
        self._at = -1  # before which stroke the arm waits, -1: elsewhere
        self._up, self._busy = False, False

    def open(self) -> None:
        """Connect, and ask where the arm is; nothing moves.

        Raises:
            NotConnected: likewise, before anything was told to the arm.
            DeviceFailed: there is no such host, it refuses or does not answer.
        """
        try:
            self._connect()
        except DeviceFailed as error:
            raise NotConnected(f"{error}; nothing has moved") from error
        self._run([], 0.0)

    def draw(self, index: int, stopping: Callable[[], bool]) -> bool:
        """Go to a stroke if the arm is not there, and draw it.

        Args:
            index: of the stroke.
            stopping: asked all the time; when true, the arm stops where it is and draws its tool back.

        Returns:
            Whether the stroke is drawn; else the arm was stopped, the pen up.

        Raises:
            DeviceFailed: it did not do as told.
        """
        assert self._q is not None
        if self._at != index and not self._follow(self._route.to_stroke(self._q, index), stopping):
            return False
        self._up, self._at = False, -1
        if not self._follow(self._route.stroke(index), stopping):
            return False
        self._up, self._at = True, index + 1
        return True

    def home(self) -> None:
        """Go back to where the motion ends; an arm that was stopped within a stroke stays where it is."""
        if self._at >= 0:
            self._follow(self._route.home(self._at), lambda: False)

    def abort(self) -> bool:
        """Stop the arm and draw its tool back; never raises."""
        if self._busy:
            with contextlib.suppress(DeviceFailed, OSError):
                self._lift()
        return self._up

    def close(self) -> None:
        """Let go of both connections."""
        for end in (self._control, self._listener):
            if end is not None:
                end.close()

    def _connect(self) -> None:
        try:
            self._control = socket.create_connection(self._address, timeout=self._silence_s)
            # The arm reaches us where we reach it from.
            ours = self._control.getsockname()
            self._listener = socket.create_server((ours[0], 0, *ours[2:]), family=self._control.family)
        except OSError as error:
            raise DeviceFailed(f"{self.name}: {_why(error)}") from error

    def _follow(self, motion: JointTrajectory, stopping: Callable[[], bool]) -> bool:
        lines = urscript.motion(motion, self._route.tips(motion.q), self._settings)
        # At the position that was reported this moves nothing; servoj then begins without a jump.
        ended = self._run([urscript.move_to(motion.q[0]), *lines], float(motion.t_s[-1]), stopping)
        if ended and np.abs(motion.q[-1] - self._q).max() > _OFF_RAD:
            off = float(np.degrees(np.abs(motion.q[-1] - self._q).max()))
            raise DeviceFailed(f"{self.name}: the arm ended {off:.1f} degrees from where its program leads")
        if ended:
            # What it reported is rounded; the next program begins exactly where this one led.
            self._q = motion.q[-1]
        return ended

    def _lift(self) -> None:
        """Stop the joints and draw the tool back along its axis, wherever it is.

        Raises:
            DeviceFailed: it does not say that it has.
        """
        if self._listener is None or not _alive(self._control):
            self.close()
            self._connect()
        back = f"p[0, 0, {-self._settings.lift_mm / 1000:g}, 0, 0, 0]"
        # Even an arm that cannot reach us is stopped: it reports after that.
        self._run([], 0.0, before=["stopj(2)", f"movel(pose_trans(get_actual_tcp_pose(), {back}), a=0.5, v=0.1)"])
        self._up = True

    def _run(
        self,
        lines: list[str],
        seconds: float,
        stopping: Callable[[], bool] = lambda: False,
        before: Sequence[str] = (),
    ) -> bool:
        """Have a program run to its end; False if it was stopped, the pen up.

        Raises:
            DeviceFailed: the connection ended, or no report came in time.
        """
        assert self._control is not None
        assert self._listener is not None
        token, reports = secrets.token_hex(4), _Reports(self._listener)
        host, port = self._listener.getsockname()[:2]
        self._busy = bool(lines or before)
        try:
            self._control.sendall(urscript.program([*before, *_reporting(lines, host, port, token)]))
            began, deadline = False, time.monotonic() + self._silence_s
            while True:
                for word, rest in reports.next(self._control, token):
                    if word == "done":
                        self._q, self._busy = _positions(rest), False
                        return True
                    if word == "begun" and not began:
                        began, deadline = True, time.monotonic() + SLACK * seconds + self._silence_s
                if stopping():
                    self._lift()
                    return False
                if time.monotonic() > deadline:
                    what = "never ended" if began else "never began; is the arm on and in remote control?"
                    raise DeviceFailed(f"{self.name}: the program {what}")
        except OSError as error:
            raise DeviceFailed(f"{self.name}: {_why(error)}") from error
        finally:
            reports.close()


def _reporting(lines: list[str], host: str, port: int, token: str) -> list[str]:
    """Lines that tell us when they begin, and where the arm is when they end; without a listener they do nothing."""
    return [
        f'if not socket_open("{host}", {port}, "limner"):',
        "  halt",
        "end",
        f'socket_send_line("{token} begun", "limner")',
        *lines,
        f'socket_send_line(str_cat("{token} done ", to_str(get_actual_joint_positions())), "limner")',
        'socket_close("limner")',
    ]


class _Reports:
    """What one program says over the connections that it opens to us."""

    def __init__(self, listener: socket.socket) -> None:
        self._listener = listener
        self._heard: dict[socket.socket, bytes] = {}

    def next(self, control: socket.socket, token: str) -> list[tuple[str, str]]:
        """Words with this token that have come, and what follows each; waits a moment for them.

        Raises:
            DeviceFailed: the arm's own connection has ended.
        """
        ready = readable([control, self._listener, *self._heard], _LOOK_S)
        for end in ready:
            if end is self._listener:
                self._heard[end.accept()[0]] = b""
            elif end is not control:
                self._take(end)
        lines = [line for end in self._heard for line in self._whole(end)]
        found = [(word, rest) for mark, word, rest in map(_words, lines) if mark == token]
        # The controller tells its state all the time; what it says is not needed, that it speaks is.
        if not found and control in ready and not control.recv(65536):
            raise DeviceFailed("the connection to the arm ended; its program may go on")
        return found

    def _take(self, end: socket.socket) -> None:
        try:
            data = end.recv(4096)
        except OSError:
            data = b""
        self._heard[end] += data
        if not data or len(self._heard[end]) > 4096:
            end.close()
            self._heard.pop(end)

    def _whole(self, end: socket.socket) -> list[str]:
        *lines, rest = self._heard[end].split(b"\n")
        self._heard[end] = rest
        return [line.decode("ascii", "replace").strip() for line in lines]

    def close(self) -> None:
        for end in self._heard:
            end.close()


def _words(line: str) -> tuple[str, str, str]:
    mark, _, rest = line.partition(" ")
    word, _, more = rest.partition(" ")
    return mark, word, more


def _positions(text: str) -> Floats:
    try:
        q = np.array([float(value) for value in text.strip("[] ").split(",")])
    except ValueError:
        q = np.zeros(0)
    if q.shape != (6,) or not np.isfinite(q).all():
        raise DeviceFailed(f"the arm says that it is at {text[:60]!r}, expected six joint positions")
    return q


def _alive(control: socket.socket | None) -> bool:
    try:
        if control is None:
            return False
        while readable([control], 0):
            if not control.recv(65536):
                return False
    except (OSError, ValueError):
        return False
    return True


def _why(error: OSError) -> str:
    if isinstance(error, socket.gaierror):
        return "no host of this name is known"
    if isinstance(error, ConnectionRefusedError):
        return "it refuses the connection; is the arm on, and in remote control?"
    if isinstance(error, TimeoutError):
        return "it does not answer; is it on, and in this network?"
    return f"the connection failed ({error.strerror or error})"
