"""``limner plan``: a drawing and a machine in, its time and travel out, and a film of it; or an arm's motion."""

from __future__ import annotations

from pathlib import Path

import click

from limner.cli import arm, machines, options, plotter
from limner.cli.gathered import gathered, refuse
from limner.cli.plotter import MOVIES, PlotterWish
from limner.motion.arm.robots import ROBOTS
from limner.pipeline import Settings
from limner.targets import files

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
@gathered(PlotterWish, arm.ArmWish)
def plan(
    ctx: click.Context,
    by_plotter: PlotterWish,
    by_arm: arm.ArmWish,
    robot: str | None,
    save_settings: Path | None,
) -> None:
    """See ``help`` above, which names the formats."""
    settings = options.chosen_settings(ctx, Settings, save_settings)
    if robot is not None:
        film_it = "; `limner simulate --film` films an arm" if by_plotter.film else ""
        refuse(by_plotter, _PLOTTER, f"is for plotters; leave it out with --robot{film_it}")
        arm.plan(by_arm, robot, settings)
    else:
        refuse(by_arm, _ARM, "is for arms; name one with --robot")
        plotter.plan(by_plotter, settings)
