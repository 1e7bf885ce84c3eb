"""``limner ros``: arguments of ROS in; a node, a simulated controller or all of a demonstration runs until it ends."""

from __future__ import annotations

import click

from limner.cli.groups import Group

_ARGUMENTS = {"ignore_unknown_options": True}


@click.group(cls=Group, short_help="Draw with an arm through ROS 1.")
def ros() -> None:
    """Draw with an arm through ROS 1: docs/ros.md has all topics, services and parameters."""


@ros.command(short_help="The node that draws: images in, portraits and motions out.", context_settings=_ARGUMENTS)
@click.argument("arguments", metavar="[NAME:=VALUE]...", nargs=-1, type=click.UNPROCESSED)
def node(arguments: tuple[str, ...]) -> None:
    """The node that draws: images in, portraits and motions out, services to start, pause, resume and stop.

    NAME:=VALUE is as ROS takes it: image:=/camera/image_raw, _style:=gabor, _page:=a4, _robot:=ur5e, _target:=command.
    """
    from limner.ros import node as nodes

    nodes.run(list(arguments))


@ros.command(short_help="A simulated arm behind a FollowJointTrajectory action.", context_settings=_ARGUMENTS)
@click.argument("arguments", metavar="[NAME:=VALUE]...", nargs=-1, type=click.UNPROCESSED)
def controller(arguments: tuple[str, ...]) -> None:
    """A simulated arm behind a FollowJointTrajectory action, with joint states and feedback at 50 Hz.

    It refuses goals as a real one does: over a limit, or not from where the arm is. NAME:=VALUE is as ROS takes it:
    _robot:=ur5e, _start:=home, _speed:=4.
    """
    from limner.ros import controller as controllers

    controllers.run(list(arguments))


@ros.command(short_help="All of it, without hardware, and rviz.", context_settings=_ARGUMENTS)
@click.argument("source", metavar="PHOTO|DRAWING")
@click.argument("arguments", metavar="[NAME:=VALUE]...", nargs=-1, type=click.UNPROCESSED)
@click.option("--robot", default="dumbo", metavar="NAME", help="The arm, or a URDF of your own. Default: dumbo.")
@click.option("--rviz/--no-rviz", default=True, help="Show it in rviz. Default: do.")
@click.option("--once", is_flag=True, help="End when the drawing is drawn.")
@click.option(
    "--speed", type=click.FloatRange(0.1, 20), default=1.0, metavar="X", help="Of the arm's time. Default: 1."
)
def demo(source: str, arguments: tuple[str, ...], robot: str, rviz: bool, once: bool, speed: float) -> None:
    """All of it, without hardware: a master if none answers, a simulated arm, the node and rviz; Ctrl-C ends them.

    The arm draws as soon as the drawing is planned. NAME:=VALUE goes to the node: _style:=gabor, _points:=300.
    """
    from limner.ros import demo as demonstration

    show = demonstration.Show(source, robot, rviz, once, speed, arguments)
    demonstration.run(show, lambda text: click.echo(text, err=True))
