"""Bytes of a plotter's file go in, to be read as a drawing."""

from __future__ import annotations

from collections.abc import Callable

from limner import storage
from limner.targets.gcode_read import read_gcode
from limner.targets.hpgl_read import read_hpgl
from limner.types import Drawing


def _whole(read: Callable[[bytes], Drawing], data: bytes) -> None:
    drawing = read(data)
    if drawing.points > 20_000:
        return
    assert storage.from_json(Drawing, storage.to_json(drawing)) == drawing


def gcode(data: bytes) -> None:
    """G-code of any make."""
    _whole(read_gcode, data)


def hpgl(data: bytes) -> None:
    """HP-GL of any make."""
    _whole(read_hpgl, data)


HARNESSES = {"gcode": gcode, "hpgl": hpgl}
