"""``limner evaluate``: measurements that anyone can run, as tables or JSON."""

from __future__ import annotations

import dataclasses
import json
import tempfile
from pathlib import Path
from typing import Any

import click
from rich.console import Console
from rich.table import Table

from limner import pipeline, storage
from limner.cli import options
from limner.cli.gallery import gallery
from limner.cli.groups import Group
from limner.cli.landmarks import landmarks
from limner.cli.likeness import likeness
from limner.cli.progress import bars
from limner.cli.tables import figures, tables
from limner.cli.thesis import thesis
from limner.errors import BadInput
from limner.evaluate import bench
from limner.evaluate.arm import measure_arm
from limner.evaluate.false_alarms import sample_folder
from limner.evaluate.speed import Row, measure_speed
from limner.evaluate.strokes import measure_strokes
from limner.evaluate.studio import measure_studio
from limner.motion.arm.robots import load_robot
from limner.pipeline import Settings
from limner.types import Photo
from limner.vision.photo import load_photo


@click.group(cls=Group, short_help="Measure accuracy and speed.")
def evaluate() -> None:
    """Measure accuracy and speed."""


@evaluate.command(short_help="Time every stage, and measure the memory of `limner draw`.")
@click.argument("photo", metavar="[PHOTO]", required=False)
@click.option("--runs", type=click.IntRange(1), default=5, metavar="N", help="Runs of each figure. Default: 5.")
@click.option(
    "--models",
    type=click.Path(exists=True, file_okay=False, path_type=Path),
    metavar="DIR",
    help="Folder of the models of Zhu & Ramanan (face_p146_small.mat, face_p99.mat), to be timed too.",
)
@click.option(
    "--batch",
    "count",
    type=click.IntRange(0),
    default=0,
    metavar="N",
    help="Also stages by size, batches of N photos by 1 and 2 workers and a Dask cluster of 2, and other programs.",
)
@click.option(
    "--write", metavar="DIR", help="With --batch: write benchmarks.md and its picture into this folder; docs has them."
)
@options.json_option
def speed(photo: str | None, runs: int, models: Path | None, count: int, write: str | None, as_json: bool) -> None:
    """Time every stage on PHOTO, by default the astronaut of scikit-image, and measure the memory of `limner draw`."""
    if write and not count:
        raise BadInput("--write is for --batch N; say how many photos")
    picture = load_photo(photo or astronaut())
    rows = list(measure_speed(picture, runs, models))
    if models is None:
        click.echo("the authors' models were not timed: no folder of them was given (--models)", err=True)
    whole = _bench(picture, rows, count, write) if count else {"speed": [dataclasses.asdict(row) for row in rows]}
    if as_json:
        click.echo(json.dumps(whole))
    else:
        Console(highlight=False).print(speed_table(rows))


def _bench(photo: Photo, rows: list[Row], count: int, write: str | None) -> dict[str, Any]:
    """Measure the rest, and write the page."""
    with tempfile.TemporaryDirectory() as folder:
        measured = bench.run_bench(photo, rows, count, Path(folder))
    if write:
        for name, text in ((bench.PAGE, bench.to_markdown(measured)), (bench.PICTURE, bench.to_picture(measured))):
            storage.write_whole(Path(write) / name, text.encode())
            click.echo(str(Path(write) / name), err=True)
    return measured.to_dict()


@evaluate.command(short_help="Time `limner studio`: its start, photo to drawing, sliders.")
@click.argument("photo", metavar="[PHOTO]", required=False)
@click.option("--runs", type=click.IntRange(1), default=10, metavar="N", help="Runs of each slider. Default: 10.")
@click.option("--photos", type=click.IntRange(1), default=200, metavar="N", help="For its memory. Default: 200.")
@options.json_option
def studio(photo: str | None, runs: int, photos: int, as_json: bool) -> None:
    """Time `limner studio` on PHOTO: its start, photo to drawing, slider to preview; its memory over many photos."""
    rows = list(measure_studio(load_photo(photo or astronaut()), runs, photos))
    if as_json:
        click.echo(json.dumps({"studio": [dataclasses.asdict(row) for row in rows]}))
    else:
        Console(highlight=False).print(speed_table(rows, "limner studio: speed and memory"))


