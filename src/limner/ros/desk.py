"""Photos, strokes and wishes go in, from any thread; drawings, checked plans and progress come out, or a refusal."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np

from limner.errors import BadInput, CannotDraw, LimnerError
from limner.motion.arm.legs import Legs, legs
from limner.motion.arm.plan import ArmPlan, plan_arm
from limner.motion.arm.robot import Robot
from limner.pipeline import Portrait, Settings, draw
from limner.ros.arm import RosArm
from limner.ros.sheet import Sheet
from limner.targets.journal import Journal, Place
from limner.targets.send import Control, drive
from limner.types import Drawing, Floats, Page, Pen, Photo

STOP_S = 20.0
"""How long a stop may take until the pen is up."""


class Listener(Protocol):
    """Who is told what happens on the desk."""

    def drawn(self, drawing: Drawing, portrait: Portrait | None) -> None:
        """There is a new drawing, of a photo or given."""

    def planned(self, plan: ArmPlan) -> None:
        """There is a new plan."""

    def begun(self) -> None:
        """A sheet is begun."""

    def progress(self, share: float) -> None:
        """So much of the drawing's time is done."""

    def status(self, text: str) -> None:
        """What goes on."""


@dataclass(frozen=True, eq=False)
class _Planned:
    """A plan, cut into strokes.

    Attributes:
        drawing: that is planned.
        plan: for the arm.
        route: its strokes.
    """

    drawing: Drawing
    plan: ArmPlan
    route: Legs

    def share(self, place: Place) -> float:
        """How much of the time is over where the pen has come to a place."""
        t_s, cuts = self.plan.trajectory.t_s, self.route.cuts
        return float(t_s[cuts[place.stroke]] / t_s[cuts[-1]])


