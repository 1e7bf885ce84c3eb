"""A drawing of dots alone goes every way that lines go: onto files and back, plotters, arms, within a budget."""

import numpy as np
import pytest

from limner.drawing.clean import CleanSettings, clean
from limner.drawing.measure import measure
from limner.drawing.order import OrderSettings, order, travel_mm
from limner.drawing.select import SelectSettings, select
from limner.errors import NothingToDraw
from limner.motion.cost import costs
from limner.motion.machine import MACHINES, load_machine
from limner.motion.pen import plan
from limner.targets.gcode import GcodeSettings, to_gcode
from limner.targets.gcode_read import read_gcode
from limner.targets.hpgl import to_hpgl
from limner.targets.hpgl_read import read_hpgl
from limner.targets.image import to_rgb
from limner.targets.journal import Journal
from limner.targets.send import Control, send
from limner.targets.svg import SvgSettings, to_svg
from limner.targets.svg_read import read_svg
from limner.types import Drawing
from plotters import ebb, grbl

COUNT = 60
RNG = np.random.default_rng(0)
# On the grid of HP-GL, which is the coarsest.
DOTS = Drawing(
    tuple(np.round(point[None] * 40) / 40 for point in RNG.uniform(15, 130, (COUNT, 2))),
    ("eye",) * 20 + ("face",) * 40,
    np.linspace(2, 1, COUNT),
)


def places(drawing):
    assert all(len(line) == 1 for line in drawing.lines_mm)
    return np.round(np.concatenate(drawing.lines_mm), 3)


@pytest.mark.parametrize("curves", [False, True])
def test_svg_and_back(curves):
    assert places(read_svg(to_svg(DOTS, how=SvgSettings(curves=curves)))).tolist() == places(DOTS).tolist()


@pytest.mark.parametrize("pen", ["servo", "z"])
def test_gcode_and_back(pen):
    assert places(read_gcode(to_gcode(DOTS, GcodeSettings(pen=pen)))).tolist() == places(DOTS).tolist()


def test_hpgl_and_back():
    assert places(read_hpgl(to_hpgl(DOTS))).tolist() == places(DOTS).tolist()


def test_a_picture_has_a_disc_of_the_pens_width_at_each():
    ink = 1 - to_rgb(DOTS, 20)[..., 0].mean() / 255
    page = DOTS.page.width_mm * DOTS.page.height_mm
    assert ink * page == pytest.approx(COUNT * np.pi * 0.25**2, rel=0.05)


@pytest.mark.parametrize("name", MACHINES)
def test_the_pen_touches_at_each_dot_and_the_costs_are_the_plans(name):
    machine = load_machine(name)
    path = plan(DOTS, machine)
    found = costs(DOTS, machine)
    assert found.seconds == pytest.approx(float(path.t_s[-1]), rel=1e-6)
    assert (found.lifts, found.ink_mm) == (COUNT, 0)
    down = path.stroke >= 0
    assert np.unique(path.stroke[down]).tolist() == list(range(COUNT))
    assert (path.position_mm[down, 2] == path.position_mm[:, 2].min()).all()
    for k, line in enumerate(DOTS.lines_mm):
        assert np.abs(path.position_mm[path.stroke == k, :2] - line).max() < 1e-6


@pytest.mark.parametrize("make", [grbl, lambda: grbl(pen="z"), ebb], ids=["servo", "z", "ebb"])
def test_plotters_put_each_dot_once(tmp_path, make):
    fake, driver = make()
    journal = Journal(tmp_path / "journal", DOTS, resume=False)
    send(DOTS, driver, journal, Control(), lambda *_: None)
    journal.close()
    assert not fake.breaches
    # The boards' steps and thousandths are finer than a twentieth of a millimetre.
    touched = np.array([segment[0] for segment in fake.ink if segment[0] == segment[1]])
    assert len(touched) == len(fake.ink) == COUNT
    assert np.abs(touched - np.concatenate(DOTS.lines_mm)).max() < 0.05


def test_a_budget_counts_dots_and_keeps_the_heaviest_regions():
    chosen = select(DOTS, SelectSettings(points=20))
    assert chosen.points == 20 == len(chosen.lines_mm)


def test_order_shortens_the_way_between_dots():
    ordered = order(DOTS, OrderSettings())
    assert sorted(places(ordered).tolist()) == sorted(places(DOTS).tolist())
    assert travel_mm(ordered) < 0.5 * travel_mm(DOTS)
    assert measure(ordered).lifts == COUNT


def test_cleaning_keeps_dots_when_told_to():
    assert len(clean(DOTS, CleanSettings(min_length_mm=0)).lines_mm) == COUNT
    with pytest.raises(NothingToDraw):
        clean(DOTS, CleanSettings())


def test_an_arm_touches_the_paper_at_each_dot():
    pytest.importorskip("toppra", reason="pip install 'limner[robot]'")
    from limner.motion.arm.plan import ArmSettings, plan_arm
    from limner.motion.arm.robots import load_robot

    few = DOTS.pick(range(6))
    trajectory = plan_arm(few, load_robot("dumbo"), ArmSettings()).trajectory
    assert np.unique(trajectory.stroke[trajectory.stroke >= 0]).tolist() == list(range(6))
    assert trajectory.down.any()
