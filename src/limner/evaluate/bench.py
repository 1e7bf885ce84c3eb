"""A photo goes in; everything that is measured of speed in one run comes out, as Markdown with one picture."""

from __future__ import annotations

import dataclasses
import os
import platform
from collections.abc import Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import cv2

from limner.evaluate.bench_picture import Bar, Panel, to_svg
from limner.evaluate.peers import Peer, peers
from limner.evaluate.rates import Overhead, Rate, overhead, rates
from limner.evaluate.speed import CURVE_PX, LARGE_PX, Row, framed
from limner.evaluate.stages import Stage, stages_of
from limner.types import Photo

SIZES_PX = (CURVE_PX[0], CURVE_PX[1], CURVE_PX[2], LARGE_PX)
"""0.3, 1, 3 and 12 megapixels."""

PICTURE, PAGE = "benchmarks.svg", "benchmarks.md"

_TINY = 1000
_SHOWN_S = 0.005


@dataclass(frozen=True)
class Bench:
    """What one run measured.

    Attributes:
        machine: name -> what it is.
        rows: figures beside what was promised.
        stages: by megapixels.
        rates: of batches.
        overhead: of a batch.
        peers: side by side.
    """

    machine: dict[str, str]
    rows: tuple[Row, ...]
    stages: dict[float, list[Stage]]
    rates: tuple[Rate, ...]
    overhead: Overhead
    peers: tuple[Peer, ...]

    def to_dict(self) -> dict[str, Any]:
        """Plain values; the rows as ``speed``."""
        fields = dataclasses.asdict(self)
        return {"speed": fields.pop("rows")} | fields


def run_bench(photo: Photo, rows: Sequence[Row], count: int, folder: Path) -> Bench:
    """Measure stages, batches and peers.

    Args:
        photo: with a face; it is cut and scaled.
        rows: measured before.
        count: of photos in a batch.
        folder: for files in between.
    """
    about = machine()
    stages = {}
    for size in SIZES_PX:
        path = folder / f"{size[0]}.jpg"
        cv2.imwrite(str(path), framed(photo, size).rgb[..., ::-1])
        stages[round(size[0] * size[1] / 1e6, 1)] = stages_of(path)
    middle = framed(photo, SIZES_PX[1])
    many, small = tuple(rates(middle, count)), overhead(min(_TINY, 25 * count))
    about["load when batches had been measured"] = load()
    return Bench(about, tuple(rows), stages, many, small, tuple(peers(middle)))


def machine() -> dict[str, str]:
    """What this machine is, and how busy."""
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30 if hasattr(os, "sysconf") else 0
    libraries = ", ".join(f"{name} {version(name)}" for name in ("numpy", "opencv-python-headless", "pillow"))
    return {
        "processor": f"{_processor()}, {os.cpu_count()} cores",
        "memory": f"{memory:.0f} GB",
        "system": f"{platform.system()} {platform.machine()}, Python {platform.python_version()}, {libraries}",
        "load when it began": f"{load()} (figures hold where it is near 0)",
    }


def load() -> str:
    """How many processes want a core, of late."""
    return f"{os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else "unknown"


def _processor() -> str:
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.is_file() else []
    named = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(named, platform.processor() or platform.machine())


def to_markdown(bench: Bench) -> str:
    """The page."""
    parts = [
        "# Benchmarks",
        "`make bench` wrote this page and its picture in one run; run it on a quiet machine. Nothing in it was typed.",
        "\n".join(f"- {name}: {what}" for name, what in bench.machine.items()),
        f"![Time by stage, photos a minute, peers]({PICTURE})",
        "## Stage by stage\n\nOne drawing in the default style, libraries and models loaded: milliseconds, and the most"
        " memory of the whole process meanwhile [MB].",
        _stages(bench.stages),
        "## Many photos\n\n`limner batch` over photos of 1 megapixel, from the first row to the last.",
        _table(("", "photos a minute", "x one worker", "CPU for each", "peak memory of a worker"), _rates(bench.rates)),
        f"Beside drawing a batch costs {bench.overhead.ms_each:.2f} ms of CPU time for each photo in the process that"
        f" gives them out ({bench.overhead.photos} tiny pictures); the same run again, with nothing to do,"
        f" {bench.overhead.restart_s:.2f} s in all, its start included.",
        "## Beside others\n\nThe same photo of 1 megapixel, on A5. Likeness is limner's own measure.",
        _table(("", "seconds", "strokes", "points", "ink", "travel", "likeness"), map(_peer, bench.peers)),
        "## Figures beside what was promised",
        _table(("", "median", "at most", ""), map(_row, bench.rows)),
    ]
    return "\n\n".join(parts) + "\n"


def _table(heading: Sequence[str], rows: Any) -> str:
    lines = ["| " + " | ".join(heading) + " |", "|" + "---|" * len(heading)]
    return "\n".join([*lines, *("| " + " | ".join(row) + " |" for row in rows)])


def _stages(stages: dict[float, list[Stage]]) -> str:
    names = list(dict.fromkeys(stage.name for some in stages.values() for stage in some))
    by = {(size, stage.name): stage for size, some in stages.items() for stage in some}
    rows = []
    for name in names:
        here = [by.get((size, name)) for size in stages]
        if any(stage and stage.seconds >= _SHOWN_S for stage in here):
            rows.append([name, *(_cell(stage) for stage in here)])
    rows.append(["**all**", *(_sum(some) for some in stages.values())])
    return _table(("", *(f"{size:g} MP" for size in stages)), rows)


def _cell(stage: Stage | None) -> str:
    if stage is None:
        return "-"
    return f"{1000 * stage.seconds:.0f} ms" + ("" if stage.peak_mb is None else f", {stage.peak_mb:.0f} MB")


def _sum(stages: list[Stage]) -> str:
    peak = max((stage.peak_mb for stage in stages if stage.peak_mb is not None), default=None)
    return f"**{_cell(Stage('', sum(stage.seconds for stage in stages), peak))}**"


def _rates(measured: Sequence[Rate]) -> list[list[str]]:
    one = measured[0].per_minute
    return [
        [r.name, f"{r.per_minute:.0f}", f"{r.per_minute / one:.2f}", f"{r.cpu_s:.2f} s", f"{r.peak_mb:.0f} MB"]
        for r in measured
    ]


def _peer(peer: Peer) -> list[str]:
    likeness = "-" if peer.likeness is None else f"{peer.likeness:.2f}"
    lengths = (f"{peer.ink_mm / 1000:.1f} m", f"{peer.travel_mm / 1000:.1f} m")
    return [peer.name, f"{peer.seconds:.2f}", str(peer.strokes), str(peer.points), *lengths, likeness]


def _row(row: Row) -> list[str]:
    goal = "" if row.goal is None else f"{row.goal:.0f} {row.unit}"
    return [
        row.name,
        f"{row.value:.0f} {row.unit}",
        goal,
        "" if row.goal is None else "yes" if row.reached else "**no**",
    ]


def to_picture(bench: Bench) -> str:
    """The picture of the page, as SVG."""
    stages = [
        Bar(f"{size:g} MP", [(s.name, 1000 * s.seconds) for s in some if s.seconds >= _SHOWN_S], "ms")
        for size, some in bench.stages.items()
    ]
    many = [Bar(rate.name, [("", rate.per_minute)], "/min") for rate in bench.rates]
    points = [Bar(peer.name.partition(",")[0], [("", float(peer.points))], "points") for peer in bench.peers]
    return to_svg(
        [
            Panel("One photo, stage by stage", stages),
            Panel("Photos a minute, 1 megapixel", many),
            Panel("Points that the pen must go to", points),
        ]
    )
