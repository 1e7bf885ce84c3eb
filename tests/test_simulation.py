import dataclasses
import json

import cv2
import numpy as np
import pytest
from click.testing import CliRunner

from limner import storage, transforms
from limner.cli import limner
from limner.errors import BadInput, CannotDraw
from limner.motion.arm.lifted import LiftSettings
from limner.motion.arm.place import PlaceSettings
from limner.motion.arm.plan import ArmSettings, plan_arm
from limner.motion.arm.robot import Capsule
from limner.motion.arm.robots import load_robot
from limner.motion.arm.spline import hermite
from limner.simulation.commands import commands
from limner.simulation.film import RATE, camera, frames, to_film
from limner.simulation.ink import widths
from limner.simulation.outcome import distance_mm, follow, simulate
from limner.simulation.pictures import ticks
from limner.simulation.render import Scene, _cast
from limner.simulation.settings import FaultSettings, SimulationSettings
from limner.simulation.sheet import Sheet, find_sheet
from limner.simulation.thesis import STIFF_PRESS_MM, thesis_motion
from limner.targets import joints
from limner.types import Drawing, Page, Pen, Photo

pytest.importorskip("mujoco", reason="pip install 'limner[robot]'")
pytest.importorskip("urdf_parser_py", reason="pip install 'limner[robot]'")
pytest.importorskip("toppra", reason="pip install 'limner[robot]'")

# A square, a zigzag and a circle, so that there are corners, reversals and curves.
TURN = np.linspace(0, 2 * np.pi, 24)
LINES = (
    np.array([[60, 90], [85, 90], [85, 115], [60, 115], [60, 90]], float),
    np.array([[65, 95], [72, 110], [76, 95], [80, 110]], float),
    np.stack([95 + 6 * np.cos(TURN), 120 + 6 * np.sin(TURN)], axis=1),
)
PRESS_MM = LiftSettings().press_mm


@pytest.fixture(scope="module")
def drawing():
    return Drawing(LINES, ("face",) * 3, np.ones(3))


@pytest.fixture(scope="module")
def planned(drawing):
    at = PlaceSettings(at="-0.25,0.4,-0.3,90")
    return plan_arm(drawing, load_robot("dumbo"), ArmSettings(place=at))


@pytest.fixture(scope="module")
def go(planned, drawing):
    made = {}

    def run(**settings):
        key = repr(settings)
        if key not in made:
            made[key] = simulate(planned.trajectory, planned.robot, SimulationSettings(**settings), drawing)
        return made[key]

    return run


def faulty(**fault):
    return {"fault": FaultSettings(**fault)}


def test_the_sheet_is_found_from_the_motion_alone(planned, drawing):
    found = find_sheet(planned.trajectory, planned.robot, PRESS_MM, drawing)
    assert found.page == drawing.page
    apart = transforms.inverse(planned.placement.base_from_paper) @ found.base_from_paper
    assert np.abs(1000 * apart[:3, 3]).max() < 0.2
    assert np.degrees(np.arccos(np.clip((np.trace(apart[:3, :3]) - 1) / 2, -1, 1))) < 0.1
    alone = find_sheet(planned.trajectory, planned.robot, PRESS_MM)
    assert abs(alone.points_mm(planned.placement.points_m([0.0, 0.0]))[2]) < 1e-3
    assert alone.page.width_mm == pytest.approx(51 if alone.page.width_mm > 50 else 61, abs=20)


def test_one_straight_stroke_tells_its_sheet_by_the_pen(planned):
    straight = Drawing((np.array([[60.0, 100.0], [90.0, 100.0]]),), ("face",), np.ones(1))
    plan = plan_arm(straight, planned.robot, ArmSettings(place=PlaceSettings(at="-0.25,0.4,-0.3,90")))
    found = find_sheet(plan.trajectory, plan.robot, PRESS_MM, straight)
    assert np.allclose(found.base_from_paper, plan.placement.base_from_paper, atol=2e-3)


def test_another_drawing_is_refused(planned, drawing):
    other = dataclasses.replace(drawing, lines_mm=tuple(line[::-1] * [1, 0.5] for line in LINES))
    with pytest.raises(BadInput, match="strokes lie"):
        find_sheet(planned.trajectory, planned.robot, PRESS_MM, other)
    fewer = Drawing(LINES[:1], ("face",), np.ones(1))
    with pytest.raises(BadInput, match="has 1 strokes"):
        find_sheet(planned.trajectory, planned.robot, PRESS_MM, fewer)


