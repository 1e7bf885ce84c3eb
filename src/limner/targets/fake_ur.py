"""A fake of an arm of Universal Robots: programs go in over TCP; reports, what it did and breaches come out."""

from __future__ import annotations

import contextlib
import re
import socket
import threading
from dataclasses import dataclass
from types import TracebackType
from typing import Self

import numpy as np

from limner.errors import BadInput
from limner.targets.link import readable
from limner.targets.urscript import Moves, read_moves
from limner.types import Floats

UR_FAULTS = ("drop", "die", "silence", "stall", "astray", "nonsense", "again")
"""What a fake arm can do wrong: end the connection, take no other either, say nothing, begin but never end, end
elsewhere, say what is no position, say for long that it has begun."""

_SAID_AGAIN = 1500

_LIFT = re.compile(
    r"stopj\(2\)\nmovel\(pose_trans\(get_actual_tcp_pose\(\), p\[0, 0, -[\d.]+, 0, 0, 0\]\), a=0.5, v=0.1\)\n"
)
_TALKING = re.compile(
    r'if not socket_open\("([\da-f.:]+)", (\d+), "limner"\):\nhalt\nend\n'
    r'socket_send_line\("(\w+) begun", "limner"\)\n(.*)'
    r'socket_send_line\(str_cat\("\3 done ", to_str\(get_actual_joint_positions\(\)\)\), "limner"\)\n'
    r'socket_close\("limner"\)\n',
    re.DOTALL,
)
_STATE = b"\x00\x00\x00\x05\x14" * 20
_NOWHERE = Moves((), np.zeros((0, 6)), np.zeros(0))


@dataclass
class _Running:
    """A program that is being done."""

    moves: Moves
    token: str
    report: socket.socket
    number: int
    again: int = 0


class FakeUr:
    """A server on the loopback that checks every program as no controller would, and does it in no time.

    Attributes:
        q: (6,) where it is.
        done: the moves of every program that ran to its end.
        lifts: how often it was told to stop and draw its tool back.
        breaches: what a driver must never do, each a sentence.
        programs: how many it has got.
    """

    def __init__(
        self,
        q: Floats,
        lower: Floats,
        upper: Floats,
        velocity: Floats,
        *,
        fault: str = "",
        program: int = -1,
        host: str = "127.0.0.1",
    ) -> None:
        """A fake at rest.

        Args:
            q: where it is at first.
            lower: (6,) limits of position.
            upper: likewise.
            velocity: (6,) limits of speed.
            fault: one of ``UR_FAULTS``.
            program: number of the one with which it happens.
            host: address of the loopback, of either kind.
        """
        self.q, self._limits = q, (lower, upper, velocity)
        self._fault, self._program = fault, program
        self.done: list[Moves] = []
        self.breaches: list[str] = []
        self.lifts = self.programs = 0
        self._server = socket.create_server((host, 0), family=socket.AF_INET6 if ":" in host else socket.AF_INET)
        self.port = int(self._server.getsockname()[1])
        self._ends: dict[socket.socket, bytes] = {}
        self._running: _Running | None = None
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._serve, daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._ended.set()
        self._thread.join()
        self._stop()
        self._hang_up()
        self._server.close()

    def _serve(self) -> None:
        while not self._ended.is_set():
            open_ = [self._server] if self._server.fileno() >= 0 else []
            for end in readable([*open_, *self._ends], 0.005):
                # Whoever has hung up meanwhile hears nothing.
                with contextlib.suppress(OSError):
                    if end is self._server:
                        self._ends[end.accept()[0]] = b""
                    else:
                        self._receive(end)
            if self._running:
                with contextlib.suppress(OSError):
                    self._finish(self._running)

    def _receive(self, end: socket.socket) -> None:
        try:
            data = end.recv(65536)
        except OSError:
            data = b""
        if not data:
            if self._ends.pop(end):
                self.breaches.append("a program ends in the middle")
            end.close()
            return
        end.sendall(_STATE)
        *programs, self._ends[end] = re.split(rb"(?<=\nend\n)", self._ends[end] + data)
        for text in programs:
            self._begin(text.decode("ascii", "replace"))

    def _begin(self, text: str) -> None:
        """A program takes the place of the one that runs, as it does in the real arm."""
        self._stop()
        number, self.programs = self.programs, self.programs + 1
        lines = [line.strip() for line in text.splitlines()]
        body = "".join(f"{line}\n" for line in lines[1:-1])
        if found := _LIFT.match(body):
            self.lifts += 1
            # It is then somewhere near, and tells where.
            self.q = self.q + 0.01
            body = body[found.end() :]
        talking = _TALKING.fullmatch(body)
        if lines[0] != "def limner():" or not talking:
            self.breaches.append(f"program {number}: does not report where it ends")
            return
        try:
            moves = self._checked(talking[4].splitlines(), number)
        except BadInput as error:
            self.breaches.append(f"program {number}: {error}")
            return
        if number == self._program and self._fault == "silence":
            return
        report = socket.create_connection((talking[1], int(talking[2])), timeout=2)
        report.sendall(f"{talking[3]} begun\n".encode())
        self._running = _Running(moves, talking[3], report, number)
        if number == self._program and self._fault in ("drop", "die"):
            self._hang_up()

    def _hang_up(self) -> None:
        for end in self._ends:
            end.close()
        self._ends = {}
        if self._fault == "die":
            self._server.close()

    def _checked(self, lines: list[str], number: int) -> Moves:
        """The moves, checked against where the arm is and what it can."""
        kept = [line for line in lines if line != "stopj(2)"]
        if not kept:
            return _NOWHERE
        moves = read_moves(kept)
        lower, upper, velocity = self._limits
        if np.abs(moves.q[0] - self.q).max() > 1e-3:
            self.breaches.append(f"program {number}: begins elsewhere than the arm is")
        if (moves.q < lower).any() or (moves.q > upper).any():
            self.breaches.append(f"program {number}: leaves the limits of a joint")
        step, streamed = np.diff(moves.t_s), np.array(moves.kind[1:]) == "servoj"
        if (np.abs(np.diff(moves.q, axis=0))[streamed] > 1.01 * velocity * step[streamed, None] + 1e-7).any():
            self.breaches.append(f"program {number}: is faster than a joint")
        return moves

    def _stop(self) -> None:
        if running := self._running:
            running.report.close()
            self._running = None
            if running.moves.kind:
                self.q = running.moves.q[len(running.moves.q) // 2]

    def _finish(self, running: _Running) -> None:
        faulty = self._fault if running.number == self._program else ""
        if faulty in ("drop", "die", "stall"):
            return
        if faulty == "again" and running.again < _SAID_AGAIN:
            running.again += 1
            with contextlib.suppress(OSError):
                running.report.sendall(f"{running.token} begun\n".encode())
            return
        self._running = None
        if running.moves.kind:
            self.q = running.moves.q[-1]
            self.done.append(running.moves)
        q = self.q + 0.1 if faulty == "astray" else self.q
        said = "nowhere" if faulty == "nonsense" else "[" + ", ".join(f"{value:.6g}" for value in q) + "]"
        with running.report as report:
            report.sendall(f"{running.token} done {said}\n".encode())
