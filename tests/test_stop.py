"""Stop works from every state of every machine, and after a fault the pen is up or nobody says that it is."""

import functools

import numpy as np
import pytest

import arms
from drawings import of
from limner.errors import DeviceFailed
from limner.simulation.device import SimulatedArm
from limner.simulation.settings import SimulationSettings
from limner.studio.jobs import BUSY, COMMANDS
from limner.targets.bridge import BridgeAddress
from limner.targets.fake import Fault
from limner.targets.fake_rosbridge import FakeRosbridge
from limner.targets.journal import Journal, Place
from limner.targets.rosbridge import Rosbridge, RosbridgeSettings
from limner.targets.send import Control, drive, send
from limner.types import Drawing, Pen
from plotters import ebb, grbl, settled

LINES = of([[10, 190], [12, 190], [13, 189]], [[15, 190]], [[16, 190], [17, 191]], [[20, 190], [22, 190]])
TWO_PENS = Drawing(LINES.lines_mm, LINES.region, LINES.weight, LINES.page, (Pen(), Pen(name="red")), [0, 0, 1, 1])
LONG = of([[10 + k, 190 + k % 2] for k in range(80)])
PACE = 50.0
PLOTTERS = {"grbl servo": grbl, "grbl z": functools.partial(grbl, "z"), "ebb": ebb}


class Asked(Control):
    """Stops, or pauses, when it is asked for the n-th time whether to go on."""

    def __init__(self, after, pause=False):
        super().__init__()
        self.left, self.first = after, pause

    def going_on(self):
        self.left -= 1
        if self.left < 0:
            # A pause that is asked for, and a stop before it has come.
            self.pause, self.stop = self.first, True
        return super().going_on()


def stopped(control, waited):
    """Stop a machine that waits; it must not go on waiting."""
    control.stop = True
    waited.append(control)
    assert len(waited) < 50, "told to stop it waits on"


def stop_at_pause(control, paused_at=None):
    """Watch that asks for a pause before a stroke, and stops the machine once it waits."""
    waited = []

    def watch(place, waits):
        if waits:
            stopped(control, waited)
        elif paused_at is not None and place.stroke == paused_at:
            control.pause = True

    return watch


def quiet(place, waits):
    """Watch and do nothing."""


def states():
    """A state by name: the control, the watch, and the drawing to be in it with."""
    found = {
        "idle": (Control(stop=True), quiet, LINES),
        "running": (Asked(1), quiet, LINES),
        "pen down": (Asked(0), quiet, LINES),
        "pausing": (Asked(1, pause=True), quiet, LINES),
    }
    paused, changed = Control(), Control()
    found["paused"] = paused, stop_at_pause(paused, 2), LINES
    found["in a pen change"] = changed, stop_at_pause(changed), TWO_PENS
    travel = Control()
    # Told to stop before a stroke, it still goes there or not: what counts is that it ends with the pen up.
    found["in travel"] = travel, lambda place, waits: setattr(travel, "stop", place.stroke == 1), LINES
    return found


@pytest.mark.parametrize("state", states())
@pytest.mark.parametrize("name", PLOTTERS)
def test_a_plotter_stops_with_its_pen_up_and_goes_on(tmp_path, name, state):
    control, watch, drawing = states()[state]
    fake, target = PLOTTERS[name]()
    journal = Journal(tmp_path / "j", drawing, resume=False)
    ended = send(drawing, target, journal, control, watch)
    assert not settled(fake).pen_down
    assert ended.stroke < 4
    assert not journal.doubtful
    assert fake.breaches == []
    # Twice: what is stopped can be told so again, and again.
    assert target.abort() in (True, False)
    assert target.abort() in (True, False)
    assert not settled(fake).pen_down
    journal.close()


