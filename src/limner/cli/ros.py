"""``limner ros``: arguments of ROS in; a node, a simulated controller or all of a demonstration runs until it ends."""

from __future__ import annotations

import click

_ARGUMENTS = {"ignore_unknown_options": True}


@click.group(short_help="Draw with an arm through ROS 1.")
def ros() -> None:
    """Draw with an arm through ROS 1: docs/ros.md has all topics, services and parameters."""


@ros.command(context_settings=_ARGUMENTS)
@click.argument("arguments", metavar="[NAME:=VALUE]...", nargs=-1, type=click.UNPROCESSED)
def node(arguments: tuple[str, ...]) -> None:
    """The node that draws: images in, portraits and motions out, services to start, pause, resume and stop.

    NAME:=VALUE is as ROS takes it: image:=/camera/image_raw, _style:=gabor, _page:=a4, _robot:=ur5e, _target:=command.
    """
    from limner.ros import node as nodes

    nodes.run(list(arguments))


@ros.command(context_settings=_ARGUMENTS)
@click.argument("arguments", metavar="[NAME:=VALUE]...", nargs=-1, type=click.UNPROCESSED)
def controller(arguments: tuple[str, ...]) -> None:
    """A simulated arm behind a FollowJointTrajectory action, with joint states and feedback at 50 Hz.

    It refuses goals as a real one does: over a limit, or not from where the arm is. NAME:=VALUE is as ROS takes it:
    _robot:=ur5e, _start:=home, _speed:=4.
    """
    from limner.ros import controller as controllers

    controllers.run(list(arguments))