def test_a_fault_moves_the_paper_as_it_says():
    flat = Sheet(np.eye(4), Page(100, 200, 0))
    up = flat.faulty(FaultSettings(paper_mm=1.5))
    assert np.allclose(up.points_m(np.array([[0.0, 0.0], [100.0, 200.0]]))[:, 2], 0.0015)
    tilted = flat.faulty(FaultSettings(tilt_deg=1, tilt_towards_deg=0))
    left, middle, right = tilted.points_m(np.array([[0.0, 100.0], [50.0, 100.0], [100.0, 100.0]]))[:, 2]
    assert np.allclose([left, middle, right], np.sin(np.radians(1)) * np.array([-0.05, 0, 0.05]))


def test_commands_follow_the_motion_and_come_late_when_told_so(planned):
    t = np.arange(0, float(planned.trajectory.t_s[-1]), 0.001)
    q, qd, _ = hermite(planned.trajectory, t)
    told, speed = commands(planned.trajectory, planned.robot, SimulationSettings(), t)
    assert np.abs(told - q).max() < 1e-3
    assert np.abs(speed - qd).max() < 0.05
    assert np.abs(np.gradient(q, t, axis=0) - qd)[1:-1].max() < 0.05
    late, _ = commands(planned.trajectory, planned.robot, SimulationSettings(**faulty(jitter_ms=10)), t)
    assert np.abs(told - q).max() < np.abs(late - q).max() < 0.66 * 0.012
    assert not commands(planned.trajectory, planned.robot, SimulationSettings(feed_forward=False), t)[1].any()


def test_the_arm_misses_by_no_more_than_its_repeatability(planned):
    t = np.arange(0, float(planned.trajectory.t_s[-1]), 0.01)
    told, _ = commands(planned.trajectory, planned.robot, SimulationSettings(**faulty(repeat_mm=1)), t)
    right, _ = commands(planned.trajectory, planned.robot, SimulationSettings(), t)
    off = planned.robot.forward(told)[:, :3, 3] - planned.robot.forward(right)[:, :3, 3]
    assert 0.3 < 1000 * np.linalg.norm(off, axis=1).max() < 1.1


def test_ink_follows_the_plan(go, drawing):
    made = go()
    report = made.report()
    assert report["contact_percent"] >= 99.5
    assert report["ink_error_mm"]["p95"] < 0.5
    assert report["travel_ink_mm"] == 0
    # Measured once more against the drawing itself, not the plan; corners are rounded by 0.15 mm.
    drawn = made.ink.touches & made.ink.down
    for index, line in enumerate(drawing.lines_mm):
        places = made.ink.place_mm[drawn & (made.ink.stroke == index)]
        assert np.percentile(distance_mm(places, line), 95) < 0.65
        assert distance_mm(line, places).max() < 1.5


def test_the_force_is_that_of_the_spring(go):
    preload, stiffness = 5e-3, 200.0
    for off_mm in (-1, 0, 1):
        made = go(**faulty(paper_mm=off_mm))
        expected = stiffness * (preload + (PRESS_MM + off_mm) / 1000)
        assert made.report()["force_n"]["median"] == pytest.approx(expected, rel=0.03)


@pytest.mark.parametrize("paper_mm", [-1, 1])
@pytest.mark.parametrize("towards", [0, 130])
def test_a_sprung_pen_stays_on_paper_that_lies_wrong(go, paper_mm, towards):
    report = go(**faulty(paper_mm=paper_mm, tilt_deg=1, tilt_towards_deg=towards)).report()
    assert report["contact_percent"] >= 99.5
    assert report["travel_ink_mm"] == 0


def test_a_pen_over_paper_far_below_leaves_no_ink(go):
    report = go(**faulty(paper_mm=-10)).report()
    assert report["contact_percent"] == 0
    assert report["ink_mm"] == 0
    assert report["ink_error_mm"]["p95"] is None


def test_a_stiff_pen_misses_or_presses_hard(go):
    assert go(stiff=True, press_mm=0, **faulty(paper_mm=-1)).report()["contact_percent"] == 0
    hard = go(stiff=True, press_mm=0, **faulty(paper_mm=1)).report()["force_n"]["median"]
    assert hard > 3 * go().report()["force_n"]["median"]


def test_feed_forward_is_what_keeps_up(go):
    assert go(feed_forward=False).report()["tracking_mm"]["rms"] > 4 * go().report()["tracking_mm"]["rms"]


def test_the_same_seed_gives_the_same_ink_and_another_one_other_ink(planned, drawing, go):
    fault = {"repeat_mm": 1, "jitter_ms": 10}
    again = simulate(planned.trajectory, planned.robot, SimulationSettings(**faulty(**fault)), drawing)
    assert again.record == go(**faulty(**fault)).record
    assert again.record != go(**faulty(seed=1, **fault)).record


