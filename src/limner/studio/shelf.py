"""A job goes in, piece by piece; what is left of it after the server was killed comes out."""

from __future__ import annotations

import contextlib
import json
import math
import os
import shutil
from pathlib import Path

from limner.errors import BadInput
from limner.studio.orders import Order
from limner.studio.visitors import HeldDrawing, Visitor

DRAWING, ORDER, PLAN, JOURNAL = "drawing.npz", "order.json", "plan.json", "journal"
"""What lies there: what is sent, by what, when each stroke begins, and what is drawn."""

OWNER, HELD = "owner.json", "held.npz"
"""Whose it is, by the seal of his cookie, what is told of the drawing, and the drawing as he keeps it."""


class Shelf:
    """The folder of the one job, there only while it is not done.

    Attributes:
        folder: ours alone.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def write(self, name: str, data: bytes) -> None:
        """Write a file whole, and for the eyes of this user alone.

        Raises:
            BadInput: it cannot be written.
        """
        beside = self.folder / f"{name}.part"
        try:
            self.folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            with os.fdopen(os.open(beside, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600), "wb") as file:
                file.write(data)
                file.flush()
                os.fsync(file.fileno())
            os.replace(beside, self.folder / name)
        except OSError as error:
            raise BadInput(f"{self.folder}: the job cannot be written down ({error.strerror or error})") from error

    def write_owner(self, held: HeldDrawing, owner: Visitor | None) -> None:
        """Write down whose the job is.

        Raises:
            BadInput: it cannot be written.
        """
        self.write(HELD, held.npz)
        self.write(OWNER, json.dumps({"seal": owner.seal if owner else "", "about": held.about}).encode())

    def owner(self) -> Visitor | None:
        """Whose the job was, with nothing but its drawing; None where that is not known."""
        try:
            told, npz = json.loads((self.folder / OWNER).read_bytes()), (self.folder / HELD).read_bytes()
            owner, about = Visitor(seal=str(told["seal"])), told["about"]
            held = HeldDrawing(str(about["drawing"]), str(about["photo"]), npz, about)
        except (OSError, ValueError, TypeError, LookupError, RecursionError):
            return None
        owner.drawings.add(held.name, held)
        return owner if owner.seal else None

    def order(self) -> Order:
        """What was to be drawn by what.

        Raises:
            BadInput: it cannot be read.
        """
        try:
            told = json.loads((self.folder / ORDER).read_bytes())
            order = Order(**told)
        except (OSError, ValueError, TypeError, RecursionError) as error:
            raise BadInput("the job that was left behind cannot be read; clear it") from error
        kinds = {"to": str, "machine": str | None, "robot": str | None, "settings": dict, "frame_only": bool}
        if not all(isinstance(value, kinds[name]) for name, value in told.items()):
            raise BadInput("the job that was left behind is damaged; clear it")
        return order

    def left(self) -> tuple[Order, str, float, list[float]] | None:
        """The order, the machine's name, how long all takes and when each stroke begins; None where nothing is left."""
        try:
            name, seconds, begins_s = json.loads((self.folder / PLAN).read_bytes())
            times = [float(value) for value in (seconds, *begins_s)]
            return (self.order(), str(name), times[0], times[1:]) if all(map(math.isfinite, times)) else None
        except (OSError, ValueError, TypeError, OverflowError, RecursionError, BadInput):
            return None

    def last_stroke(self) -> int:
        """How many strokes are drawn, by the journal's lines; its reader checks it before the pen goes on."""
        with contextlib.suppress(OSError, ValueError, IndexError):
            lines = [line.split() for line in (self.folder / JOURNAL).read_text("ascii", "replace").splitlines()]
            told = [int(line[1]) for line in lines if len(line) == 4 and line[0] in ("begin", "reached")]
            return max([0, *told])
        return 0

    def clear(self) -> None:
        """Leave nothing."""
        shutil.rmtree(self.folder, ignore_errors=True)
