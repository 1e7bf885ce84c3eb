"""``limner draw``: a photo in, an SVG of ordered strokes out."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

from limner import pipeline, storage
from limner.cli import options
from limner.cli.gathered import gathered
from limner.cli.progress import busy
from limner.cli.words import many
from limner.errors import BadInput, CannotDraw
from limner.pipeline import Settings
from limner.targets.image import encode_png
from limner.vision.likeness.candidates import why


@dataclass(frozen=True)
class DrawWish:
    """What is drawn, and what is written of it.

    Attributes:
        photo: file, or ``-``.
        crop: x, y, width, height [px] of the part that is looked at; None: all.
        number: which face, 1 = the largest, which None is too.
        out: files for the drawing; none: one called as the photo.
        picture: file for the picture in colours, or None.
        refuse_bad: whether nothing is drawn of a bad photo.
        robot: that draws in the simulation; None: Dumbo.
        simulation: folder for what a simulated arm draws, or None.
        as_json: whether the report is printed as JSON.
    """

    photo: str
    crop: tuple[int, int, int, int] | None
    number: int | None
    out: tuple[str, ...]
    picture: str | None
    refuse_bad: bool
    robot: str | None
    simulation: str | None
    as_json: bool


@click.command(short_help="Draw the person in a photo as ordered pen strokes.")
@click.option(
    "--out",
    "-o",
    multiple=True,
    metavar="FILE",
    help=f"Where to: {', '.join(pipeline.FORMATS)}, - for SVG on stdout; may be repeated. Default: the photo's name"
    " as .svg.",
)
@options.flag("style", "--style", "-s", metavar="STYLE")
@options.drawing_options
@options.flag("tone.level", "--tone", metavar="LEVEL")
@options.flag("complete", "--complete", metavar="FEATURES")
@click.option(
    "--picture",
    metavar="FILE",
    help=f"Write the picture in colours, a .png, too; of the styles {', '.join(pipeline.PICTURES)}.",
)
@options.photo_options
@click.option("--refuse-bad", is_flag=True, help="Draw nothing from a bad photo (blurred, dark, covered, ...).")
@click.option(
    "--simulate",
    "simulation",
    metavar="DIR",
    help="Let a simulated robot arm draw it: trajectory, ink, force and report go into this folder.",
)
@click.option("--robot", metavar="NAME", help="With --simulate: the arm that draws. Default: dumbo.")
@options.settings_options
@options.json_option
@click.pass_context
@gathered(DrawWish)
def draw(ctx: click.Context, wish: DrawWish, save_settings: Path | None) -> None:
    """Draw the person in PHOTO as ordered pen strokes.

    PHOTO is a JPEG, PNG, WebP or HEIC file, or - for standard input. A bad photo is drawn too, with a note that says
    what would help.
    """
    settings = options.chosen_settings(ctx, Settings, save_settings)
    outs = wish.out or (default_out(wish.photo),)
    _check(wish, outs, settings)
    with busy(f"drawing in the style {settings.style}"):
        portrait = pipeline.draw(wish.photo, settings, crop=wish.crop, number=wish.number or 1)
    if wish.refuse_bad and portrait.photo_notes:
        raise CannotDraw(f"{wish.photo}: {portrait.photo_notes[0]}")
    for path in outs:
        write(portrait, path)
    if wish.picture is not None:
        storage.write_whole(wish.picture, encode_png(portrait.picture()))
        outs = (*outs, wish.picture)
    for note in (*portrait.photo_notes, *pipeline.without_effect(settings.style, settings)):
        click.echo(f"note: {note}", err=True)
    if portrait.candidates:
        click.echo(why(portrait.candidates), err=True)
    simulated = arm_draws(portrait, wish.robot or "dumbo", wish.simulation) if wish.simulation else {}
    report = portrait.report() | simulated | {"out": [path for path in outs if path != "-"]}
    if wish.as_json:
        click.echo(json.dumps(report))
    else:
        click.echo(summary(report), err=True)


def _check(wish: DrawWish, outs: tuple[str, ...], settings: Settings) -> None:
    """Say before any work what cannot be done.

    Raises:
        BadInput: options that do not go together, or no such format.
    """
    if wish.robot and not wish.simulation:
        raise BadInput("--robot is for --simulate DIR; name the folder that its results go to")
    if wish.picture is not None:
        options.check_suffix(wish.picture, ".png")
        if settings.style not in pipeline.PICTURES:
            raise BadInput(f"--picture: style '{settings.style}' has none; choose {' or '.join(pipeline.PICTURES)}")
    for path in outs:
        if path != "-":
            pipeline.check_format(path)


def arm_draws(portrait: pipeline.Portrait, robot: str, folder: str) -> dict[str, Any]:
    """Plan the portrait for an arm, simulate it, and write both into a folder; ``simulation`` of the report.

    Raises:
        LimnerError: whatever stands in the way.
    """
    from limner.cli.simulate import Wanted, simulated, summary as told
    from limner.motion.arm.plan import plan_arm
    from limner.motion.arm.robots import load_robot

    arm, settings = load_robot(robot), portrait.settings
    with busy(f"looking for the place of the sheet and the motion of {arm.name}"):
        planned = plan_arm(portrait.drawing, arm, settings.arm)
    pen = portrait.drawing.pen
    wanted = Wanted(folder, photo=portrait.photo, allowed=settings.arm.allowed)
    report = simulated(planned.trajectory, arm, settings.simulation, portrait.drawing, pen, wanted)
    storage.save(planned.trajectory, Path(folder) / "trajectory.json")
    for line in told(report):
        click.echo(line, err=True)
    return {"simulation": report | {"plan": planned.report()}}


def default_out(photo: str) -> str:
    """The photo's name with .svg, in the folder one is in."""
    return f"{options.stem(photo)}.svg"


def write(portrait: pipeline.Portrait, path: str) -> None:
    """Write a portrait to a file, or as SVG to stdout."""
    if path == "-":
        click.echo(portrait.svg(), nl=False)
    else:
        portrait.save(path)


def summary(report: dict[str, Any]) -> str:
    """What was drawn, in a few lines."""
    others = f"; {report['faces'] - 1} more in the photo, choose with --face" if report["faces"] > 1 else ""
    lines = [
        f"{report['style']}: {many(report['strokes'], 'stroke')}, {many(report['points'], 'point')}, "
        f"{report['ink_mm'] / 1000:.2f} m of ink, {report['travel_mm'] / 1000:.2f} m between strokes{price(report)}, "
        f"likeness {report['likeness']:.2f}, "
        f"{report['seconds']['total']:.1f} s{others}"
    ]
    return "\n".join(lines + report["out"] + report.get("simulation", {}).get("out", []))


def price(report: dict[str, Any]) -> str:
    """What the order for an audience costs, if it is drawn in that."""
    shortest = report.get("shortest_travel_mm")
    return "" if shortest is None else f" for the audience ({shortest / 1000:.2f} m would do)"
