"""Bytes of a journal go in, to be gone on with."""

from __future__ import annotations

import contextlib
import zlib

import numpy as np

from fuzz.contract import file_of
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


HARNESSES = {"journal": journal, "journal-signed": signed}
