"""What has been drawn goes in, line by line, and is on the disk before anything follows; where to go on comes out."""

from __future__ import annotations

import contextlib
import hashlib
import os
import re
import zlib
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from limner.errors import BadInput
from limner.storage import read_bytes
from limner.types import Drawing, Floats

_HEAD = "limner-journal-1"
_ENTRY = re.compile(r"(begin|reached) (\d{1,9}) (\d{1,9})")


@dataclass(frozen=True, order=True)
class Place:
    """Where in a drawing the pen goes on: everything before is drawn.

    Attributes:
        stroke: index of the stroke.
        vertex: index of its point from which on it is still to be drawn.
    """

    stroke: int
    vertex: int = 0


def fingerprint(drawing: Drawing) -> str:
    """Tells drawings apart by what the pen does: strokes to a thousandth of a millimetre, their order, the page."""
    digest = hashlib.sha256(f"{drawing.page.width_mm:.3f} {drawing.page.height_mm:.3f}".encode())
    for line in drawing.lines_mm:
        digest.update(np.rint(line * 1000).astype("<i8").tobytes())
        digest.update(b"|")
    return digest.hexdigest()


class Journal:
    """A text file of what was begun, finished and broken off, each line with its check sum.

    A line is written by one call and is on the disk (fsync) before the pen moves on. After a crash or a power cut the
    last line may be torn: then it is as if it had not been written.

    Attributes:
        place: where to go on.
        doubtful: whether the pen had begun to draw there, so that some of it may be on the paper.
    """

    def __init__(self, path: str | Path, drawing: Drawing, *, resume: bool) -> None:
        """Begin a journal, or go on with one.

        Args:
            path: of the file.
            drawing: that is drawn.
            resume: go on with what is there; otherwise begin anew.

        Raises:
            BadInput: nothing to go on with, one of another drawing, damaged, it cannot be written, or another process
                draws by it.
        """
        self.path = Path(path)
        self.place, self.doubtful = Place(0), False
        self._name = f"{_HEAD} {fingerprint(drawing)} {len(drawing.lines_mm)}"
        self._strokes, self._points = len(drawing.lines_mm), [len(line) for line in drawing.lines_mm]
        try:
            good = self._read() if resume else b""
            flags = os.O_RDWR | os.O_CREAT | os.O_APPEND | getattr(os, "O_BINARY", 0)
            self._file = os.open(self.path, flags, 0o666)
            self._hold()
            os.ftruncate(self._file, len(good))
            if not good:
                self._append(self._name)
            self._sync_folder()
        except OSError as error:
            raise BadInput(f"{self.path}: the journal cannot be written ({error.strerror or error})") from error

    def begin(self, place: Place) -> None:
        """The pen is about to draw from there."""
        self._append(f"begin {place.stroke} {place.vertex}")
        self.place, self.doubtful = place, True

    def reached(self, place: Place) -> None:
        """Everything before is drawn, and the pen is up."""
        self._append(f"reached {place.stroke} {place.vertex}")
        self.place, self.doubtful = place, False

    def close(self) -> None:
        """Let go of the file; remove it when there is nothing to go on with: all is drawn, or nothing yet."""
        os.close(self._file)
        if self.place.stroke == self._strokes or (self.place == Place(0) and not self.doubtful):
            with contextlib.suppress(OSError):
                os.unlink(self.path)

    def _hold(self) -> None:
        """Keep other processes from drawing by this journal, until it is closed or this process ends, however it does.

        Raises:
            BadInput: one does.
        """
        try:
            import fcntl
        except ImportError:  # Windows lets nobody remove a file that is open, which has to do
            return
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            os.close(self._file)
            raise BadInput(
                f"{self.path}: another limner draws by this journal; wait for its end, or choose another --journal"
            ) from error
        except OSError:  # a network file system without locks: better no lock than no drawing
            return

    def _append(self, text: str) -> None:
        data = _checked(text)
        try:
            if os.write(self._file, data) != len(data):
                raise OSError(28, "no space left on the disk")
            os.fsync(self._file)
        except OSError as error:
            raise BadInput(f"{self.path}: the journal cannot be written ({error.strerror or error})") from error

    def _sync_folder(self) -> None:
        with contextlib.suppress(OSError):
            folder = os.open(self.path.parent, os.O_RDONLY)
            try:
                os.fsync(folder)
            finally:
                os.close(folder)

    def _read(self) -> bytes:
        """The lines that are whole; sets the place after the last."""
        if not self.path.exists():
            raise BadInput(f"{self.path}: no journal, so nothing to resume; send the drawing without --resume")
        data = read_bytes(self.path)
        lines = data.splitlines(keepends=True)
        whole = [line for line in lines if _is_whole(line)]
        if lines[: len(whole)] != whole or len(lines) > len(whole) + 1:
            raise BadInput(f"{self.path}: the journal is damaged in the middle; send with --from N instead of --resume")
        texts = [line.decode("ascii").rpartition(" ")[0] for line in whole]
        if texts and texts[0] != self._name:
            raise BadInput(f"{self.path}: the journal of another drawing; resume that one, or send without --resume")
        for text in texts[1:]:
            self._go_on(text)
        return b"".join(whole)

    def _go_on(self, text: str) -> None:
        told = _ENTRY.fullmatch(text)
        stroke, vertex = (int(told[2]), int(told[3])) if told else (-1, 0)
        known = 0 <= stroke < self._strokes and vertex < self._points[stroke]
        if told is None or not (known or (stroke, vertex) == (self._strokes, 0)):
            raise BadInput(f"{self.path}: the journal says '{text:.40}', which is no place of this drawing")
        self.place, self.doubtful = Place(stroke, vertex), told[1] == "begin"


def unfinished(path: str | Path, drawing: Drawing) -> Place | None:
    """Where an earlier journal of this drawing ends; None where there is none."""
    with contextlib.suppress(BadInput):
        if Path(path).exists():
            journal = Journal(path, drawing, resume=True)
            journal.close()
            return journal.place
    return None


def runs_from(lines: Sequence[Floats], place: Place, changes: Collection[int] = ()) -> tuple[Floats, list[Place]]:
    """The strokes from a place on that the pen draws without being raised, as one line.

    Args:
        lines: of the drawing, without repeated points.
        place: where to go on.
        changes: strokes before which the pen is changed, for which it must be raised.

    Returns:
        The line (n, 2), and for each of its points the place at which to go on from there.
    """
    first = lines[place.stroke][place.vertex :]
    pieces, places = [first], [Place(place.stroke, place.vertex + k) for k in range(len(first))]
    for stroke in range(place.stroke + 1, len(lines) + 1):
        places[-1] = Place(stroke)
        if stroke == len(lines) or stroke in changes or (lines[stroke][0] != lines[stroke - 1][-1]).any():
            break
        # A dot where a line ends is drawn with it.
        pieces.append(lines[stroke][1:])
        places += [Place(stroke, k) for k in range(1, len(lines[stroke]))]
    return np.concatenate(pieces), places


def _checked(text: str) -> bytes:
    return f"{text} {zlib.crc32(text.encode()):08x}\n".encode()


def _is_whole(line: bytes) -> bool:
    text = line.decode("ascii", "replace").rpartition(" ")[0]
    return bool(text) and line == _checked(text)
