"""``limner plan`` for a plotter: a drawing and a machine in; its time and travel, and a film of it, out."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import click

from limner import storage, units
from limner.cli import machines
from limner.cli.words import clock, many
from limner.errors import BadInput
from limner.motion.cost import Costs, costs
from limner.motion.machine import Machine, load_machine
from limner.motion.pen import plan as plan_path
from limner.pipeline import Settings
from limner.settings import write_toml
from limner.targets import animation, files, movie
from limner.types import Drawing, PenPath

MOVIES: dict[str, Callable[[Drawing, PenPath, float], bytes]] = {
    ".gif": movie.to_gif,
    ".mp4": movie.to_mp4,
    ".svg": animation.to_animated_svg,
}
"""What a film can be saved as."""


@dataclass(frozen=True)
class PlotterWish:
    """What is planned, and what is written of it.

    Attributes:
        drawing: its file.
        machine: name or file of the machine; None: an AxiDraw.
        shrink: whether a drawing that is too large is shrunk to the work area.
        out: files for the drawing.
        film: file for a film, or None.
        movie_time: how long that is, with its unit.
        path_file: file for where the pen is when, or None.
        save_machine: file for the machine, or None.
        as_json: whether the report is printed as JSON.
    """

    drawing: str
    machine: str | None
    shrink: bool
    out: tuple[str, ...]
    film: str | None
    movie_time: str
    path_file: str | None
    save_machine: str | None
    as_json: bool


def plan(wish: PlotterWish, settings: Settings) -> None:
    """Plan, write what is wished for, and tell.

    Raises:
        LimnerError: whatever stands in the way.
    """
    for file in wish.out:
        files.check_format(file)
    if wish.film is not None and Path(wish.film).suffix.lower() not in MOVIES:
        raise BadInput(f"{wish.film}: cannot save a film as '{Path(wish.film).suffix}'; choose {', '.join(MOVIES)}")
    film_s = units.parse_time_s(wish.movie_time, "--movie-time")
    machine = load_machine(wish.machine or "axidraw")
    if wish.save_machine is not None:
        storage.write_whole(wish.save_machine, write_toml(machine).encode())
    drawing = machines.placed(wish.drawing, machine, wish.shrink)
    told = costs(drawing, machine)
    for file in wish.out:
        gcode = machines.gcode_for(settings.gcode, machine)
        storage.write_whole(file, files.to_bytes(drawing, files.check_format(file), plotter=gcode))
    _write_motion(wish, drawing, machine, film_s)
    _tell(told, machine, [*wish.out, *filter(None, (wish.film, wish.path_file, wish.save_machine))], wish)


def _write_motion(wish: PlotterWish, drawing: Drawing, machine: Machine, film_s: float) -> None:
    """The film and the path, where they are wished for."""
    if wish.film is None and wish.path_file is None:
        return
    path = plan_path(drawing, machine)
    if wish.film is not None:
        storage.write_whole(wish.film, MOVIES[Path(wish.film).suffix.lower()](drawing, path, film_s))
    if wish.path_file is not None:
        storage.save(path, wish.path_file)


def _tell(told: Costs, machine: Machine, written: list[str], wish: PlotterWish) -> None:
    if wish.as_json:
        click.echo(json.dumps({**dataclasses.asdict(told), "machine": machine.to_dict(), "out": written}))
        return
    for line in (summary(told, machine.name), *written):
        click.echo(line, err=True)


def summary(told: Costs, machine: str) -> str:
    """What it costs, in one line."""
    return (
        f"{machine}: {clock(told.seconds)} for {many(told.strokes, 'stroke')} and {many(told.points, 'point')}:"
        f" {clock(told.draw_s)} drawing {told.ink_mm / 1000:.2f} m of ink,"
        f" {clock(told.travel_s)} on {told.travel_mm / 1000:.2f} m between strokes,"
        f" {clock(told.lift_s)} for {many(told.lifts, 'lift')}"
    )
