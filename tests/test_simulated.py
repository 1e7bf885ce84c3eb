"""Machines that are not there: a plotter draws what it is told in the time it would take; an arm obeys physics."""

from __future__ import annotations

import numpy as np
import pytest

from limner.errors import BadInput
from limner.motion.machine import load_machine
from limner.motion.pen import plan
from limner.targets import simulated
from limner.targets.journal import Journal
from limner.targets.send import Control, send
from limner.targets.simulated import Clock, SimulatedPlotter, parse_pace
from limner.types import Drawing, Page, Pen

PAGE = Page(100, 100, 5)
LINES = (
    np.array([(10.0, 10), (60, 10), (60, 40)]),
    np.array([(20.0, 50)]),
    np.array([(60.0, 40), (20, 80), (10, 10)]),
)
DRAWING = Drawing(LINES, ("face",) * 3, np.ones(3), PAGE)
MACHINE = load_machine("axidraw")


def motion(start, line):
    return plan(Drawing((line,), ("face",), np.ones(1), PAGE, (Pen(),)), MACHINE, start, None)


def plotter(pace=1000.0):
    return SimulatedPlotter(motion, MACHINE.home_mm(PAGE).tolist(), pace)


@pytest.fixture
def journal(tmp_path):
    journal = Journal(tmp_path / "journal", DRAWING, resume=False)
    yield journal
    journal.close()


def test_it_draws_every_line_once(journal):
    target = plotter()
    ended = send(DRAWING, target, journal, Control(), lambda place, waits: None)
    assert ended.stroke == 3
    assert sum(len(line) for line in target.lines_mm) >= sum(map(len, LINES)) - 1
    assert np.allclose(target.lines_mm[0][0], LINES[0][0])
    assert np.allclose(target.lines_mm[-1][-1], LINES[-1][-1])


def test_it_takes_the_time_that_was_planned(monkeypatch):
    now = [0.0]
    monkeypatch.setattr(simulated.time, "monotonic", lambda: now[0])
    monkeypatch.setattr(simulated.time, "sleep", lambda seconds: now.__setitem__(0, now[0] + seconds))
    target = plotter(pace=4.0)
    at, whole = np.array(MACHINE.home_mm(PAGE)), 0.0
    for line in LINES:
        path = motion(at, line)
        whole, at = whole + float(path.t_s[-1]), line[-1]
        assert target.draw(line, lambda: True) == len(line) - 1
        assert now[0] == pytest.approx(whole / 4, abs=0.021)


def test_it_stops_at_a_point_and_goes_on_there():
    target, asked = plotter(), []

    def going_on():
        asked.append(None)
        return len(asked) < 2

    assert target.draw(LINES[0], going_on) == 1
    assert np.allclose(target.lines_mm[0], LINES[0][:2])
    assert target.draw(LINES[0][1:], lambda: True) == 1


def test_who_waits_is_not_late_afterwards(monkeypatch):
    now = [0.0]
    monkeypatch.setattr(simulated.time, "monotonic", lambda: now[0])
    monkeypatch.setattr(simulated.time, "sleep", lambda seconds: now.__setitem__(0, now[0] + seconds))
    clock = Clock(1.0)
    clock.wait(2.0)
    now[0] += 100
    began = now[0]
    clock.wait(3.0)
    assert 1.9 < now[0] - began <= 3.0
    assert clock.wait(5.0, lambda: False) < 0.1


@pytest.mark.parametrize(("text", "pace"), [("sim:", 1.0), ("sim:20", 20.0), ("sim:0.5", 0.5)])
def test_a_pace_is_read(text, pace):
    assert parse_pace(text) == pace


@pytest.mark.parametrize("text", ["sim", "sim:fast", "sim:0", "sim:-1", "sim:nan", "sim:1e9", "grbl:1"])
def test_no_other_pace(text):
    with pytest.raises(BadInput, match="sim:20"):
        parse_pace(text)


@pytest.mark.slow
def test_a_simulated_arm_follows_presses_and_stops():
    pytest.importorskip("mujoco")
    pytest.importorskip("urdf_parser_py")
    from limner.motion.arm.legs import legs
    from limner.motion.arm.plan import ArmSettings, plan_arm
    from limner.motion.arm.robots import load_robot
    from limner.simulation.device import SimulatedArm
    from limner.simulation.settings import SimulationSettings

    settings, robot = ArmSettings(), load_robot("ur5e")
    route = legs(plan_arm(DRAWING, robot, settings).trajectory, robot, settings.retime)
    arm = SimulatedArm(route, SimulationSettings(press_mm=settings.lift.press_mm), 1000.0)
    arm.open()
    assert arm.draw(0, lambda: False)
    assert 0.1 < arm.force_n[0] < 20, "the pen presses, gently"
    assert not arm.draw(1, lambda: True), "told to stop it stops"
    assert arm.draw(1, lambda: False)
    assert arm.draw(2, lambda: False)
    arm.home()
    assert arm.abort()
