"""Bytes from a machine go in, in whatever pieces they come; whole lines come out."""

from __future__ import annotations

import selectors
import socket
import time
from collections.abc import Iterable
from typing import Protocol

from limner.errors import DeviceFailed

LONGEST_LINE = 400
"""No machine here says more in a line; longer is noise."""


class Noise(DeviceFailed):
    """What came is no text."""


def readable(ends: Iterable[socket.socket], seconds: float) -> list[socket.socket]:
    """Those of some sockets that have something to be read, waiting for it at most so long.

    ``select()`` cannot look at files numbered 1024 and above, as a program has that has many open.
    """
    with selectors.DefaultSelector() as selector:
        for end in ends:
            selector.register(end, selectors.EVENT_READ, end)
        return [key.data for key, _ in selector.select(seconds)]


class Link(Protocol):
    """A cable to a machine."""

    name: str

    def write(self, data: bytes) -> None:
        """Send all of it.

        Raises:
            DeviceFailed: the machine is gone, or takes nothing.
        """

    def read(self, timeout_s: float) -> bytes:
        """What has come, waiting for it at most so long; empty if nothing has.

        Raises:
            DeviceFailed: the machine is gone.
        """

    def close(self) -> None:
        """Let go of the cable."""


class Lines:
    """The lines that come over a link."""

    def __init__(self, link: Link) -> None:
        self._link = link
        self._rest = b""

    def next(self, timeout_s: float) -> str | None:
        """The next line that is not empty, without its end; None if none has come in so long.

        Raises:
            DeviceFailed: the machine is gone.
            Noise: what comes is no text.
        """
        end = time.monotonic() + timeout_s
        while True:
            while (line := self._whole()) is not None:
                if line:
                    return line
            left = end - time.monotonic()
            data = self._link.read(max(left, 0))
            # Ends of lines without any line between them may come for ever.
            if left <= 0 and not data.strip():
                return None
            self._rest += data

    def _whole(self) -> str | None:
        """The next line if all of it is there, which may be empty."""
        data = self._rest.replace(b"\r", b"\n").lstrip(b"\n")
        head, newline, rest = data.partition(b"\n")
        if len(head) > LONGEST_LINE or any(byte < 32 or byte > 126 for byte in head):
            self._rest = rest
            raise Noise(f"{self._link.name} says {head[:24]!r}, which is no text; check baud rate and cable")
        self._rest = rest if newline else head
        return head.decode("ascii").strip() if newline else None
