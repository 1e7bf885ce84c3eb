"""A drawing, a machine and a journal go in; the machine draws it, and can be stopped and gone on with at any stroke."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection
from dataclasses import dataclass

import numpy as np

from limner import geometry
from limner.errors import DeviceFailed
from limner.targets.journal import Journal, Place, runs_from
from limner.targets.target import Device, NotConnected, Target
from limner.types import Drawing

LOOK_S = 0.05
"""How often a paused drawing looks whether it goes on."""


@dataclass
class Control:
    """What the user wants, set from another thread or a signal at any time.

    Attributes:
        stop: raise the pen as soon as the machine can, go home and end.
        pause: raise the pen as soon as the machine can, and wait until this is false again.
    """

    stop: bool = False
    pause: bool = False

    def going_on(self) -> bool:
        """Whether to draw on."""
        return not (self.stop or self.pause)


Watch = Callable[[Place, bool], None]
"""Told where the pen goes on, and whether it waits there."""


def send(drawing: Drawing, target: Target, journal: Journal, control: Control, watch: Watch) -> Place:
    """Draw the lines of a drawing from the journal's place on, as ``drive`` does; it pauses where the pen is changed.

    Args:
        drawing: to draw; already checked against the machine's area.
        target: what draws, not yet open; closed in the end.
        journal: of this drawing.
        control: looked at before every line, and within lines where the machine can stop there.
        watch: told before every line.
    """
    lines = [geometry.without_repeats(line) for line in drawing.lines_mm]
    changes = frozenset(np.flatnonzero(drawing.changes()).tolist())

    def draw(place: Place) -> Place:
        line, places = runs_from(lines, place, changes)
        return places[target.draw(line, control.going_on)]

    return drive(target, draw, len(lines), journal, control, watch, changes)


def drive(
    device: Device,
    draw: Callable[[Place], Place],
    strokes: int,
    journal: Journal,
    control: Control,
    watch: Watch,
    changes: Collection[int] = (),
    resume: str = "--resume",
) -> Place:
    """Draw from the journal's place on.

    The journal says what is begun before the pen is lowered, and what is drawn once the machine has done it. So after a
    stop nothing is drawn twice and nothing is lost; after a failure only the line that was being drawn is in doubt, and
    is drawn again.

    Args:
        device: that draws, not yet open; closed in the end.
        draw: has it draw from a place on, and tells where it has come to, the pen up.
        strokes: how many there are.
        journal: of this drawing.
        control: looked at before every line.
        watch: told before every line.
        changes: strokes before which it pauses, since another pen must be put in.
        resume: what the user asks for to go on, as messages say.

    Returns:
        Where to go on: beyond the last stroke when the drawing is finished, else where it was stopped, the pen up.

    Raises:
        DeviceFailed: with the state of the pen, and where it was.
        KeyboardInterrupt: interrupted at once; the pen was raised if that was possible.
    """
    waits = {Place(stroke) for stroke in changes}
    try:
        device.open()
        while journal.place.stroke < strokes and not control.stop:
            if journal.place in waits:
                waits.remove(journal.place)
                control.pause = True
            watch(journal.place, control.pause)
            if control.pause:
                time.sleep(LOOK_S)
                continue
            journal.begin(journal.place)
            journal.reached(draw(journal.place))
        device.home()
    except NotConnected:
        raise
    except DeviceFailed as error:
        raise DeviceFailed(f"{error}; {_after(device, journal, strokes, resume)}") from error
    except BaseException:  # whatever ends it, Ctrl-C too, the pen goes up
        device.abort()
        raise
    finally:
        device.close()
    return journal.place


def _after(device: Device, journal: Journal, strokes: int, resume: str) -> str:
    pen = "the pen is up" if device.abort() else "pen state unknown: lift it by hand"
    if not journal.doubtful:
        return f"{pen}; {journal.place.stroke} of {strokes} strokes are drawn, {resume} goes on there"
    return f"{pen}; it happened in stroke {journal.place.stroke + 1} of {strokes}, {resume} draws that one again"
