"""The name of a serial port goes in; a link over it comes out, and what is wrong with the port by name."""

from __future__ import annotations

import contextlib
import errno
import os
from collections.abc import Iterator
from typing import Any

from limner.errors import DeviceFailed, MissingExtra

WRITE_S = 10.0
"""A machine that takes no byte for so long is stuck."""

EBB_USB = (0x04D8, 0xFD92)
"""Vendor and product of an EBB, as it tells the USB."""


class SerialLink:
    """A serial port, ours alone while it is open."""

    def __init__(self, port: str, baud: int) -> None:
        """Open the port.

        Args:
            port: its name, such as /dev/ttyUSB0 or COM3.
            baud: bits per second; without meaning for boards that are USB devices themselves.

        Raises:
            DeviceFailed: there is no such port, it is in use, or one may not use it.
            MissingExtra: pyserial is not installed.
        """
        try:
            import serial
        except ImportError as error:
            raise MissingExtra("a serial port", "plotter") from error
        self.name = port
        self._failures = (serial.SerialException, OSError, ValueError, TypeError)
        try:
            exclusive = True if os.name == "posix" else None
            self._port: Any = serial.Serial(port, baud, timeout=0, write_timeout=WRITE_S, exclusive=exclusive)
        except self._failures as error:
            raise DeviceFailed(f"{port}: {_why(port, error)}") from error

    def write(self, data: bytes) -> None:
        """Send all of it."""
        with self._named():
            self._port.write(data)

    def read(self, timeout_s: float) -> bytes:
        """What has come, waiting for the first byte at most so long."""
        with self._named():
            self._port.timeout = timeout_s
            data = bytes(self._port.read(1))
            self._port.timeout = 0
            return data + bytes(self._port.read(4096)) if data else b""

    def close(self) -> None:
        """Let go of the port."""
        with contextlib.suppress(*self._failures):
            self._port.close()

    @contextlib.contextmanager
    def _named(self) -> Iterator[None]:
        try:
            yield
        except self._failures as error:
            raise DeviceFailed(f"{self.name} does not answer any more; is it unplugged? ({_reason(error)})") from error


def ports() -> list[tuple[str, str, bool]]:
    """The serial ports that are there: name, what is said to be plugged in, whether it is an AxiDraw's board.

    Raises:
        MissingExtra: pyserial is not installed.
    """
    try:
        from serial.tools import list_ports
    except ImportError as error:
        raise MissingExtra("a serial port", "plotter") from error
    found = sorted(list_ports.comports(), key=lambda port: str(port.device))
    return [(str(port.device), str(port.description), (port.vid, port.pid) == EBB_USB) for port in found]


def _why(port: str, error: Exception) -> str:
    number = getattr(error, "errno", None)
    if not os.path.exists(port) and os.name == "posix":
        return f"no such port; {_others()}"
    if number == errno.EACCES:
        return "no permission to use it; on Linux: sudo usermod -aG dialout $USER, then log in again"
    if number == errno.EBUSY or "lock" in str(error).lower():
        return "in use by another program; close that one first"
    if number in (errno.ENOTTY, errno.EINVAL) or os.path.isfile(port):
        return f"is no serial port; {_others()}"
    return f"cannot be opened ({_reason(error)}); {_others()}"


def _reason(error: Exception) -> str:
    return " ".join(str(error).split())[:100]


def _others() -> str:
    from serial.tools import list_ports

    ports = sorted(port.device for port in list_ports.comports())
    return f"there are {', '.join(ports)}" if ports else "no serial port is there; is the machine plugged in and on?"
