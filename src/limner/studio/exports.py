"""A drawing, its settings and a format go in; the bytes of the file that is saved come out."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable
from typing import Any

from limner import __version__, storage
from limner.errors import BadInput
from limner.motion.arm.robots import ROBOTS
from limner.motion.machine import MACHINES, load_machine
from limner.motion.pen import plan
from limner.pipeline import Settings
from limner.settings import write_toml
from limner.studio.plans import known, trajectory
from limner.targets import files, joints, movie, svg
from limner.types import Drawing

FILM_S = 10.0
"""Length of a film."""

MOTIONS = tuple(f"trajectory{suffix}" for suffix in joints.FORMATS)
"""The motion of an arm that draws it."""

FILMS: dict[str, Callable[..., bytes]] = {"gif": movie.to_gif, "mp4": movie.to_mp4}
"""The drawing being drawn."""

FORMATS = (*(suffix.removeprefix(".") for suffix in files.FORMATS), "toml", *FILMS, *MOTIONS)
"""What a drawing can be saved as."""


def exported(drawing: Drawing, kind: str, settings: Settings, machine: str | None, robot: str | None) -> bytes:
    """The file.

    Args:
        drawing: what to save.
        kind: one of ``FORMATS``.
        settings: that made it.
        machine: for G-code and films; None: the settings' own.
        robot: for the motion of an arm.

    Raises:
        BadInput: no such format, machine or robot.
        CannotDraw: the robot cannot draw it.
    """
    known(kind, FORMATS, "format")
    if kind in MOTIONS:
        if not robot:
            raise BadInput(f"{kind}: which robot draws? add ?robot=NAME, one of {', '.join(ROBOTS)}")
        return _motion(drawing, kind, settings, robot)
    if kind == "toml":
        return write_toml(settings).encode()
    about: dict[str, Any] = {"limner": __version__, "settings": settings.to_dict()}
    if kind == "svg":
        return svg.to_svg(drawing, about, how=settings.svg)
    mover = load_machine(known(machine or settings.machine, MACHINES, "machine"))
    if kind in FILMS:
        return FILMS[kind](drawing, plan(drawing, mover), FILM_S)
    return files.to_bytes(drawing, f".{kind}", about, settings.gcode)


def _motion(drawing: Drawing, kind: str, settings: Settings, robot: str) -> bytes:
    motion = trajectory(drawing, robot, settings)
    with tempfile.TemporaryDirectory(prefix="limner-") as folder:
        path = os.path.join(folder, kind)
        joints.save(motion, path)
        return storage.read_bytes(path)
