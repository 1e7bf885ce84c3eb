"""The errors limner raises on purpose, each with its exit code and a one-line message."""

from __future__ import annotations

_LONGEST = 1500
"""Characters of a message; what is in the middle of a longer one is left out."""


class LimnerError(Exception):
    """Base of every error that limner raises on purpose.

    The message is one line: what, the value, the limit or the choices, what to do.
    Each leaf carries the exit code that the command line ends with::

        LimnerError
        ├── BadInput            2   unreadable file, wrong value, wrong option
        │   └── MissingExtra    2   an optional dependency is not installed
        ├── NoFace              3   no face, or not the one asked for
        ├── CannotDraw          4   not within the asked limits (reach, page, budget)
        │   └── NothingToDraw   4   no stroke is left
        └── DeviceFailed        5   a machine did not do as told
    """

    exit_code = 1

    def __init__(self, message: object = "") -> None:
        """Take the message; whatever it quotes from a file stays in one line and cannot speak to the terminal."""
        super().__init__(_one_line(str(message)))


def _one_line(text: str) -> str:
    text = _cut(text)
    if text.isprintable():
        return text
    # Escapes are longer than what they stand for.
    return _cut("".join(" " if c.isspace() else c if c.isprintable() else ascii(c)[1:-1] for c in text))


def _cut(text: str) -> str:
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 300]} ... {text[-290:]}"


class BadInput(LimnerError):
    """Something handed over cannot be read or has a value outside its limits."""

    exit_code = 2


class MissingExtra(BadInput):
    """A feature needs a package that is not installed.

    Args:
        feature: what was asked for, as the start of the sentence.
        extra: the name of limner's extra that brings the package.
    """

    def __init__(self, feature: str, extra: str) -> None:
        super().__init__(f"{feature} needs a package that is not installed; run: pip install 'limner[{extra}]'")
        self.feature = feature
        self.extra = extra


class NoFace(LimnerError):
    """No face was found, or fewer than the one asked for."""

    exit_code = 3


class CannotDraw(LimnerError):
    """The drawing cannot be made within the asked limits."""

    exit_code = 4


class NothingToDraw(CannotDraw):
    """No stroke is left to draw."""


class DeviceFailed(LimnerError):
    """A machine did not do as told."""

    exit_code = 5
