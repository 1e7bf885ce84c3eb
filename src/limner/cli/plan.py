"""``limner plan``: a drawing and a machine in, its time and travel out, and a film of it."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable
from pathlib import Path

import click

from limner import storage, units
from limner.cli import arm, machines, options
from limner.errors import BadInput
from limner.motion.arm.robots import ROBOTS
from limner.motion.cost import Costs, costs
from limner.motion.machine import load_machine
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

_PLOTTER = {
    "--machine": "machine",
    "--fit": "shrink",
    "--movie": "film",
    "--path": "path_file",
    "--save-machine": "save_machine",
}
_ARM = {"--bag": "bags", "--calibration": "calibration", "--waypoints": "waypoints", "--reach": "reach"}


@click.command(
    short_help="Tell how long a machine draws, and show it.",
    help=f"""Tell how long a machine needs for DRAWING, and show it.

    {machines.READS}""",
)
@machines.drawing_argument
@machines.machine_option
@machines.fit_option
@click.option(
    "--out",
    "-o",
    multiple=True,
    metavar="FILE",
    help=f"Write the drawing: {', '.join(files.FORMATS)}; may be repeated.",
)
@click.option("--movie", "film", metavar="FILE", help=f"Write a film of the drawing being drawn: {', '.join(MOVIES)}.")
@click.option("--movie-time", default="10s", metavar="TIME", help="Length of the film. Default: 10s.")
@click.option("--path", "path_file", metavar="FILE", help="Write where the pen is at which time: .json or .npz.")
@click.option(
    "--robot",
    metavar="NAME",
    help=f"An arm draws instead: {', '.join(ROBOTS)}, or a URDF of your own. --out then takes its motion:"
    f" {', '.join(arm.FORMATS)}.",
)
@options.flag("arm.place.at", "--place", metavar="X,Y,Z[,TURN]")
@options.switch("arm.retime.jerk_limited", "--jerk-limited")
@click.option(
    "--calibration",
    metavar="FILE",
    help="With --robot: points probed on the sheet, the lower left corner first, then one on the lower edge: .json or"
    " .csv in metres.",
)
@click.option("--waypoints", metavar="FILE", help="With --robot: write the poses of the pen's tip as .json or .csv.")
@click.option(
    "--bag",
    "bags",
    multiple=True,
    metavar="FILE",
    help="With --robot: write all that ROS would hear (path, ink, trajectory, joint states, frames), to play in rviz:"
    " .bag for ROS 1; .mcap or .db3 for ROS 2, a folder of that name, for `ros2 bag play`; may be repeated.",
)
@click.option("--reach", metavar="FILE", help="With --robot: write a map of where the pen can be held as .png.")
@click.option("--save-machine", metavar="FILE", help="Write the machine as .toml, to change and use as --machine.")
@options.settings_options
@options.json_option
@click.pass_context
def plan(
    ctx: click.Context,
    drawing: str,
    machine: str | None,
    shrink: bool,
    out: tuple[str, ...],
    film: str | None,
    movie_time: str,
    path_file: str | None,
    save_machine: str | None,
    robot: str | None,
    calibration: str | None,
    bags: tuple[str, ...],
    waypoints: str | None,
    reach: str | None,
    save_settings: Path | None,
    as_json: bool,
) -> None:
    """See ``help`` above, which names the formats."""
    settings = options.chosen_settings(ctx, Settings, save_settings)
    if robot is not None:
        if unused := [name for name, value in _PLOTTER.items() if ctx.params[value]]:
            raise BadInput(f"{unused[0]} is for plotters; leave it out with --robot")
        arm.plan(
            drawing,
            robot,
            settings,
            out=out,
            bags=bags,
            calibration=calibration,
            waypoints=waypoints,
            reach=reach,
            as_json=as_json,
        )
        return
    if unused := [name for name, value in _ARM.items() if ctx.params[value]]:
        raise BadInput(f"{unused[0]} is for arms; name one with --robot")
    for file in out:
        files.check_format(file)
    if film is not None and Path(film).suffix.lower() not in MOVIES:
        raise BadInput(f"{film}: cannot save a film as '{Path(film).suffix}'; choose {', '.join(MOVIES)}")
    film_s = units.parse_time_s(movie_time, "--movie-time")
    mover = load_machine(machine or "axidraw")
    if save_machine is not None:
        storage.write_whole(save_machine, write_toml(mover).encode())
    placed = machines.placed(drawing, mover, shrink)
    told = costs(placed, mover)
    for file in out:
        data = files.to_bytes(placed, files.check_format(file), plotter=machines.gcode_for(settings.gcode, mover))
        storage.write_whole(file, data)
    if film is not None or path_file is not None:
        path = plan_path(placed, mover)
        if film is not None:
            storage.write_whole(film, MOVIES[Path(film).suffix.lower()](placed, path, film_s))
        if path_file is not None:
            storage.save(path, path_file)
    written = [*out, *filter(None, (film, path_file, save_machine))]
    if as_json:
        click.echo(json.dumps({**dataclasses.asdict(told), "machine": mover.to_dict(), "out": written}))
    else:
        click.echo(summary(told, mover.name), err=True)
        for file in written:
            click.echo(file, err=True)


def summary(told: Costs, machine: str) -> str:
    """What it costs, in one line."""
    return (
        f"{machine}: {clock(told.seconds)} for {many(told.strokes, 'stroke')} and {many(told.points, 'point')}:"
        f" {clock(told.draw_s)} drawing {told.ink_mm / 1000:.2f} m of ink,"
        f" {clock(told.travel_s)} on {told.travel_mm / 1000:.2f} m between strokes,"
        f" {clock(told.lift_s)} for {many(told.lifts, 'lift')}"
    )


def many(count: int, what: str) -> str:
    """So many of it: 1 stroke, 2 strokes."""
    return f"{count} {what}{'' if count == 1 else 's'}"


def clock(seconds: float) -> str:
    """Seconds as one says them: 42 s, 3:05 min, 1:02:03 h."""
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60}:{whole % 60:02d} min"
    return f"{whole // 3600}:{whole // 60 % 60:02d}:{whole % 60:02d} h"
