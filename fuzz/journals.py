"""Bytes of a journal, or of what a studio left behind, go in, to be gone on with."""

from __future__ import annotations

import contextlib
import dataclasses
import json
import zlib

import numpy as np

from fuzz.contract import file_of
from limner.errors import BadInput
from limner.studio.jobs import Jobs
from limner.studio.orders import Made, Order
from limner.studio.shelf import HELD, JOURNAL, ORDER, OWNER, PLAN, Shelf
from limner.targets.journal import Journal, fingerprint, runs_from
from limner.types import Drawing

DRAWING = Drawing((np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 5.0]]), np.array([[3.0, 3.0]])), ("face",) * 2, np.ones(2))
"""What the journals are of."""

HEAD = f"limner-journal-1 {fingerprint(DRAWING)} {len(DRAWING.lines_mm)}"


def journal(data: bytes) -> None:
    """A journal as it lies on the disk; drawing goes on where it says."""
    with file_of(data, "journal") as path:
        opened = Journal(path, DRAWING, resume=True)
        with contextlib.closing(opened):
            if opened.place.stroke < len(DRAWING.lines_mm):
                line, places = runs_from(DRAWING.lines_mm, opened.place)
                assert len(line) == len(places) > 0
                opened.begin(opened.place)
                opened.reached(places[-1])


def signed(data: bytes) -> None:
    """Lines that get the right check sums and heading, so that what they say is looked at."""
    lines = [HEAD.encode(), *data.split(b"\n")]
    journal(b"".join(b"%s %08x\n" % (line, zlib.crc32(line)) for line in lines))


def left_behind(data: bytes) -> None:
    """A studio's job: order, plan, journal and owner, a NUL between them; the next studio tells of it and can go on."""
    with file_of(data, "all") as path:
        folder = path.parent / "job"
        folder.mkdir()
        for name, content in zip((ORDER, PLAN, JOURNAL, OWNER), data.split(b"\0", 3), strict=False):
            (folder / name).write_bytes(content)
        (folder / HELD).write_bytes(b"")
        jobs = Jobs(folder, _nothing, lambda: None)
        json.dumps(jobs.fields(None), allow_nan=False)
        if jobs.status.state == "interrupted":
            order = Shelf(folder).order()
            assert json.loads(json.dumps(dataclasses.asdict(order))) == dataclasses.asdict(order)
            str.partition(order.to, ":")
            jobs.clear()
            assert jobs.may == ("start",)


def _nothing(order: Order, path: str) -> Made:
    raise BadInput("there is no machine")


HARNESSES = {"journal": journal, "journal-signed": signed, "left-behind": left_behind}
