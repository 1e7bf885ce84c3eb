"""A drawing and an arm go in; what was promised of the arm, beside what is measured, comes out."""

from __future__ import annotations

import time
from collections.abc import Iterator

import numpy as np

from limner.evaluate.speed import Row
from limner.motion.arm.ik import inverse
from limner.motion.arm.numeric_ik import NumericSettings, PinocchioArm
from limner.motion.arm.plan import ArmPlan, ArmSettings, plan_arm
from limner.motion.arm.retime import retime
from limner.motion.arm.robot import Robot
from limner.motion.arm.srs import SphericalArm
from limner.simulation.outcome import Simulation, follow, simulate
from limner.simulation.settings import FaultSettings, SimulationSettings
from limner.simulation.thesis import MISS_MM, STIFF_PRESS_MM, thesis_motion
from limner.types import Drawing, Floats

THESIS_S_PER_POINT = 1.5
"""Section 4.4."""

FINER = 5
"""Times as many places where limits are held as the plan has, for the best there is."""

POSES = 10_000

FAULTS = (
    ("nominal", FaultSettings()),
    ("paper 1 mm too low, 1 deg", FaultSettings(paper_mm=-1, tilt_deg=1)),
    ("paper 1 mm too high, 1 deg", FaultSettings(paper_mm=1, tilt_deg=1)),
)


def measure_arm(drawing: Drawing, robot: Robot, settings: ArmSettings, physics: SimulationSettings) -> Iterator[Row]:
    """Plan, time, solve and simulate; CPU times are of this process.

    Args:
        drawing: of about 600 points on A5, for which the figures were promised.
        robot: that draws.
        settings: of the plan.
        physics: of the simulation, without faults.
    """
    started = time.process_time()
    planned = plan_arm(drawing, robot, settings)
    spent = time.process_time() - started
    yield from plan_rows(planned, drawing, spent, settings)
    yield from inverse_rows(robot, planned)
    for name, fault in FAULTS:
        made = simulate(planned.trajectory, robot, physics.replace(fault=fault), drawing)
        yield from simulation_rows(made, name)
    yield from thesis_rows(made, physics)


def plan_rows(planned: ArmPlan, drawing: Drawing, spent_s: float, settings: ArmSettings) -> Iterator[Row]:
    """Time, CPU time and use of the limits."""
    told, points = planned.report(), sum(map(len, drawing.lines_mm))
    yield Row(f"{points} points, {told['strokes']} strokes: from the first ink to the last", told["ink_s"], "s", 60)
    yield Row("from the safe pose and back to it", told["seconds"], "s")
    yield Row("the thesis's 1.5 s a point", THESIS_S_PER_POINT * points, "s")
    yield Row("planning", spent_s, "CPU s", 5)
    for name in ("velocity", "acceleration"):
        yield Row(f"largest {name}, part of its limit", told[f"{name}_used"], "", 1.01)
    fine = settings.retime.replace(grid_per_mm=min(100.0, FINER * settings.retime.grid_per_mm))
    ours, best = (retime(planned.robot, planned.path, planned.q, one).t_s[-1] for one in (settings.retime, fine))
    yield Row(f"against TOPP-RA on a grid {FINER} times as fine", float(ours / best), "times", 1.25)


def inverse_rows(robot: Robot, planned: ArmPlan) -> Iterator[Row]:
    """Accuracy over random poses, by pinocchio, and CPU time; none for arms without a closed form."""
    arm = SphericalArm.of(robot)
    if arm is None:
        return
    rng = np.random.default_rng(0)
    tips = robot.forward(rng.uniform(robot.lower, robot.upper, (POSES, robot.dof)))
    q, reached = arm.solve(tips, rng.uniform(-np.pi, np.pi, POSES))
    judge = PinocchioArm(robot, NumericSettings())
    chosen = q[np.arange(POSES), rng.integers(0, 8, POSES)][reached]
    found = np.array([judge.forward(one) for one in chosen])
    off = np.linalg.norm(found[:, :3, 3] - tips[reached][:, :3, 3], axis=1)
    yield Row(f"closed form over {len(off)} poses, by pinocchio's kinematics", 1e12 * float(off.max()), "pm", 1000)
    path = planned.placement.tips(planned.path.points_mm)[:1000]
    yield Row("inverse kinematics with the elbow search, 1000 points", _cpu_s(robot, path), "CPU s", 1)
    started = time.process_time()
    judge.track(path, planned.trajectory.q[np.flatnonzero(planned.trajectory.down)[0]])
    yield Row("the same by pinocchio, one start, no search", time.process_time() - started, "CPU s")


def _cpu_s(robot: Robot, tips: Floats) -> float:
    solver, started = inverse(robot), time.process_time()
    solver.follow(tips)
    return time.process_time() - started


def simulation_rows(made: Simulation, name: str) -> Iterator[Row]:
    """Ink, contact and trails."""
    told = made.report()
    yield Row(f"{name}: 95 % of the ink within", told["ink_error_mm"]["p95"], "mm", 0.5)
    yield Row(f"{name}: ink that is missing", 100 - told["contact_percent"], "%", 0.5)
    yield Row(f"{name}: ink in travel", told["travel_ink_mm"], "mm", 0.0)


def thesis_rows(made: Simulation, physics: SimulationSettings) -> Iterator[Row]:
    """The same of the thesis's way on an arm that misses as its own did, which is what is cured."""
    missing = physics.replace(fault=FaultSettings(repeat_mm=MISS_MM))
    held = made.robot.forward(made.trajectory.q[made.trajectory.down][0])[:3, :3]
    for name, stiff, press_mm in (("stiff", True, STIFF_PRESS_MM), ("sprung", False, made.press_mm)):
        motion = thesis_motion(made.plan_mm, made.sheet, held, made.robot, press_mm)
        told = follow(motion, made.robot, made.sheet, missing.replace(stiff=stiff)).report()
        yield Row(f"the thesis's way, {name} pen: ink that is missing", 100 - told["contact_percent"], "%")
        yield Row(f"the thesis's way, {name} pen: ink in travel", told["travel_ink_mm"], "mm")
    ours = follow(made.trajectory, made.robot, made.sheet, missing).report()
    yield Row("limner on that arm: ink that is missing", 100 - ours["contact_percent"], "%", 0.5)
    yield Row("limner on that arm: ink in travel", ours["travel_ink_mm"], "mm")
