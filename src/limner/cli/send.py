"""``limner send``: a drawing in, a machine draws it; it pauses, stops with the pen up, and goes on where it stopped."""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass
from pathlib import Path

import click

from limner.cli import jobs, machines, options
from limner.cli.gathered import gathered, refuse
from limner.cli.jobs import Job
from limner.cli.keys import interrupts, pause_key
from limner.cli.progress import Watch, bars
from limner.cli.words import clock, many
from limner.errors import BadInput
from limner.motion.arm.robots import ROBOTS
from limner.pipeline import Settings
from limner.targets.journal import Journal, Place, unfinished
from limner.targets.send import Control

_PLOTTER = {"--machine": "machine", "--fit": "shrink"}


@dataclass(frozen=True)
class SendWish:
    """What is drawn by which machine, from where on.

    Attributes:
        drawing: file of the drawing, or of an arm's motion.
        to: address of the machine.
        robot: the arm, or None for a plotter.
        machine: name or file of the plotter's profile; None: that of its board.
        shrink: whether a drawing that is too large is shrunk to the work area.
        yes: whether nobody is asked.
        resume: whether the journal says where it goes on.
        first: stroke to begin with, from 1, or None.
        journal_file: None: beside the drawing.
        baud: of the port.
        as_json: whether the report is printed as JSON.
    """

    drawing: str
    to: str
    robot: str | None
    machine: str | None
    shrink: bool
    yes: bool
    resume: bool
    first: int | None
    journal_file: str | None
    baud: int
    as_json: bool

    @property
    def journal(self) -> str:
        """The journal's file."""
        return self.journal_file or f"{self.drawing}.journal"


@click.command(
    short_help="Draw on a plotter or with an arm.",
    help=f"""Draw DRAWING on a plotter, or with --robot what `limner plan --robot` has written with an arm.

    It asks before anything moves. Space pauses with the pen up and goes on; Ctrl-C stops with the pen up, a second one
    at once. It pauses where a drawing wants its next pen. What is drawn stands in a journal beside the drawing, from
    which --resume goes on.

    {machines.READS}""",
)
@machines.drawing_argument
@click.option(
    "--to",
    required=True,
    metavar="ADDRESS",
    help="grbl:PORT or ebb:PORT (an AxiDraw), ur:HOST (an arm of Universal Robots), rosbridge:ws://HOST:PORT/TOPIC (the"
    " controller of an arm in ROS); to try: sim: (simulated, at its own pace; sim:20 twenty times as fast), fake: or"
    " fake:ebb.",
)
@click.option(
    "--robot",
    metavar="NAME",
    help=f"The arm that DRAWING is a motion for (.json, .npz, .csv): {', '.join(ROBOTS)}, or a URDF of your own.",
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
@gathered(SendWish)
def send(ctx: click.Context, wish: SendWish, save_settings: Path | None) -> None:
    """See ``help`` above."""
    job = _job(wish, options.chosen_settings(ctx, Settings, save_settings))
    if job.drawing.changes().any() and not sys.stdin.isatty():
        raise BadInput(f"{wish.drawing}: has several pens, and nobody is there to change them; send it from a terminal")
    place = jobs.first_place(job, wish.resume, wish.first)
    left = None if wish.resume else unfinished(wish.journal, job.drawing)
    if not wish.yes:
        _ask(wish.drawing, wish.to, job, left)
    journal = Journal(wish.journal, job.drawing, resume=wish.resume)
    if place is not None:
        journal.reached(place)
    began = journal.place
    try:
        ended = _send(job, journal, quiet=wish.as_json)
    finally:
        journal.close()
    _tell(job, began, ended, wish)
    if ended.stroke < len(job.begins_s):
        ctx.exit(130)


def _job(wish: SendWish, settings: Settings) -> Job:
    if wish.robot is not None:
        refuse(wish, _PLOTTER, "is for plotters; leave it out with --robot")
        return jobs.arm(wish.drawing, wish.to, wish.robot, settings)
    return jobs.plotter(wish.drawing, wish.to, wish.machine, wish.shrink, wish.baud, settings)


def _ask(name: str, to: str, job: Job, left: Place | None) -> None:
    """Ask whether to begin.

    Raises:
        BadInput: there is nobody to ask.
        Abort: the answer is no.
    """
    if not sys.stdin.isatty():
        raise BadInput("it asks before the machine moves, and nobody is there to answer; add --yes")
    count = len(job.begins_s)
    click.echo(f"{name}: {many(count, 'stroke')}, {clock(job.seconds)} on {job.name} at {to}", err=True)
    if left is not None and 0 < left.stroke < count:
        click.echo(f"{left.stroke} of them were drawn before; --resume goes on there, this begins anew", err=True)
    click.confirm(f"{job.ready} Begin?", abort=True, err=True)


def _send(job: Job, journal: Journal, *, quiet: bool) -> Place:
    control = Control()
    with bars(clocks=False) as watch:
        shown = _Shown(watch, job, quiet=quiet)
        with interrupts(control, shown.say), pause_key(control, shown.say):
            return job.run(journal, control, shown.place)


class _Shown:
    """Tells the planned time that is left, by stroke, and what the user's keys do."""

    def __init__(self, watch: Watch, job: Job, *, quiet: bool) -> None:
        self._watch, self._quiet = watch, quiet
        self._begins, self._total = job.begins_s, job.seconds
        self._changes = job.drawing.changes()
        self._drawing = job.drawing
        self._at = 0

    def place(self, place: Place, waits: bool) -> None:
        """Where the pen goes on, and whether it waits there."""
        self._at = place.stroke
        change = f": now the pen {self._pen(place)}" if place.vertex == 0 and self._changes[place.stroke] else ""
        self._show(
            f"paused with the pen up{change}; space goes on" if waits else f"{clock(self._total - self._done)} left"
        )

    def say(self, text: str) -> None:
        """What happens next."""
        if sys.stderr.isatty():
            self._show(text)
        elif not self._quiet:
            click.echo(text, err=True)

    def _pen(self, place: Place) -> str:
        pen = self._drawing.pens[int(self._drawing.layer[place.stroke])]
        return f"{pen.name} ({pen.hex})"

    @property
    def _done(self) -> float:
        return float(self._begins[self._at])

    def _show(self, text: str) -> None:
        stroke = f"stroke {self._at + 1} of {len(self._begins)}"
        self._watch("drawing", round(self._done), round(self._total), f"{stroke}, {text}")


def _tell(job: Job, began: Place, ended: Place, wish: SendWish) -> None:
    count = len(job.begins_s)
    finished = ended.stroke == count
    if wish.as_json:
        report = {"strokes": count, "began": began.stroke, "drawn": ended.stroke, "finished": finished}
        click.echo(json.dumps(report | {"journal": None if finished else wish.journal}))
    elif finished:
        click.echo(f"drawn: {many(count, 'stroke')}", err=True)
    else:
        click.echo(f"stopped with the pen up: {ended.stroke} of {count} drawn; --resume goes on", err=True)
