"""Photos, an engine and an output folder go in; every photo drawn there, once, and a row for each come out."""

from __future__ import annotations

import contextlib
import dataclasses
import hashlib
import json
import os
from collections import deque
from collections.abc import Iterable, Iterator
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from limner.batch import remote, source
from limner.batch.engine import Engine
from limner.batch.manifest import Row
from limner.batch.names import drawing_name
from limner.batch.state import Known, State
from limner.batch.work import Drawn, Job, Recipe, draw_one, write
from limner.errors import BadInput, LimnerError
from limner.storage import to_json
from limner.types import Face


@dataclass(frozen=True)
class Order:
    """What is wanted.

    Attributes:
        recipe: what is made of every photo; without ``out``, workers hand files back and they are written here.
        folder: on this machine, for what stands beside the drawings.
        store: where the drawings go: that folder, or an URL.
        send: photos that are files here are read here and sent along.
        sidecars: faces are taken from files beside the photos, where there are any.
        tiles: how many tiles the contact sheet needs.
    """

    recipe: Recipe
    folder: Path
    store: str
    send: bool = False
    sidecars: bool = False
    tiles: int = 0

    def mark(self) -> str:
        """Hash of all that decides how a drawing looks, but the photo."""
        recipe = self.recipe
        settings = recipe.settings.to_dict()
        files = {value: source.digest_of(value) for value in _texts(settings) if os.path.isfile(value)}
        whole = [recipe.version, settings, recipe.formats, recipe.robot, files, self.store]
        return hashlib.sha256(json.dumps(whole, sort_keys=True).encode()).hexdigest()


class Told(NamedTuple):
    """A row, and how it came about.

    Attributes:
        row: for the manifest.
        tile: for the contact sheet; empty where there is none.
        how: "drawn" now; "kept" from a run before or from a photo of the same content; or "failed".
        peak_mb: memory of the worker so far.
        cpu_s: time of a core that it took, where it was drawn now.
    """

    row: Row
    tile: bytes
    how: str
    peak_mb: float = 0.0
    cpu_s: float = 0.0


@dataclass
class _Seen:
    """A photo and its hash, which may still be under way."""

    photo: str
    stamp: str | None
    digest: str | Future[str]


@dataclass
class _Begun:
    """A photo in its turn: known already, or under way, or waiting for another of the same content."""

    photo: str
    digest: str = ""
    content: str = ""
    name: str = ""
    told: Told | None = None
    future: Future[Drawn] | None = None
    leader: _Begun | None = None

    def ready(self) -> bool:
        """Whether its row can be had without waiting."""
        return self.future is None or self.future.done()


def draw_all(photos: Iterable[str], engine: Engine, order: Order, state: State) -> Iterator[Told]:
    """Draw what is not drawn yet; rows come in the order of the photos.

    Memory does not grow with their number: a bounded number is hashed, drawn or waited for at a time.

    Raises:
        BadInput: drawings cannot be written; those that are there are kept.
    """
    _without_parts(order.folder)
    with ThreadPoolExecutor(1, "limner-hash") as reader:
        run = _Run(engine, order, state, engine.executor if engine.far and not order.send else reader)
        try:
            yield from run.rows(photos)
        finally:
            state.commit()