def test_harder_is_wider():
    force = np.linspace(0, 6, 50)
    width = widths(force, 0.5)
    assert (np.diff(width) >= 0).all()
    assert widths(np.array([1.5]), 0.5) == pytest.approx(0.5)


def test_the_thesis_way_leaves_gaps_or_trails_and_ours_neither(go, drawing):
    ours = go(**faulty(repeat_mm=1))
    orientation = ours.robot.forward(ours.trajectory.q[ours.trajectory.down][0])[:3, :3]

    def theirs(stiff, press_mm):
        motion = thesis_motion(ours.plan_mm, ours.sheet, orientation, ours.robot, press_mm)
        return follow(motion, ours.robot, ours.sheet, ours.settings.replace(stiff=stiff)).report()

    assert ours.report()["contact_percent"] >= 99.5
    assert ours.report()["travel_ink_mm"] < 0.2
    assert theirs(True, STIFF_PRESS_MM)["contact_percent"] < 97
    assert theirs(False, PRESS_MM)["travel_ink_mm"] > 2


def test_the_film_shows_arm_and_ink_growing(go):
    first, half, last = frames(go(), Pen(), 3)
    assert first.shape == last.shape
    panel = np.s_[:, 560:]
    dark = [(picture[panel] < 90).all(-1).sum() for picture in (first, half, last)]
    assert dark[0] < dark[1] < dark[2]
    orange = (np.abs(half[:, :560].astype(int) - [150, 66, 34]).max(-1) < 50).sum()
    assert orange > 300


@pytest.mark.slow
def test_films_are_written_and_read_back_with_the_photo_beside(go, tmp_path):
    photo = Photo(np.full((60, 40, 3), (10, 200, 30), np.uint8))
    for suffix in (".gif", ".mp4"):
        file = tmp_path / f"film{suffix}"
        file.write_bytes(to_film(go(), Pen(), suffix, 0.5, photo))
        film, pictures = cv2.VideoCapture(str(file)), []
        while (read := film.read())[0]:
            pictures.append(read[1][..., ::-1].astype(int))
        assert len(pictures) >= 0.5 * RATE[suffix]
        green = (np.abs(pictures[0] - [10, 200, 30]).max(-1) < 40).sum()
        assert green > 20_000
        assert (np.abs(pictures[-1] - pictures[0]).max(-1) > 60).sum() > 500


@pytest.mark.slow
@pytest.mark.parametrize("name", ["lwa4d", "ur5e"])
def test_other_arms_draw_too(drawing, name):
    robot = load_robot(name)
    made = simulate(plan_arm(drawing, robot, ArmSettings()).trajectory, robot, SimulationSettings(), drawing)
    report = made.report()
    assert report["contact_percent"] >= 99.5
    assert report["ink_error_mm"]["p95"] < 0.5
    assert report["travel_ink_mm"] == 0


def test_the_plan_says_how_far_it_presses(planned, drawing, tmp_path):
    for suffix in joints.FORMATS:
        joints.save(planned.trajectory, tmp_path / f"m{suffix}")
        assert joints.load(tmp_path / f"m{suffix}").press_mm == PRESS_MM
    shallow = ArmSettings(place=PlaceSettings(at="-0.25,0.4,-0.3,90"), lift=LiftSettings(press_mm=1.0))
    plan = plan_arm(drawing, planned.robot, shallow)
    made = simulate(plan.trajectory, plan.robot, SimulationSettings(), drawing)
    assert made.sheet.points_mm(plan.placement.points_m([0.0, 0.0]))[2] == pytest.approx(0, abs=1e-2)
    with pytest.raises(BadInput, match="press_mm"):
        dataclasses.replace(plan.trajectory, press_mm=-1.0)


def test_what_is_below_the_table_does_not_hide_the_sheet(go):
    made = go()
    low = Capsule(0, *(made.paper.points_m(np.array([x, 105.0, -300.0])) for x in (0.0, 148.0)), 0.29)
    touching = dataclasses.replace(low, radius_m=0.31)
    white = np.full((210, 148, 3), 255, np.uint8)

    def sheet_px(*capsules):
        robot = dataclasses.replace(made.robot, capsules=capsules)
        picture = Scene(robot, made.paper, camera(made)).picture(made.record.q[0], made.record.tip_m[0], white)
        return int((picture > 250).all(-1).sum())

    assert sheet_px(low) == sheet_px() > 500
    assert sheet_px(touching) < sheet_px(), "what is above it does"


