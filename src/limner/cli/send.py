"""``limner send``: a drawing in, a plotter draws it; it pauses, stops with the pen up, and goes on where it stopped."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path

import click
import numpy as np

from limner.cli import machines, options
from limner.cli.keys import interrupts, pause_key
from limner.cli.plan import clock, many
from limner.cli.progress import Watch, bars
from limner.errors import BadInput
from limner.motion.cost import seconds, stroke_begins
from limner.motion.machine import Machine, load_machine
from limner.motion.pen import plan
from limner.pipeline import Settings
from limner.targets.connect import Wiring, connect, parse_address
from limner.targets.ebb import Limits
from limner.targets.journal import Journal, Place, unfinished
from limner.targets.send import Control, send as send_drawing
from limner.targets.target import Target
from limner.types import Drawing, Floats, PenPath

MACHINE_OF = {"grbl": "grbl", "ebb": "axidraw"}
"""The profile of a board, unless --machine says another."""


@click.command(
    short_help="Draw on a plotter.",
    help=f"""Draw DRAWING on a plotter.

    It asks before anything moves. Space pauses with the pen up and goes on; Ctrl-C stops with the pen up, a second
    one at once. What is drawn stands in a journal beside the drawing, from which --resume goes on.

    {machines.READS}""",
)
@machines.drawing_argument
@click.option(
    "--to",
    required=True,
    metavar="ADDRESS",
    help="grbl:PORT or ebb:PORT (an AxiDraw); fake: or fake:ebb to try.",
)
@machines.machine_option
@machines.fit_option
@click.option("--yes", "-y", is_flag=True, help="Do not ask before moving.")
@click.option("--resume", is_flag=True, help="Go on where the journal ends.")
@click.option("--from", "first", type=click.IntRange(1), metavar="N", help="Begin with the N-th stroke.")
@click.option("--journal", "journal_file", metavar="FILE", help="Where the journal is. Default: DRAWING.journal.")
@click.option("--baud", type=click.IntRange(300), default=115_200, metavar="N", help="Of the port. Default: 115200.")
@options.settings_options
@options.json_option
@click.pass_context
def send(
    ctx: click.Context,
    drawing: str,
    to: str,
    machine: str | None,
    shrink: bool,
    yes: bool,
    resume: bool,
    first: int | None,
    journal_file: str | None,
    baud: int,
    save_settings: Path | None,
    as_json: bool,
) -> None:
    """See ``help`` above."""
    settings = options.chosen_settings(ctx, Settings, save_settings)
    address = parse_address(to)
    mover = load_machine(machine or MACHINE_OF[address.kind])
    placed = machines.placed(drawing, mover, shrink)
    place = _first_place(placed, resume, first)
    file = journal_file or f"{drawing}.journal"
    left = None if resume else unfinished(file, placed)
    if not yes:
        _ask(drawing, to, mover, placed, left)
    journal = Journal(file, placed, resume=resume)
    if place is not None:
        journal.reached(place)
    began = journal.place
    try:
        target = partial(connect, address, _wiring(placed, mover, settings, baud))
        ended = _send(placed, target, journal, mover, quiet=as_json)
    finally:
        journal.close()
    _tell(placed, began, ended, file, as_json)
    if ended.stroke < len(placed.lines_mm):
        ctx.exit(130)


def _first_place(drawing: Drawing, resume: bool, first: int | None) -> Place | None:
    if first is None:
        return None
    if resume:
        raise BadInput("--resume and --from say two places to begin; choose one")
    if first > len(drawing.lines_mm):
        raise BadInput(f"--from {first}: the drawing has {len(drawing.lines_mm)} strokes; choose one of them")
    return Place(first - 1)


def _wiring(drawing: Drawing, machine: Machine, settings: Settings, baud: int) -> Wiring:
    def motion(start_mm: Floats, line_mm: Floats) -> PenPath:
        return plan(Drawing((line_mm,), ("face",), np.ones(1), drawing.page, drawing.pen), machine, start_mm, None)

    x, y = machine.home_mm(drawing.page).tolist()
    limits = Limits(max(machine.draw_mm_s, machine.travel_mm_s), machine.draw_mm_s**2 / (2 * machine.draw_mm_s2))
    return Wiring((x, y), motion, limits, machines.gcode_for(settings.gcode, machine), settings.ebb, baud)


def _ask(name: str, to: str, machine: Machine, drawing: Drawing, left: Place | None) -> None:
    """Ask whether to begin.

    Raises:
        BadInput: there is nobody to ask.
        Abort: the answer is no.
    """
    if not sys.stdin.isatty():
        raise BadInput("it asks before the machine moves, and nobody is there to answer; add --yes")
    count = len(drawing.lines_mm)
    click.echo(
        f"{name}: {many(count, 'stroke')}, {clock(seconds(drawing, machine))} on {machine.name} at {to}", err=True
    )
    if left is not None and 0 < left.stroke < count:
        click.echo(f"{left.stroke} of them were drawn before; --resume goes on there, this begins anew", err=True)
    corner = machine.home.replace("-", " ")
    click.confirm(
        f"The pen stands raised over the page's {corner} corner, the paper lies. Begin?", abort=True, err=True
    )


def _send(drawing: Drawing, target: Callable[[], Target], journal: Journal, machine: Machine, *, quiet: bool) -> Place:
    control = Control()
    with bars(clocks=False) as watch:
        shown = _Shown(watch, drawing, machine, quiet=quiet)
        with interrupts(control, shown.say), pause_key(control, shown.say):
            return send_drawing(drawing, target(), journal, control, shown.place)


class _Shown:
    """Tells the planned time that is left, by stroke, and what the user's keys do."""

    def __init__(self, watch: Watch, drawing: Drawing, machine: Machine, *, quiet: bool) -> None:
        self._watch, self._quiet = watch, quiet
        self._begins, self._total = stroke_begins(drawing, machine), seconds(drawing, machine)
        self._at = 0

    def place(self, place: Place, waits: bool) -> None:
        """Where the pen goes on, and whether it waits there."""
        self._at = place.stroke
        self._show("paused with the pen up; space goes on" if waits else f"{clock(self._total - self._done)} left")

    def say(self, text: str) -> None:
        """What happens next."""
        if sys.stderr.isatty():
            self._show(text)
        elif not self._quiet:
            click.echo(text, err=True)

    @property
    def _done(self) -> float:
        return float(self._begins[self._at])

    def _show(self, text: str) -> None:
        stroke = f"stroke {self._at + 1} of {len(self._begins)}"
        self._watch("drawing", round(self._done), round(self._total), f"{stroke}, {text}")


def _tell(drawing: Drawing, began: Place, ended: Place, journal: str, as_json: bool) -> None:
    count = len(drawing.lines_mm)
    finished = ended.stroke == count
    if as_json:
        report = {"strokes": count, "began": began.stroke, "drawn": ended.stroke, "finished": finished}
        click.echo(json.dumps(report | {"journal": None if finished else journal}))
    elif finished:
        click.echo(f"drawn: {many(count, 'stroke')}", err=True)
    else:
        click.echo(f"stopped with the pen up: {ended.stroke} of {count} drawn; --resume goes on", err=True)