class _Run:
    def __init__(self, engine: Engine, order: Order, state: State, reader: Executor) -> None:
        self._engine, self._order, self._state, self._reader = engine, order, state, reader
        self._mark = order.mark()
        state.forget_other(self._mark)
        self._tiles = order.tiles
        self._under_way: dict[str, _Begun] = {}

    def rows(self, photos: Iterable[str]) -> Iterator[Told]:
        window: deque[_Begun] = deque()
        for seen in self._hashed(photos):
            window.append(self._begin(seen))
            while window and (len(window) > self._engine.ahead or window[0].ready()):
                yield self._end(window.popleft())
        while window:
            yield self._end(window.popleft())

    def _hashed(self, photos: Iterable[str]) -> Iterator[_Seen]:
        rest, ahead = iter(photos), deque[_Seen]()
        for photo in rest:
            ahead.append(self._look(photo))
            while ahead and (isinstance(ahead[0].digest, str) or len(ahead) > self._engine.ahead):
                yield ahead.popleft()
        yield from ahead

    def _look(self, photo: str) -> _Seen:
        stamp = source.stamp(photo)
        known = self._state.digest(photo, stamp) if stamp else None
        return _Seen(photo, stamp, known or self._reader.submit(source.digest_of, photo))

    def _begin(self, seen: _Seen) -> _Begun:
        try:
            digest = self._digest(seen)
            face = source.face_beside(seen.photo) if self._order.sidecars else None
        except LimnerError as error:
            return _Begun(seen.photo, told=Told(Row(seen.photo, error=_line(error)), b"", "failed"))
        given = "" if face is None else to_json(face)
        content = hashlib.sha256(f"{digest}{given}".encode()).hexdigest()
        known = self._state.done(content)
        begun = _Begun(seen.photo, digest, content, drawing_name(seen.photo, content))
        if known and known.figures["drawing"]:
            begun.name = known.figures["drawing"].removesuffix(".svg")
        if known and known.mark == self._mark and self._there(begun.name, known.figures["error"]):
            row = Row(begun.photo, begun.digest, **known.figures)
            begun.told = Told(row, known.tile, "failed" if row.error else "kept")
            return begun
        begun.leader = self._under_way.get(content)
        return begun if begun.leader else self._given_out(begun, face)

    def _digest(self, seen: _Seen) -> str:
        if isinstance(seen.digest, str):
            return seen.digest
        try:
            digest = seen.digest.result()
        except self._engine.died as error:
            raise source.Unread(_line(error)) from error
        if seen.stamp:
            self._state.keep_digest(seen.photo, seen.stamp, digest)
        return digest

    def _there(self, name: str, error: str) -> bool:
        """Whether the files of what is done are still there; those behind an URL are taken to be."""
        if error or remote.is_url(self._order.store):
            return True
        return all(os.path.exists(f"{self._order.store}/{file}") for file in self._order.recipe.names(name))

    def _given_out(self, begun: _Begun, face: Face | None) -> _Begun:
        data = None
        if self._order.send and not remote.is_url(begun.photo):
            try:
                data = source.read(begun.photo)
            except BadInput as error:
                begun.told = Told(Row(begun.photo, begun.digest, error=_line(error)), b"", "failed")
                return begun
        job = Job(begun.photo, begun.digest, begun.name, face, data, self._tiles > 0)
        self._tiles -= 1
        self._under_way[begun.content] = begun
        begun.future = self._engine.executor.submit(draw_one, job, self._order.recipe)
        return begun

    def _end(self, begun: _Begun) -> Told:
        if begun.told:
            return begun.told
        if begun.leader:
            told = begun.leader.told
            assert told is not None  # rows come in order, and the leader came first
            how = "failed" if told.row.error else "kept"
            return told._replace(row=dataclasses.replace(told.row, photo=begun.photo), how=how)
        begun.told = self._finished(begun)
        del self._under_way[begun.content]
        return begun.told

    def _finished(self, begun: _Begun) -> Told:
        drawn = self._result(begun)
        for name, data in drawn.files.items():
            write(f"{self._order.store}/{name}", data)
        figures = drawn.figures | {"error": drawn.error, "drawing": "" if drawn.error else f"{begun.name}.svg"}
        if drawn.final:
            self._state.keep_done(begun.content, Known(self._mark, figures, drawn.tile))
        row = Row(begun.photo, begun.digest, **figures)
        return Told(row, drawn.tile, "failed" if drawn.error else "drawn", drawn.peak_mb, drawn.cpu_s)

    def _result(self, begun: _Begun) -> Drawn:
        assert begun.future is not None
        try:
            return begun.future.result()
        except self._engine.died as error:
            return Drawn(error=_line(error), final=False)


def _texts(settings: dict[str, Any]) -> Iterator[str]:
    for value in settings.values():
        if isinstance(value, dict):
            yield from _texts(value)
        elif isinstance(value, str):
            yield value


def _line(error: Exception) -> str:
    return " ".join(str(error).split()) or type(error).__name__


def _without_parts(folder: Path) -> None:
    """Take away what processes that were killed while writing left behind."""
    for path in folder.glob(".*.part"):
        with contextlib.suppress(OSError):
            path.unlink()