class Desk:
    """One drawing after the other, each with its plan; one arm that draws it.

    Every wish is granted at once or refused with a reason. The sheet stays where it was found to lie until its size or
    the robot changes, or it is probed anew.
    """

    def __init__(self, arm: Callable[[Legs], RosArm], journal: Path, listener: Listener) -> None:
        self._arm, self._journal, self._listener = arm, journal, listener
        self._lock = threading.RLock()
        self._photo: Photo | None = None
        self._drawing: Drawing | None = None
        self._strokes: list[Floats] = []
        self._planned: _Planned | None = None
        self._sheet = Sheet()
        self._control = Control()
        self._thread: threading.Thread | None = None
        self._busy = False
        self._place, self._ended, self._unfinished = Place(0), "", False

    @property
    def busy(self) -> bool:
        """Whether the arm draws, or waits with the pen up to go on."""
        return self._busy

    def see(self, photo: Photo) -> None:
        """Keep a photo, to be drawn when asked for."""
        self._photo = photo

    def sketch(self, settings: Settings) -> str:
        """Draw the last photo.

        Raises:
            LimnerError: there is none, the arm draws, or no portrait can be made.
        """
        with self._lock:
            self._refuse_busy("sketch")
            if self._photo is None:
                raise BadInput("sketch: there is no photo yet; publish one on image, or set the parameter ~photo")
            portrait = draw(self._photo, settings)
            self._take(portrait.drawing, portrait)
            return f"{len(portrait.drawing.lines_mm)} strokes, {portrait.drawing.points} points"

    def take(self, drawing: Drawing) -> None:
        """Take a drawing as it is.

        Raises:
            BadInput: the arm draws.
        """
        with self._lock:
            self._refuse_busy("drawing")
            self._take(drawing, None)

    def add_stroke(self, line_mm: Floats, page: Page, pen: Pen) -> None:
        """A stroke more (n, 2) [mm]; the first after a plan begins a new drawing, one without points clears it.

        Raises:
            BadInput: the arm draws.
        """
        with self._lock:
            self._refuse_busy("drawing")
            self._strokes = [*self._strokes, line_mm] if len(line_mm) else []
            lines = tuple(self._strokes)
            self._drawing, self._planned = None, None
            if lines:
                drawing = Drawing(lines, ("face",) * len(lines), np.ones(len(lines)), page, (pen,))
                self._drawing = drawing
                self._listener.drawn(drawing, None)
            self._listener.status(f"drawing: {len(lines)} strokes")

    def plan(self, settings: Settings, robot: Robot) -> str:
        """Plan how the arm draws what was drawn last.

        Raises:
            LimnerError: there is no drawing, the arm draws, or it cannot draw this.
        """
        with self._lock:
            self._refuse_busy("plan")
            if self._drawing is None:
                raise BadInput("plan: there is no drawing yet; publish an image or strokes first")
            wanted = (robot.name, self._drawing.page, settings.arm.place)
            lies = self._sheet.lies(wanted)
            planned = plan_arm(self._drawing, robot, settings.arm, lies)
            route = legs(planned.trajectory, robot, settings.arm.retime, settings.arm.allowed)
            self._planned = _Planned(self._drawing, planned, route)
            if lies is None:
                self._sheet.found(planned.placement, wanted)
            self._strokes, self._place, self._unfinished = [], Place(0), False
            self._listener.planned(planned)
            told = f"{len(route.ends)} strokes, {planned.trajectory.t_s[-1]:.0f} s"
            self._listener.status(f"planned: {told}")
            return told

    def warm(self, settings: Settings, robot: Robot) -> None:
        """Find where a sheet can lie, and load what a plan needs, before anything has to be quick."""
        page = settings.page.page()
        low, (right, top) = page.margin_mm, np.array([page.width_mm, page.height_mm]) - page.margin_mm
        around = np.array([[low, low], [right, low], [right, top], [low, top], [low, low]])
        with self._lock:
            plan = plan_arm(Drawing((around,), ("face",), np.ones(1), page), robot, settings.arm)
            self._sheet.found(plan.placement, (robot.name, page, settings.arm.place))

    def probe(self, point_m: Floats) -> str:
        """A point (3,) of the sheet in the robot's base frame; from three on they tell where the sheet lies.

        Raises:
            BadInput: the arm draws, the point is not finite, or the points are no sheet.
        """
        with self._lock:
            self._refuse_busy("calibrate_point")
            told, known = self._sheet.probe(point_m)
            if known:
                self._planned = None
            return told

    def forget_points(self) -> str:
        """Probe anew: the next point is the sheet's lower left corner."""
        with self._lock:
            self._refuse_busy("calibrate_clear")
            return f"forgot {self._sheet.forget()} points"

    def start(self) -> str:
        """Begin to draw what is planned.

        Raises:
            BadInput: nothing is planned, or the arm draws already.
        """
        with self._lock:
            self._refuse_busy("start")
            planned = self._ready("start")
            self._listener.begun()
            self._run(planned, resume=False)
            return f"drawing {len(planned.route.ends)} strokes"

    def pause(self) -> str:
        """Draw the stroke to its end, raise the pen and wait.

        Raises:
            BadInput: the arm does not draw.
        """
        with self._lock:
            if not self.busy:
                raise BadInput("pause: the arm does not draw")
            self._control.pause = True
            return "pausing with the pen up after this stroke"

    def resume(self) -> str:
        """Go on, after a pause, a stop or a failure.

        Raises:
            BadInput: there is nothing to go on with.
        """
        with self._lock:
            if self.busy:
                if not self._control.pause:
                    raise BadInput("resume: the arm draws already")
                self._control.pause = False
                return "going on"
            planned = self._ready("resume")
            left = self._journal.exists()
            if not (left or self._unfinished):
                raise BadInput("resume: nothing was left unfinished; call ~start")
            self._run(planned, resume=left)
            return f"going on with stroke {self._place.stroke + 1} of {len(planned.route.ends)}"

    def stop(self) -> str:
        """Stop where the arm is, at once, and raise the pen; comes back when that is done.

        Raises:
            BadInput: the arm does not draw.
            CannotDraw: it has not come to rest in time.
        """
        with self._lock:
            if not self.busy:
                raise BadInput("stop: the arm does not draw")
            thread = self._thread
            self._control.stop = True
        assert thread is not None
        thread.join(STOP_S)
        if thread.is_alive():
            raise CannotDraw(f"stop: the arm has not come to rest in {STOP_S:.0f} s; use its emergency stop")
        return self._ended

    def _take(self, drawing: Drawing, portrait: Portrait | None) -> None:
        self._drawing, self._strokes, self._planned = drawing, [], None
        self._listener.drawn(drawing, portrait)
        self._listener.status(f"drawn: {len(drawing.lines_mm)} strokes")

    def _refuse_busy(self, what: str) -> None:
        if self.busy:
            raise BadInput(f"{what}: the arm is drawing; stop it first")

    def _ready(self, what: str) -> _Planned:
        if self._planned is None:
            raise BadInput(f"{what}: nothing is planned; call ~plan first")
        return self._planned

    def _run(self, planned: _Planned, *, resume: bool) -> None:
        journal = Journal(self._journal, planned.drawing, resume=resume)
        self._place, self._control, self._ended = journal.place, Control(), "ended by a bug; see the node's log"
        self._unfinished = self._busy = True
        self._thread = threading.Thread(target=self._draw, args=(planned, journal, self._control), daemon=True)
        self._thread.start()

    def _draw(self, planned: _Planned, journal: Journal, control: Control) -> None:
        count = len(planned.route.ends)
        arm = self._arm(planned.route)

        def stroke(place: Place) -> Place:
            return Place(place.stroke + arm.draw(place.stroke, lambda: control.stop))

        def watch(place: Place, waits: bool) -> None:
            self._place = place
            self._tell(planned, place, "paused with the pen up before" if waits else "drawing")

        try:
            changes = np.flatnonzero(planned.drawing.changes()).tolist()
            self._place = drive(arm, stroke, count, journal, control, watch, changes, "~resume")
            self._unfinished = self._place.stroke < count
            what = "stopped with the pen up" if self._unfinished else "drawn"
            self._ended = f"{what}: {self._place.stroke} of {count} strokes"
            self._listener.progress(planned.share(self._place))
        except LimnerError as error:
            self._place, self._ended = journal.place, str(error)
        finally:
            journal.close()
            # Who hears that it has ended can begin anew at once.
            with self._lock:
                try:
                    self._listener.status(self._ended)
                finally:
                    self._busy = False

    def _tell(self, planned: _Planned, place: Place, what: str) -> None:
        self._listener.status(f"{what} stroke {place.stroke + 1} of {len(planned.route.ends)}")
        self._listener.progress(planned.share(place))
