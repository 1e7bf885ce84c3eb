"""What ``limner evaluate arm`` tells of an arm, against what is worked out here in another way."""

import json

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.interpolate import CubicHermiteSpline

from arms import drawing, planned, robot
from limner.cli.evaluate import evaluate
from limner.evaluate import arm
from limner.motion.arm.plan import ArmSettings
from limner.simulation.outcome import simulate
from limner.simulation.settings import SimulationSettings

pytest.importorskip("urdf_parser_py", reason="pip install 'limner[robot]'")
pytest.importorskip("toppra", reason="pip install 'limner[robot]'")
pytest.importorskip("mujoco", reason="pip install 'limner[robot]'")
pytest.importorskip("pinocchio", reason="pip install 'limner[robot]'")


def by_name(rows):
    rows = list(rows)
    found = {row.name: row for row in rows}
    assert len(found) == len(rows), "no figure is told twice"
    return found


@pytest.fixture(scope="module")
def plan_rows():
    return by_name(arm.plan_rows(planned(), drawing(), 1.25, ArmSettings()))


def test_the_time_of_drawing_is_from_the_first_touch_to_the_last(plan_rows):
    """Worked out from where the pen's tip is, not from what the motion says of itself."""
    motion = planned().trajectory
    height = planned().placement.points_mm(robot().forward(motion.q)[:, :3, 3])[:, 2]
    pressed = motion.t_s[np.abs(height + motion.press_mm) < 0.05]
    told = plan_rows["9 points, 4 strokes: from the first ink to the last"]
    assert told.value == pytest.approx(pressed[-1] - pressed[0], abs=0.02)
    assert (told.unit, told.goal, told.reached) == ("s", 60, True)
    assert plan_rows["from the safe pose and back to it"].value == pytest.approx(motion.t_s[-1] - motion.t_s[0])
    assert plan_rows["the thesis's 1.5 s a point"].value == 13.5
    assert (plan_rows["planning"].value, plan_rows["planning"].goal) == (1.25, 5)


def test_the_use_of_limits_is_that_of_the_motion_between_its_samples_too(plan_rows):
    motion = planned().trajectory
    way = CubicHermiteSpline(motion.t_s, motion.q, motion.qd)
    dense = (motion.t_s[:-1, None] + np.diff(motion.t_s)[:, None] * np.linspace(1e-6, 1 - 1e-6, 30)).ravel()
    limits = {"velocity": robot().velocity, "acceleration": robot().acceleration}
    for order, (name, limit) in enumerate(limits.items(), 1):
        used = float(np.abs(way(dense, order) / limit).max())
        told = plan_rows[f"largest {name}, part of its limit"]
        assert told.value == pytest.approx(used, abs=0.01)
        assert 0.9 < told.value <= told.goal == 1.01


def test_a_finer_grid_is_hardly_faster(plan_rows):
    told = plan_rows["against TOPP-RA on a grid 5 times as fine"]
    assert 0.95 < told.value < told.goal == 1.25


def test_the_figures_of_a_simulation_are_those_of_its_ink():
    made = simulate(planned().trajectory, robot(), SimulationSettings(), drawing())
    rows = by_name(arm.simulation_rows(made, "x"))
    ink = made.ink
    drawn, length = ink.touches & ink.down, np.r_[0.0, np.hypot(*np.diff(ink.place_mm, axis=0).T)]
    off = np.full(len(drawn), np.inf)
    for line in (np.array(line, float) for line in drawing().lines_mm):
        for a, b in zip(line[:-1] if len(line) > 1 else line, line[1:] if len(line) > 1 else line, strict=True):
            share = np.clip((ink.place_mm - a) @ (b - a) / max((b - a) @ (b - a), 1e-12), 0, 1)
            off = np.minimum(off, np.hypot(*(ink.place_mm - a - share[:, None] * (b - a)).T))
    near = np.sort(off[drawn])
    assert rows["x: 95 % of the ink within"].value == pytest.approx(near[int(0.95 * len(near))], abs=0.1)
    missing = 100 * (1 - length[drawn].sum() / length[ink.down].sum())
    assert rows["x: ink that is missing"].value == pytest.approx(missing, abs=1e-6)
    assert all(row.reached for row in rows.values())


@pytest.mark.slow
def test_the_command_tells_all_of_it(monkeypatch):
    monkeypatch.setattr(arm, "POSES", 300)
    monkeypatch.setattr("limner.cli.evaluate.pipeline.draw", lambda *_: type("Portrait", (), {"drawing": drawing()}))
    done = CliRunner().invoke(evaluate, ["arm", "me.jpg", "--json"], catch_exceptions=False)
    rows = {row["name"]: row for row in json.loads(done.stdout)["arm"]}
    for name in ("nominal", "paper 1 mm too low, 1 deg", "paper 1 mm too high, 1 deg"):
        assert rows[f"{name}: ink in travel"]["value"] == 0
        assert rows[f"{name}: 95 % of the ink within"]["value"] <= 0.5
    (closed,) = (row for name, row in rows.items() if name.startswith("closed form over"))
    assert closed["value"] <= closed["goal"] == 1000, "picometres"
    trails = rows["the thesis's way, sprung pen: ink in travel"]["value"]
    assert trails > rows["limner on that arm: ink in travel"]["value"] + 1, "what is cured shows"
