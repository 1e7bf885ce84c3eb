"""Nothing goes in; meanwhile libtiff, which Pillow reads TIFF with, says nothing in the terminal by itself."""

from __future__ import annotations

import contextlib
import ctypes
import functools
from collections.abc import Callable, Iterator

from PIL import _imaging

_SETTERS = ("TIFFSetErrorHandler", "TIFFSetWarningHandler")

Setter = Callable[[int | None], int | None]
"""Takes the address of a handler, or none for silence; gives that of the one before."""


@contextlib.contextmanager
def silent_tiff() -> Iterator[None]:
    """What is wrong with a file is told by our own error; the handlers are global to the process."""
    before = [setter(None) for setter in _setters()]
    try:
        yield
    finally:
        for setter, handler in zip(_setters(), before, strict=True):
            setter(handler)


@functools.cache
def _setters() -> tuple[Setter, ...]:
    """Those of the libtiff that Pillow has loaded; none where they cannot be found."""
    try:
        # A library is asked for what it needs itself too.
        pillow = ctypes.CDLL(_imaging.__file__)
        setters = tuple(getattr(pillow, name) for name in _SETTERS)
    except (OSError, AttributeError, TypeError):
        return ()
    for setter in setters:
        setter.argtypes, setter.restype = [ctypes.c_void_p], ctypes.c_void_p
    return setters
