"""A file's name says what it is: a drawing goes in and the file's bytes come out, or the other way round."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from limner import storage
from limner.errors import BadInput
from limner.targets import gcode, gcode_read, hpgl, hpgl_read, image, svg, svg_read
from limner.targets.gcode import GcodeSettings
from limner.types import Drawing

_READERS: dict[str, Callable[[str], Drawing]] = {
    ".svg": svg_read.read_svg,
    ".json": lambda path: storage.load(Drawing, path),
    ".npz": lambda path: storage.load(Drawing, path),
    ".gcode": gcode_read.read_gcode,
    ".hpgl": hpgl_read.read_hpgl,
}

FORMATS = (".svg", ".png", ".gcode", ".hpgl", ".json", ".npz")
"""What a drawing can be saved as."""

READABLE = tuple(_READERS)
"""What a drawing can be read from."""


def check_format(path: str | Path) -> str:
    """The path's suffix, if a drawing can be saved as that.

    Raises:
        BadInput: it cannot.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in FORMATS:
        raise BadInput(f"{path}: cannot save as '{suffix}'; choose {', '.join(FORMATS)}")
    return suffix


def to_bytes(
    drawing: Drawing, suffix: str, about: Mapping[str, Any] | None = None, plotter: GcodeSettings | None = None
) -> bytes:
    """The file of a drawing.

    Args:
        drawing: what to write.
        suffix: one of ``FORMATS``.
        about: how it was made, for formats that can say so.
        plotter: for G-code.

    Raises:
        BadInput: the drawing has points that the format cannot say.
    """
    writers: dict[str, Callable[[], bytes]] = {
        ".svg": lambda: svg.to_svg(drawing, about),
        ".png": lambda: image.to_png(drawing),
        ".gcode": lambda: gcode.to_gcode(drawing, plotter),
        ".hpgl": lambda: hpgl.to_hpgl(drawing),
        ".json": lambda: (storage.to_json(drawing) + "\n").encode(),
        ".npz": lambda: storage.to_npz(drawing),
    }
    return writers[suffix]()


def read_drawing(path: str | Path) -> Drawing:
    """A drawing from a file, by its suffix.

    Raises:
        BadInput: another suffix, unreadable, or not a drawing.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in _READERS:
        raise BadInput(f"{path}: cannot read a drawing from '{suffix}'; expected {', '.join(READABLE)}")
    return _READERS[suffix](str(path))
