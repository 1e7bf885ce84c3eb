"""URLs such as s3://bucket/photo.jpg go in; what is there, and its bytes, come out, by way of fsspec."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from limner.errors import BadInput, LimnerError, MissingExtra

_STAMPS = ("ETag", "etag", "LastModified", "mtime", "created")
_ONE_LINE = 200


def is_url(name: str) -> bool:
    """Whether a name says how it is reached."""
    scheme, mark, _ = name.partition("://")
    return bool(mark) and scheme.replace("+", "").replace("-", "").isalnum()


def listed(url: str, suffixes: Sequence[str]) -> Iterator[str]:
    """The photos an URL names: those below a folder (it ends in /) or of a pattern with ``*``; else the URL itself.

    Raises:
        BadInput: it cannot be listed.
    """
    if not url.endswith("/") and "*" not in url:
        yield url
        return
    try:
        system, path = _reached(url)
        found = system.find(path) if url.endswith("/") else system.glob(path)
        names = [system.unstrip_protocol(name) for name in sorted(found)]
    except LimnerError:
        raise
    except Exception as error:  # each kind of store has errors of its own
        raise BadInput(f"{url}: cannot be listed ({_said(error)})") from error
    yield from (name for name in names if name.lower().endswith(tuple(suffixes)))


def read(url: str, limit: int) -> bytes:
    """The bytes behind an URL.

    Raises:
        BadInput: they cannot be read, or are more than ``limit``.
        MissingExtra: fsspec, or its plug-in for this kind of URL, is not installed.
    """
    try:
        system, path = _reached(url)
        with system.open(path, "rb") as file:
            data: bytes = file.read(limit + 1)
    except LimnerError:
        raise
    except Exception as error:  # each kind of store has errors of its own
        raise BadInput(f"{url}: cannot be read ({_said(error)})") from error
    if len(data) > limit:
        raise BadInput(f"{url}: larger than {limit // 2**20} MB, the limit for such a file")
    return data


def stamp(url: str) -> str | None:
    """What changes when the bytes do, without reading them; None where the store does not tell."""
    try:
        system, path = _reached(url)
        told: dict[str, Any] = system.info(path)
    except LimnerError:
        raise
    except Exception:  # likewise; reading it will say what is wrong
        return None
    mark = next((told[name] for name in _STAMPS if told.get(name)), None)
    return None if mark is None else f"{told.get('size')} {mark}"


def write(url: str, data: bytes) -> None:
    """Put bytes where an URL says; object stores show them when all are there, files are renamed into place.

    Raises:
        BadInput: they cannot be written.
    """
    try:
        system, path = _reached(url)
        system.makedirs(system._parent(path), exist_ok=True)
        if "file" in system.protocol:
            system.pipe_file(f"{path}.part", data)
            system.mv(f"{path}.part", path)
        else:
            system.pipe_file(path, data)
    except LimnerError:
        raise
    except Exception as error:  # each kind of store has errors of its own
        raise BadInput(f"{url}: cannot be written ({_said(error)}); choose another place") from error


def _reached(url: str) -> tuple[Any, str]:
    try:
        from fsspec.core import url_to_fs
    except ImportError as error:
        raise MissingExtra(f"{url}: an URL", "cluster") from error
    try:
        system, path = url_to_fs(url)
    except ImportError as error:
        scheme = url.partition("://")[0]
        raise BadInput(f"{url}: {scheme}:// needs a package of fsspec's that is not installed ({error})") from error
    except ValueError as error:
        raise BadInput(f"{url}: no such kind of URL ({error})") from error
    return system, path


def _said(error: Exception) -> str:
    if isinstance(error, FileNotFoundError):
        return "it is not there"
    text = " ".join(str(error).split()) or type(error).__name__
    return text[:_ONE_LINE]