@evaluate.command(short_help="Measure travel, against a long search, and curves.")
@click.argument("photo", metavar="[PHOTO]", required=False)
@click.option("--kicks", type=click.IntRange(1), default=200, metavar="N", help="Of the long search. Default: 200.")
@options.json_option
def strokes(photo: str | None, kicks: int, as_json: bool) -> None:
    """Measure travel, against a long search and vpype if it is installed, and curves, on PHOTO and on made strokes."""
    fine = Settings().assign("style", "gabor").assign("clean.tolerance_mm", "0.02").assign("order.by", "given")
    portrait = pipeline.draw(photo or astronaut(), fine)
    rows = list(measure_strokes(portrait.drawing, kicks=kicks))
    if as_json:
        click.echo(json.dumps({"strokes": [dataclasses.asdict(row) for row in rows]}))
    else:
        Console(highlight=False).print(speed_table(rows, "limner: strokes", 3))


@evaluate.command(short_help="Plan and simulate how an arm draws, the thesis's way beside it.")
@click.argument("photo", metavar="[PHOTO]", required=False)
@click.option("--robot", default="dumbo", metavar="NAME", help="The arm, or a URDF of your own. Default: dumbo.")
@click.option("--points", "-n", type=click.IntRange(10), default=600, metavar="N", help="At most. Default: 600.")
@options.json_option
def arm(photo: str | None, robot: str, points: int, as_json: bool) -> None:
    """Plan and simulate how an arm draws PHOTO; limits, inverse kinematics, ink, and the thesis's way beside it."""
    settings = Settings().assign("select.points", str(points))
    drawing = pipeline.draw(photo or astronaut(), settings).drawing
    rows = list(measure_arm(drawing, load_robot(robot), settings.arm, settings.simulation))
    if as_json:
        click.echo(json.dumps({"arm": [dataclasses.asdict(row) for row in rows]}))
    else:
        Console(highlight=False).print(speed_table(rows, f"limner: {robot}", 3))


def speed_table(rows: list[Row], title: str = "limner: speed and memory", digits: int = 0) -> Table:
    """Figures beside what was promised."""
    table = Table("", "measured" if digits else "median", "at most", "", title=title, title_justify="left")
    table.columns[1].justify = table.columns[2].justify = "right"
    for row in rows:
        goal = "" if row.goal is None else f"{row.goal:.{digits}f} {row.unit}"
        verdict = "" if row.goal is None else "yes" if row.reached else "[bold]no[/bold]"
        table.add_row(row.name, f"{row.value:.{digits}f} {row.unit}", goal, verdict)
    return table


def astronaut() -> Path:
    """The portrait of Eileen Collins that scikit-image ships (NASA, public domain).

    Raises:
        MissingExtra: scikit-image is not installed.
    """
    return sample_folder() / "astronaut.png"


@evaluate.command("ros", short_help="Time `limner ros`, from a photo to its trajectory.")
@click.argument("photo", metavar="[PHOTO]", required=False)
@click.option(
    "--portraits", type=click.IntRange(2), default=20, metavar="N", help="Drawn one after the other. Default: 20."
)
@options.json_option
def measure_ros(photo: str | None, portraits: int, as_json: bool) -> None:
    """Measure `limner ros` with a master of its own: from a photo's message to its trajectory, jitter, memory."""
    from limner.ros import measure

    with bars() as watch:
        found = measure.measure(
            load_photo(photo or astronaut()), portraits, lambda done: watch("portraits", done, portraits, "")
        )
    if as_json:
        click.echo(json.dumps({"ros": dataclasses.asdict(found)}))
        return
    rows = [
        Row("photo message to trajectory", found.photo_to_trajectory_s, "s", 3),
        Row("the same, CPU time of the node", found.photo_to_trajectory_cpu_s, "s", None),
        Row("joint states", found.joint_states_hz, "Hz", None),
        Row("jitter of joint states, median", found.jitter_ms, "ms", 5),
        Row("the same, 95 % within", found.jitter_p95_ms, "ms", None),
        Row(f"memory of the node grows over {found.portraits} portraits by", found.growth_mb, "MB", 60),
    ]
    Console(highlight=False).print(speed_table(rows, "limner ros", digits=2))


evaluate.add_command(landmarks)
evaluate.add_command(gallery)
evaluate.add_command(likeness)
evaluate.add_command(tables)
evaluate.add_command(figures)
evaluate.add_command(thesis)
