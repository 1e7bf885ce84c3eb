"""A file's name says what it is: a drawing goes in and the file's bytes come out, or the other way round."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from limner import storage
from limner.errors import BadInput
from limner.targets import image, svg, svg_read
from limner.types import Drawing

_WRITERS: dict[str, Callable[[Drawing, Mapping[str, Any] | None], bytes]] = {
    ".svg": lambda drawing, about: svg.to_svg(drawing, about),
    ".png": lambda drawing, _: image.to_png(drawing),
    ".json": lambda drawing, _: (storage.to_json(drawing) + "\n").encode(),
    ".npz": lambda drawing, _: storage.to_npz(drawing),
}

_READERS: dict[str, Callable[[str], Drawing]] = {
    ".svg": svg_read.read_svg,
    ".json": lambda path: storage.load(Drawing, path),
    ".npz": lambda path: storage.load(Drawing, path),
}

FORMATS = tuple(_WRITERS)
"""What a drawing can be saved as."""

READABLE = tuple(_READERS)
"""What a drawing can be read from."""


def check_format(path: str | Path) -> str:
    """The path's suffix, if a drawing can be saved as that.

    Raises:
        BadInput: it cannot.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in _WRITERS:
        raise BadInput(f"{path}: cannot save as '{suffix}'; choose {', '.join(FORMATS)}")
    return suffix


def to_bytes(drawing: Drawing, suffix: str, about: Mapping[str, Any] | None = None) -> bytes:
    """The file of a drawing.

    Args:
        drawing: what to write.
        suffix: one of ``FORMATS``.
        about: how it was made, for formats that can say so.
    """
    return _WRITERS[suffix](drawing, about)


def read_drawing(path: str | Path) -> Drawing:
    """A drawing from a file, by its suffix.

    Raises:
        BadInput: another suffix, unreadable, or not a drawing.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in _READERS:
        raise BadInput(f"{path}: cannot read a drawing from '{suffix}'; expected {', '.join(READABLE)}")
    return _READERS[suffix](str(path))
