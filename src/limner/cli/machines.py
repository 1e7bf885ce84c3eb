"""What ``plan`` and ``send`` share: the drawing from its file, and the machine that is to draw it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import click

from limner.motion.area import check_area, fit
from limner.motion.machine import MACHINES, Machine
from limner.targets.files import READABLE, read_drawing
from limner.targets.gcode import GcodeSettings
from limner.types import Drawing

drawing_argument: Callable[[Any], Any] = click.argument("drawing", metavar="DRAWING")

machine_option: Callable[[Any], Any] = click.option(
    "--machine",
    "-m",
    metavar="NAME",
    help=f"The machine that draws: {', '.join(MACHINES)}, or a TOML file of your own. Default: axidraw.",
)

fit_option: Callable[[Any], Any] = click.option(
    "--fit", "shrink", is_flag=True, help="Shrink a drawing that is too large to the machine's work area."
)

READS = f"DRAWING is one of {', '.join(READABLE)}; any SVG's outlines will do."
"""For the help of commands."""


def gcode_for(settings: GcodeSettings, machine: Machine) -> GcodeSettings:
    """G-code at the machine's own speed and pen times, unless the settings say others than their defaults."""
    usual, own = GcodeSettings(), {}
    if settings.draw_mm_min == usual.draw_mm_min:
        own["draw_mm_min"] = machine.draw_mm_s * 60
    if settings.servo_s == usual.servo_s:
        own["servo_s"] = min(max(machine.pen_down_s, machine.pen_up_s), 10.0)
    return settings.replace(**own)


def placed(path: str, machine: Machine, shrink: bool) -> Drawing:
    """The drawing of a file, within the machine's work area.

    Raises:
        BadInput: the file cannot be read.
        NothingToDraw: it holds no strokes.
        CannotDraw: it is too large, and must not be shrunk.
    """
    drawing = read_drawing(path)
    if shrink:
        drawing = fit(drawing, machine)
    check_area(drawing, machine)
    return drawing