def test_a_capsule_is_met_where_it_is():
    rays = np.array([[[0, 0, 1.0], [0.0, 0.6, 0.8]]], np.float32)
    ends = np.array([[-1, 0, 5], [1, 0, 5]], np.float32)
    distance, normal = _cast(rays, *ends, 0.5)
    assert distance[0, 0] == pytest.approx(4.5)
    assert np.allclose(normal[0, 0], [0, 0, -1], atol=1e-6)
    assert np.isinf(distance[0, 1])


def altered(trajectory, **changes):
    fields = storage.to_fields(trajectory)
    for name, change in changes.items():
        fields[name] = change(fields[name])
    return fields


def faster(times):
    return [t / 2 for t in times]


def jump(positions):
    positions[len(positions) // 2][1] += 0.3
    return positions


@pytest.mark.parametrize(
    ("changes", "code", "words"),
    [
        ({"t_s": faster}, 4, "limit"),
        ({"q": jump}, 4, "limit"),
        ({"names": lambda names: [f"other_{name}" for name in names]}, 4, "joints"),
        ({"q": lambda q: [[float("nan")] * 7 for _ in q]}, 2, "finite"),
        ({"down": lambda down: [False] * len(down)}, 4, "in travel"),
        ({"q": lambda q: [row[:6] for row in q]}, 2, "shape"),
    ],
)
def test_an_altered_trajectory_is_refused_in_one_line(planned, tmp_path, changes, code, words):
    file = tmp_path / "tr.json"
    file.write_text(json.dumps(altered(planned.trajectory, **changes)))
    done = CliRunner().invoke(limner, ["simulate", str(file)])
    assert done.exception.exit_code == code
    assert words in str(done.exception)
    assert "\n" not in str(done.exception)


def test_the_command_writes_ink_and_numbers(planned, drawing, tmp_path):
    storage.save(planned.trajectory, tmp_path / "tr.json")
    storage.save(drawing, tmp_path / "d.json")
    out = tmp_path / "out"
    cv2.imwrite(str(tmp_path / "p.png"), np.full((40, 30, 3), 99, np.uint8))
    files = ["--drawing", str(tmp_path / "d.json"), "--photo", str(tmp_path / "p.png")]
    done = CliRunner().invoke(
        limner,
        ["simulate", str(tmp_path / "tr.json"), *files, "-o", str(out), "--json"],
    )
    assert done.exit_code == 0, done.output
    told = json.loads(done.stdout)
    assert told["contact_percent"] >= 99.5
    assert json.loads((out / "report.json").read_text())["ink_mm"] == told["ink_mm"]
    assert {path.name for path in out.iterdir()} >= {"ink.svg", "ink.png", "overlay.png", "force.png", "beside.png"}
    from limner.targets.files import read_drawing

    ink = read_drawing(out / "ink.svg")
    for line in ink.lines_mm:
        assert min(distance_mm(line, wanted).max() for wanted in drawing.lines_mm) < 1


@pytest.mark.parametrize("high", [0.3, 2.0, 2.5, 9.99, 10.0, 43.2, 61.0, 1300.0])
@pytest.mark.parametrize("most", [5, 10])
def test_scales_of_plots_have_round_numbers(high, most):
    marks = ticks(high, most)
    step = marks[1]
    assert float(f"{step:e}".partition("e")[0]) in (1, 2, 5)
    assert np.allclose(np.diff(marks), step)
    assert marks[0] == 0
    assert high - step < marks[-1] <= high * (1 + 1e-9)
    assert 2 <= len(marks) - 1 <= most


def test_unknown_limits_are_refused_before_any_physics(planned):
    slower = dataclasses.replace(planned.robot, velocity=planned.robot.velocity / 2)
    with pytest.raises(CannotDraw, match="velocity"):
        simulate(planned.trajectory, slower)


@pytest.mark.slow
def test_a_photo_is_drawn_by_the_simulated_arm_in_one_command(tmp_path):
    photo = pytest.importorskip("skimage").data.astronaut()[:300, 80:380]
    cv2.imwrite(str(tmp_path / "photo.png"), photo[..., ::-1])
    out = tmp_path / "out"
    command = ["draw", str(tmp_path / "photo.png"), "-n", "150", "-o", str(tmp_path / "d.svg"), "--json"]
    done = CliRunner().invoke(limner, [*command, "--simulate", str(out)])
    assert done.exit_code == 0, done.output
    told = json.loads(done.stdout)["simulation"]
    assert told["contact_percent"] >= 99.5
    assert told["plan"]["robot"] == told["robot"] == "dumbo"
    assert {path.name for path in out.iterdir()} >= {"trajectory.json", "ink.svg", "beside.png", "report.json"}
