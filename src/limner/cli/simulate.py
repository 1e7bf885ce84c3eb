"""``limner simulate``: the motion of an arm in; the ink it really leaves, the force, and how near the plan, out."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

from limner import storage
from limner.cli import options
from limner.cli.gathered import gathered
from limner.cli.progress import bars
from limner.errors import BadInput
from limner.motion.arm.pen_check import USUAL, Allowed
from limner.motion.arm.robot import Robot
from limner.motion.arm.robots import ROBOTS, load_robot
from limner.pipeline import Settings
from limner.simulation import film, pictures
from limner.simulation.outcome import Simulation, simulate as simulate_arm
from limner.simulation.settings import SimulationSettings
from limner.simulation.thesis import beside_the_thesis
from limner.targets import files, image, joints
from limner.targets.sheet import Tile, to_sheet
from limner.types import Drawing, JointTrajectory, Pen, Photo
from limner.vision.photo import load_photo

faults: tuple[Callable[[Any], Any], ...] = (
    options.flag("simulation.fault.paper_mm", "--paper-error", metavar="MM"),
    options.flag("simulation.fault.tilt_deg", "--tilt", metavar="DEG"),
    options.flag("simulation.fault.repeat_mm", "--noise", metavar="MM"),
    options.flag("simulation.fault.jitter_ms", "--jitter", metavar="MS"),
    options.flag("simulation.fault.seed", "--seed", metavar="N"),
)


@dataclass(frozen=True)
class SimulateWish:
    """What is simulated, and what is written of it.

    Attributes:
        trajectory: file of the motion.
        robot: name or URDF.
        drawing: file of what is drawn, or None.
        photo: file that is shown beside the ink, or None.
        out: folder for the results, or None.
        film_kind: gif, mp4 or None.
        thesis: whether it is drawn as the thesis's arm did, too.
        stiff: whether the pen is held stiffly.
        as_json: whether the report is printed as JSON.
    """

    trajectory: str
    robot: str
    drawing: str | None
    photo: str | None
    out: str | None
    film_kind: str | None
    thesis: bool
    stiff: bool
    as_json: bool


@click.command(short_help="Let a simulated robot arm draw, with physics and faults.")
@click.argument("trajectory", metavar="TRAJECTORY")
@click.option(
    "--robot",
    default="dumbo",
    metavar="NAME",
    help=f"The arm: {', '.join(ROBOTS)}, or a URDF of your own. Default: dumbo.",
)
@click.option(
    "--drawing",
    metavar="FILE",
    help=f"What is drawn ({', '.join(files.READABLE)}): tells the page's size and turn, which a trajectory does not.",
)
@click.option("--photo", metavar="FILE", help="Of whom it is: shown beside the ink (beside.png) and in the film.")
@click.option("--out", "-o", metavar="DIR", help="Folder for ink.svg, ink.png, overlay.png, force.png, report.json.")
@click.option(
    "--film",
    "film_kind",
    type=click.Choice(["gif", "mp4"]),
    help="Also make a film of the arm drawing; takes a minute.",
)
@click.option("--thesis", is_flag=True, help="Also draw as the thesis's arm did, beside this: thesis.png.")
@click.option("--stiff", is_flag=True, help="The pen is held stiffly instead of by a spring.")
@options.together(faults)
@options.settings_options
@options.json_option
@click.pass_context
@gathered(SimulateWish)
def simulate(ctx: click.Context, wish: SimulateWish, save_settings: Path | None) -> None:
    """Let a simulated arm draw TRAJECTORY (of `limner plan --robot`): .json, .npz or .csv.

    MuJoCo simulates servos, gravity, the sprung pen and its friction on the paper. Where the sheet lies is computed
    from the trajectory's own pen-down places, less the press that it was planned with. A trajectory that exceeds a
    limit of the robot is refused.
    """
    settings = options.chosen_settings(ctx, Settings, save_settings)
    if (wish.film_kind or wish.thesis or wish.photo) and not wish.out:
        raise BadInput("--film, --thesis and --photo need a folder to write to; name one with --out")
    shown = load_photo(wish.photo) if wish.photo else None
    chosen = settings.simulation.replace(stiff=True) if wish.stiff else settings.simulation
    arm = load_robot(wish.robot)
    drawn = files.read_drawing(wish.drawing) if wish.drawing else None
    motion = joints.load(wish.trajectory)
    pen = drawn.pen if drawn else settings.page.pen()
    wanted = Wanted(wish.out, wish.film_kind, wish.thesis, shown, settings.arm.allowed)
    report = simulated(motion, arm, chosen, drawn, pen, wanted)
    if wish.as_json:
        click.echo(json.dumps(report))
    else:
        click.echo("\n".join([*summary(report), *report["out"]]), err=True)


@dataclass(frozen=True)
class Wanted:
    """What is written of a simulation: nothing without a folder; ``film`` is gif, mp4 or None; ``photo`` beside it.

    Nothing at all is written of a motion whose pen does more than is ``allowed``.
    """

    folder: str | None
    film: str | None = None
    thesis: bool = False
    photo: Photo | None = None
    allowed: Allowed = USUAL


def simulated(
    motion: JointTrajectory, arm: Robot, settings: SimulationSettings, drawn: Drawing | None, pen: Pen, wanted: Wanted
) -> dict[str, Any]:
    """Simulate, write what is wanted, and tell.

    Raises:
        LimnerError: whatever stands in the way.
    """
    with bars() as watch:
        made = simulate_arm(motion, arm, settings, drawn, watch, wanted.allowed)
    report = made.report() | {"settings": settings.to_dict()}
    written = write(made, pen, report, wanted) if wanted.folder else []
    return report | {"out": written}


def write(made: Simulation, pen: Pen, report: dict[str, Any], wanted: Wanted) -> list[str]:
    """Everything wanted of a simulation, as files; their names."""
    folder = storage.make_folder(wanted.folder or ".")
    written = {
        "ink.svg": pictures.ink_svg(made, pen),
        "ink.png": image.encode_png(pictures.ink_picture(made, pen)),
        "overlay.png": image.encode_png(pictures.overlay_picture(made, pen)),
        "force.png": image.encode_png(pictures.force_picture(made)),
        "report.json": (json.dumps(report, indent=1) + "\n").encode(),
    }
    if wanted.photo is not None:
        beside = to_sheet([Tile(wanted.photo.rgb, "photo"), Tile(pictures.ink_picture(made, pen), "ink")], 2, 700)
        written["beside.png"] = image.encode_png(beside)
    if wanted.thesis:
        written["thesis.png"] = image.encode_png(beside_the_thesis(made, pen))
    if wanted.film:
        written[f"film.{wanted.film}"] = film.to_film(made, pen, f".{wanted.film}", photo=wanted.photo)
    for name, data in written.items():
        storage.write_whole(folder / name, data)
    return [str(folder / name) for name in written]


def summary(report: dict[str, Any]) -> list[str]:
    """What came of it, in a few lines."""
    error, force, tracking = report["ink_error_mm"], report["force_n"], report["tracking_mm"]
    if error["p95"] is None:
        return [f"{report['robot']}: the pen never touched the paper in {report['seconds']:.0f} s"]
    return [
        f"{report['robot']}: {report['ink_mm'] / 1000:.2f} m of ink in {report['seconds']:.0f} s;"
        f" the pen touched for {report['contact_percent']:.1f} % of what was planned,"
        f" {report['travel_ink_mm']:.1f} mm of ink in travel",
        f"ink: 95 % within {error['p95']:.2f} mm of the plan, all within {error['max']:.2f} mm;"
        f" force {force['p5']:.2f} to {force['p95']:.2f} N;"
        f" the tip follows to {tracking['rms']:.2f} mm (root mean square)",
    ]
