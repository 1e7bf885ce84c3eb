"""One photo of many goes in; its drawing's files and its row of figures come out. This is what workers run."""

from __future__ import annotations

import resource
import sys
import time
from dataclasses import dataclass, field
from typing import Any

from limner import __version__, storage
from limner.batch import remote, source
from limner.batch.threads import hold_threads
from limner.batch.tile import tile_of
from limner.drawing.measure import measure
from limner.errors import BadInput, LimnerError, MissingExtra
from limner.pipeline import Portrait, Settings, draw, refine_face
from limner.settings import AUTO
from limner.targets.files import to_bytes
from limner.types import Face, Photo
from limner.vision.photo import load_photo

TRAJECTORY = "trajectory"
"""Of ``Recipe.formats``: the motion of an arm that draws it."""


@dataclass(frozen=True)
class Recipe:
    """What is made of every photo.

    Attributes:
        settings: of every stage.
        formats: suffixes of ``pipeline.FORMATS`` without their dots, and ``trajectory``.
        robot: whose trajectory.
        out: folder or URL that the worker writes to; None: the files are handed back.
        version: of limner.
    """

    settings: Settings
    formats: tuple[str, ...] = ("svg",)
    robot: str = "dumbo"
    out: str | None = None
    version: str = __version__

    def names(self, stem: str) -> list[str]:
        """Of the files that are written for a photo, in the order of the formats."""
        return [f"{stem}.{'trajectory.json' if kind == TRAJECTORY else kind}" for kind in self.formats]


@dataclass(frozen=True)
class Job:
    """One photo.

    Attributes:
        photo: path or URL, read by the worker unless ``data`` is given.
        digest: SHA-256 of its bytes.
        name: of the drawing, without suffix.
        face: drawn instead of looking for one.
        data: its bytes, where they were sent along.
        tile: whether a tile for the contact sheet is wanted.
    """

    photo: str
    digest: str
    name: str
    face: Face | None = None
    data: bytes | None = None
    tile: bool = False


@dataclass(frozen=True)
class Drawn:
    """What became of a photo.

    Attributes:
        figures: of the row, by name.
        error: one line; empty where it was drawn.
        final: whether the same photo and settings would end the same.
        files: name -> bytes, where they are handed back.
        tile: of the contact sheet, if wanted.
        peak_mb: memory that the worker has needed so far, at most.
        cpu_s: time of a core that it took.
    """

    figures: dict[str, Any] = field(default_factory=dict)
    error: str = ""
    final: bool = True
    files: dict[str, bytes] = field(default_factory=dict)
    tile: bytes = b""
    peak_mb: float = 0.0
    cpu_s: float = 0.0


def draw_one(job: Job, recipe: Recipe) -> Drawn:
    """Draw a photo; what is wrong with it is a result like any other.

    Raises:
        BadInput: the files cannot be written, or this worker has another version: there is no going on.
    """
    if recipe.version != __version__:
        raise BadInput(f"a worker has limner {__version__}, expected {recipe.version}")
    hold_threads()
    start, cpu = time.perf_counter(), time.process_time()
    try:
        portrait = _portrait(job, recipe.settings)
        files = dict(
            zip(recipe.names(job.name), (_file(portrait, kind, recipe) for kind in recipe.formats), strict=True)
        )
        tile = tile_of(portrait) if job.tile else b""
    except LimnerError as error:
        return _failed(str(error), start, not isinstance(error, MissingExtra | source.Unread))
    except MemoryError:
        return _failed("not enough memory for this photo", start, False)
    except Exception as error:  # a bug at one photo is not the end of the others
        return _failed(f"a bug in limner: {type(error).__name__}: {error}", start, False)
    figures = _figures(portrait) | {"seconds": time.perf_counter() - start}
    for name, data in files.items() if recipe.out is not None else ():
        write(f"{recipe.out}/{name}", data)
    handed = {} if recipe.out is not None else files
    return Drawn(figures, files=handed, tile=tile, peak_mb=_peak_mb(), cpu_s=time.process_time() - cpu)


def write(place: str, data: bytes) -> None:
    """Write a file whole, to a path or an URL.

    Raises:
        BadInput: it cannot be written.
    """
    if remote.is_url(place):
        remote.write(place, data)
    else:
        storage.write_whole(place, data)


def _portrait(job: Job, settings: Settings) -> Portrait:
    data = source.read(job.photo) if job.data is None else job.data
    if not data:
        raise BadInput("the file is empty")
    if source.digest(data) != job.digest:
        raise source.Unread("the file changed while it was being read; run again")
    photo = load_photo(data)
    return draw(photo, settings, face=_given(job.face, photo, settings))


def _given(face: Face | None, photo: Photo, settings: Settings) -> Face | None:
    """A face from a file, corrected only where the settings ask for it by name."""
    return face if face is None or settings.refine == AUTO else refine_face(photo, face, settings)


def _file(portrait: Portrait, kind: str, recipe: Recipe) -> bytes:
    if kind == TRAJECTORY:
        return _motion(portrait, recipe.robot)
    if kind == "svg":
        return portrait.svg()
    return to_bytes(portrait.drawing, f".{kind}", portrait.about(), portrait.settings.gcode)


def _motion(portrait: Portrait, robot: str) -> bytes:
    from limner.motion.arm.plan import plan_arm
    from limner.motion.arm.robots import load_robot

    planned = plan_arm(portrait.drawing, load_robot(robot), portrait.settings.arm)
    return (storage.to_json(planned.trajectory) + "\n").encode()


def _figures(portrait: Portrait) -> dict[str, Any]:
    costs = measure(portrait.drawing)
    return {
        "faces": len(portrait.faces),
        "strokes": costs.strokes,
        "points": costs.points,
        "ink_mm": round(costs.ink_mm, 3),
        "travel_mm": round(costs.travel_mm, 3),
    }


def _failed(why: str, start: float, final: bool) -> Drawn:
    return Drawn(
        {"seconds": time.perf_counter() - start}, " ".join(why.split()) or "unknown", final, peak_mb=_peak_mb()
    )


def _peak_mb() -> float:
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return float(peak) / (2**20 if sys.platform == "darwin" else 2**10)