@pytest.mark.parametrize("name", PLOTTERS)
def test_after_a_fault_a_plotter_can_be_stopped_twice_and_never_claims_too_much(tmp_path, name):
    for line in (3, 6, 9, 12):
        for kind in ("garbage", "unplug", "silence"):
            fake, target = PLOTTERS[name](fault=Fault(kind, line))
            journal = Journal(tmp_path / "j", LINES, resume=False)
            with pytest.raises(DeviceFailed) as caught:
                send(LINES, target, journal, Control(), quiet)
            said = str(caught.value)
            assert ("the pen is up" in said) != ("pen state unknown: lift it by hand" in said)
            assert not (fake.pen_down and "the pen is up" in said)
            for _ in range(2):
                assert not (target.abort() and fake.pen_down)
            journal.close()


class Struck(Asked):
    """Whatever happens, happens when it is asked for the n-th time whether to go on."""

    def going_on(self):
        if not super().going_on():
            raise self.error
        return True


@pytest.mark.parametrize("error", [KeyboardInterrupt, MemoryError, ZeroDivisionError])
@pytest.mark.parametrize("after", [0, 1, 60])
@pytest.mark.parametrize("name", PLOTTERS)
def test_whatever_strikes_while_a_plotter_draws_raises_the_pen(tmp_path, name, after, error):
    control, (fake, target) = Struck(after), PLOTTERS[name]()
    control.error = error
    drawing = LINES if after < 60 else LONG
    journal = Journal(tmp_path / "j", drawing, resume=False)
    with pytest.raises(error):
        send(drawing, target, journal, control, quiet)
    assert not settled(fake).pen_down
    assert fake.breaches == []
    assert journal.doubtful, "what was begun may be on the paper"
    journal.close()


def rosbridge(fake):
    robot, topic = arms.robot(), "/arm/command"
    address = BridgeAddress(f"ws://127.0.0.1:{fake.port}", topic)
    return Rosbridge(address, arms.route(), RosbridgeSettings(), robot.joints, robot.base, 100.0, arms.arm_clock(PACE))


def led(device, tmp_path, control, watch):
    """An arm is led along the strokes; where it ended, and the journal."""
    lines = arms.route().lines_mm()
    journal = Journal(tmp_path / "j", Drawing(lines, ("face",) * len(lines), np.ones(len(lines))), resume=False)

    def draw(place):
        return Place(place.stroke + device.draw(place.stroke, lambda: control.stop))

    try:
        return drive(device, draw, len(lines), journal, control, watch), journal
    finally:
        journal.close()


@pytest.mark.parametrize("state", ["idle", "before a stroke", "paused", "pausing and stopped at once"])
@pytest.mark.parametrize("kind", ["simulated", "rosbridge"])
def test_an_arm_stops_with_its_pen_up(tmp_path, kind, state):
    pytest.importorskip("mujoco", reason="pip install 'limner[robot]'")
    pytest.importorskip("websockets", reason="pip install 'limner[ros]'")
    control, waited = Control(stop=state == "idle"), []

    def watch(place, waits):
        if waits:
            stopped(control, waited)
        elif place.stroke == 1:
            control.pause = state == "paused"
            if state in ("before a stroke", "pausing and stopped at once"):
                control.stop, control.pause = True, state.startswith("pausing")

    robot = arms.robot()
    limits = (robot.lower, robot.upper, robot.velocity, robot.acceleration)
    with FakeRosbridge(robot.joints, robot.pose("safe"), limits, "/arm/command", pace=PACE) as fake:
        device = SimulatedArm(arms.route(), SimulationSettings(), 1000.0) if kind == "simulated" else rosbridge(fake)
        ended, journal = led(device, tmp_path, control, watch)
        assert ended.stroke <= 2
        assert not journal.doubtful
        assert fake.breaches == []
        # Twice, after it has ended.
        device.abort()
        device.abort()
    assert not fake.done or np.allclose(fake.q, robot.pose("safe"), atol=1e-6), "it has gone home"


def test_a_studio_can_be_told_to_stop_in_every_state_in_which_a_machine_may_move():
    assert all("cancel" in COMMANDS[state] for state in BUSY)
    assert "cancel" in COMMANDS["cancelling"], "twice"
    assert set(COMMANDS) - set(BUSY) == {"idle", "cancelled", "done", "error", "lost", "interrupted"}
