"""The planned motion keeps every limit at every time, draws what it should, and is as fast as theory says."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given, strategies as st

from drawings import drawings, of
from limner import geometry
from limner.drawing.measure import measure
from limner.errors import BadInput, CannotDraw, NothingToDraw
from limner.motion.area import check_area
from limner.motion.cost import costs, seconds, stroke_begins, stroke_seconds
from limner.motion.machine import CORNERS, MACHINES, Machine, load_machine
from limner.motion.pen import CHORD_MM, plan
from limner.motion.profile import profile
from limner.motion.route import route
from limner.types import Drawing, Page

SLACK = 1e-6
SHIPPED = {name: load_machine(name) for name in MACHINES}


@st.composite
def machines(draw):
    if draw(st.booleans()):
        return SHIPPED[draw(st.sampled_from(MACHINES))]
    positive = st.floats(1, 2000)
    return Machine(
        draw_mm_s=draw(positive),
        draw_mm_s2=draw(positive),
        travel_mm_s=draw(positive),
        travel_mm_s2=draw(positive),
        corner=draw(st.sampled_from(CORNERS)),
        corner_mm=draw(st.floats(1e-3, 1)),
        pen_down_s=draw(st.floats(0.01, 1)),
        pen_up_s=draw(st.floats(0.01, 1)),
        home=draw(st.sampled_from(["lower-left", "upper-left"])),
        point_s=draw(st.sampled_from([0.0, 0.0, 0.5])),
    )


def drawn(path):
    """The lines that the path inks, by stroke."""
    lines = {}
    for k in np.flatnonzero(path.down):
        lines.setdefault(int(path.stroke[k]), [path.position_mm[k - 1, :2]]).append(path.position_mm[k, :2])
    return {i: np.array(line) for i, line in lines.items()}


@given(drawings(), machines())
def test_limits_hold_everywhere(drawing, machine):
    path = plan(drawing, machine)
    dt = np.diff(path.t_s)
    step = np.diff(path.position_mm, axis=0)
    way = np.hypot(step[:, 0], step[:, 1])
    moving = dt > 0
    assert np.abs(step[~moving]).max(initial=0) < 1e-9, "nothing jumps"
    limit = np.where(path.down[1:], machine.draw_mm_s, machine.travel_mm_s)
    speed = np.divide(way, dt, out=np.zeros_like(way), where=moving)
    assert (speed <= limit * (1 + SLACK) + SLACK).all()
    # Mean speeds of two phases in one straight move differ by at most the acceleration times the time between them.
    straight = moving[1:] & moving[:-1] & (path.stroke[2:] == path.stroke[1:-1]) & (path.down[2:] == path.down[1:-1])
    unit = step[:, :2] / np.maximum(way, 1e-12)[:, None]
    straight &= ((unit[1:] * unit[:-1]).sum(axis=1) > 1 - 1e-9) & (way[1:] > 1e-6) & (way[:-1] > 1e-6)
    acceleration = np.where(path.down[2:], machine.draw_mm_s2, machine.travel_mm_s2)
    change = np.abs(np.diff(speed)) - acceleration * (dt[1:] + dt[:-1]) / 2
    noise = 1e-9 * 200 / np.maximum(np.minimum(dt[1:], dt[:-1]), 1e-12)  # of positions, over a short time
    assert (change <= acceleration * 1e-6 + noise + 1e-6)[straight].all()


@given(drawings(least=1), machines())
def test_corners_are_passed_no_faster_than_their_rule_allows(drawing, machine):
    home = machine.home_mm(drawing.page)
    moves = route(drawing, home, home)
    fast = profile(moves, machine)
    along = np.diff(moves.vertices_mm, axis=0)
    for k in range(len(along) - 1):
        assert fast.end_mm_s[k] == pytest.approx(fast.start_mm_s[k + 1], abs=1e-9) or machine.point_s
        if not (moves.draws[k] and moves.draws[k + 1] and along[k].any() and along[k + 1].any()):
            assert fast.end_mm_s[k] == 0, "at rest where the pen goes up or down, and at dots"
            continue
        one, two = along[k], along[k + 1]
        turn = np.abs((np.arctan2(two[1], two[0]) - np.arctan2(one[1], one[0]) + np.pi) % (2 * np.pi) - np.pi)
        reach = (np.hypot(*one) + np.hypot(*two)) / 2
        allowed = machine.corner_speeds(np.array([turn]), np.array([reach]))[0]
        assert fast.end_mm_s[k] <= allowed * (1 + 1e-6) + 1e-6
    acceleration = np.where(moves.draws, machine.draw_mm_s2, machine.travel_mm_s2)
    change = np.abs(fast.end_mm_s**2 - fast.start_mm_s**2)
    assert (change <= 2 * acceleration * fast.length_mm * (1 + 1e-9) + 1e-6).all(), "no corner comes too soon"


@given(drawings(least=1), machines())
def test_the_pen_draws_every_stroke_once_and_nothing_else(drawing, machine):
    path = plan(drawing, machine)
    lines = drawn(path)
    assert sorted(lines) == list(range(len(drawing.lines_mm)))
    assert (np.diff(path.stroke[path.down]) >= 0).all()
    for i, line in enumerate(drawing.lines_mm):
        assert geometry.length(lines[i]) == pytest.approx(geometry.length(line), abs=1e-6)
        for vertex in line:
            assert np.hypot(*(lines[i] - vertex).T).min() < 1e-9
        assert np.allclose(lines[i][[0, -1]], line[[0, -1]], atol=1e-9)
    height = path.position_mm[:, 2]
    assert (height[path.down] == 0).all()
    sideways = np.hypot(*np.diff(path.position_mm[:, :2], axis=0).T) > 0
    assert (height[1:][sideways & ~path.down[1:]] == machine.lift_mm).all(), "never sideways half lowered"


@given(drawings(), machines())
def test_it_goes_from_home_to_home_raised(drawing, machine):
    path = plan(drawing, machine)
    for end in (0, -1):
        assert np.allclose(path.position_mm[end], [*machine.home_mm(drawing.page), machine.lift_mm])
        assert not path.down[end]


@given(drawings(), machines())
def test_costs_are_those_of_the_path(drawing, machine):
    got, path = costs(drawing, machine), plan(drawing, machine)
    assert got.seconds == pytest.approx(path.t_s[-1], abs=1e-6)
    assert got.draw_s + got.travel_s + got.lift_s == pytest.approx(got.seconds)
    assert got.draw_s == pytest.approx(stroke_seconds(drawing, machine).sum())
    begins = stroke_begins(drawing, machine)
    assert len(begins) == len(drawing.lines_mm)
    for stroke, begin in enumerate(begins):
        first = np.flatnonzero(path.stroke == stroke)[0]
        assert begin == pytest.approx(path.t_s[first - 1], abs=1e-6)
    if machine.home == "lower-left":
        want = measure(drawing)
        assert got.travel_mm == pytest.approx(want.travel_mm, abs=1e-6)
        assert got.ink_mm == pytest.approx(want.ink_mm, abs=1e-6)
        assert (got.lifts, got.strokes, got.points) == (want.lifts, want.strokes, want.points)


@given(drawings(least=1), machines(), st.floats(1, 3))
def test_time_is_monotone_in_every_limit(drawing, machine, factor):
    before = seconds(drawing, machine)
    for name in ("draw_mm_s", "draw_mm_s2", "travel_mm_s", "travel_mm_s2"):
        quicker = dataclasses.replace(machine, **{name: getattr(machine, name) * factor})
        assert seconds(drawing, quicker) <= before + 1e-6, name
    rounder = dataclasses.replace(machine, corner_mm=min(10, machine.corner_mm * factor))
    assert seconds(drawing, rounder) <= before + 1e-6
    assert seconds(drawing, dataclasses.replace(machine, corner="stop")) >= before - 1e-6
    for name in ("pen_down_s", "pen_up_s"):
        assert (
            seconds(drawing, dataclasses.replace(machine, **{name: getattr(machine, name) * factor})) >= before - 1e-9
        )


def simple(**changes):
    return Machine(**{
        "draw_mm_s": 10.0, "draw_mm_s2": 20.0, "travel_mm_s": 50.0, "travel_mm_s2": 100.0,
        "pen_down_s": 1.0, "pen_up_s": 2.0, **changes,
    })  # fmt: skip


def test_by_hand():
    # 50 mm of travel: 0.5 s up to 50 mm/s over 12.5 mm, 25 mm in 0.5 s, 0.5 s down. 15 mm of ink: 0.5 + 1 + 0.5 s.
    drawing = of([[30, 40], [39, 52]])
    got = costs(drawing, simple())
    assert got.draw_s == pytest.approx(2.0)
    assert got.lift_s == pytest.approx(3.0)
    back = np.hypot(39, 52)
    assert got.travel_s == pytest.approx((50 / 50 + 0.5) + (back / 50 + 0.5))
    path = plan(drawing, simple())
    begins = 1.5 + 1.0
    assert np.allclose(path.at(begins + 0.5), [31.5, 42, 0], atol=CHORD_MM)
    assert np.allclose(path.at(begins + 1.0), [34.5, 46, 0], atol=CHORD_MM)


def test_a_short_move_never_reaches_full_speed():
    # 0.8 mm at 20 mm/s2: up to sqrt(16) = 4 mm/s, 0.2 s up and 0.2 s down.
    assert stroke_seconds(of([[0, 0], [0.8, 0]]), simple())[0] == pytest.approx(0.4)


def test_a_straight_line_is_no_slower_for_its_vertices():
    whole = of([[10, 10], [110, 60]])
    cut = of(np.linspace([10, 10], [110, 60], 300))
    for name in ("axidraw", "grbl", "brachiograph"):
        machine = load_machine(name)
        assert seconds(cut, machine) == pytest.approx(seconds(whole, machine))


def test_looking_ahead_brakes_over_many_short_moves_in_time():
    # At the end of 100 short moves stands a reversal, where it must halt: as one line of that length there and back.
    there = np.linspace([0, 0], [50, 0], 101)
    machine = simple()
    got = stroke_seconds(of(np.concatenate([there, there[-2::-1]])), machine)[0]
    assert got == pytest.approx(2 * (50 / 10 + 0.5))


def test_a_circle_is_drawn_as_fast_as_its_curvature_allows():
    # sqrt(a r) = sqrt(20 x 2) = 6.3 mm/s around a circle of 2 mm radius, however finely it is cut.
    machine = simple(corner="arc", corner_mm=10.0)
    for pieces in (100, 1000, 10_000):
        angle = np.linspace(0, 2 * np.pi, pieces + 1)
        circle = of(50 + 2 * np.stack([np.cos(angle), np.sin(angle)], axis=1))
        cruise = 4 * np.pi / np.sqrt(40)
        assert cruise < stroke_seconds(circle, machine)[0] < cruise + 0.4
    fine = dataclasses.replace(machine, corner="deviation")
    assert stroke_seconds(circle, fine)[0] < cruise, "the rule of GRBL alone does not see it"


def test_a_right_angle_is_passed_at_the_speed_of_the_junction_deviation():
    # s = cos 45 deg; v2 = a d s / (1 - s).
    machine = simple(corner="deviation", corner_mm=0.5)
    half = np.sqrt(0.5)
    want = np.sqrt(20 * 0.5 * half / (1 - half))
    assert machine.corner_speeds(np.array([np.pi / 2]))[0] == pytest.approx(want)
    path = plan(of([[10, 10], [60, 10], [60, 60]]), machine)
    at = np.flatnonzero((path.position_mm == [60, 10, 0]).all(axis=1))[0]
    took = np.diff(path.t_s[at - 1 : at + 2])
    mean = np.hypot(*np.diff(path.position_mm[at - 1 : at + 2, :2], axis=0).T) / took
    assert np.allclose(mean - 20 * took / 2, want)


def test_strokes_that_meet_are_drawn_without_a_lift():
    apart, together = of([[10, 10], [20, 10]], [[20, 10], [30, 10]]), of([[10, 10], [20, 10], [30, 10]])
    for name in MACHINES:
        assert seconds(apart, load_machine(name)) == pytest.approx(seconds(together, load_machine(name)))


def test_the_thesis_needs_a_second_and_a_half_for_each_point():
    dumbo = load_machine("dumbo")
    line = np.cumsum(np.tile([[0.3, 0.1]], (600, 1)), axis=0)
    got = costs(of(line), dumbo)
    assert got.draw_s == pytest.approx(599 * 1.5)
    assert got.travel_s - 1.5 < 10  # to the first point, and home from the last


def test_the_linear_estimate_is_near():
    rng = np.random.default_rng(0)
    steps = rng.normal(0, 1, (90, 1, 2)) + rng.normal(0, 0.4, (90, 12, 2))
    drawing = of(*(rng.uniform(20, 120, (90, 1, 2)) + np.cumsum(steps, axis=1)))
    for name in MACHINES:
        machine = load_machine(name)
        model, count = machine.cost_model(), measure(drawing)
        estimate = (
            model.stroke_s * count.strokes
            + model.point_s * count.points
            + model.ink_s_per_mm * count.ink_mm
            + model.travel_s_per_mm * count.travel_mm
        )
        assert estimate == pytest.approx(seconds(drawing, machine), rel=0.35), name


def test_nothing_dots_and_repeats():
    machine = simple()
    empty = plan(of(), machine)
    assert len(empty.t_s) == 1
    assert seconds(of(), machine) == 0
    dot = plan(of([[5, 5]], [[5, 5], [5, 5]], [[9, 9]]), machine)
    assert set(dot.stroke[dot.down]) == {0, 1, 2}
    assert costs(of([[5, 5], [5, 5]]), machine).ink_mm == 0


def test_part_of_a_drawing_from_anywhere_to_anywhere():
    path = plan(of([[10, 10], [20, 10]]), simple(), start_mm=np.array([10.0, 20]), end_mm=None)
    assert np.allclose(path.position_mm[[0, -1]], [[10, 20, 5], [20, 10, 5]])


@pytest.mark.slow
def test_two_hundred_thousand_strokes():
    rng = np.random.default_rng(0)
    lines = rng.uniform(10, 130, (200_000, 1, 2)) + np.array([[0, 0], [1, 1]])
    drawing = Drawing(tuple(lines), ("face",) * 200_000, np.ones(200_000), Page(), of().pens)
    assert plan(drawing, load_machine("axidraw")).t_s[-1] == pytest.approx(seconds(drawing, load_machine("axidraw")))


@pytest.mark.parametrize("name", MACHINES)
def test_every_machine_is_described_whole(name):
    machine = load_machine(name)
    assert machine.name == name
    assert machine != dataclasses.replace(Machine(), name=name)


def test_a_machine_of_ones_own(tmp_path):
    (tmp_path / "mine.toml").write_text("name = 'mine'\ndraw_mm_s = 12\n")
    machine = load_machine(str(tmp_path / "mine.toml"))
    assert (machine.draw_mm_s, machine.travel_mm_s) == (12, Machine().travel_mm_s)
    for text, words in [
        ("draw_mm_s = 0", "draw_mm_s"),
        ("speed = 3", "speed"),
        ("corner = 'fast'", "stop"),
        ("draw_mm_s = nan", "draw_mm_s"),
        ("=", "not TOML"),
    ]:
        (tmp_path / "bad.toml").write_text(text)
        with pytest.raises(BadInput, match=words) as caught:
            load_machine(str(tmp_path / "bad.toml"))
        assert "bad.toml" in str(caught.value)
    for name in ("axydraw", str(tmp_path / "none.toml"), ""):
        with pytest.raises(BadInput):
            load_machine(name)


def test_what_does_not_fit_is_told_with_the_scale_that_does():
    brachiograph = load_machine("brachiograph")  # 120 x 80 mm
    check_area(of([[0, 0], [120, 80]]), brachiograph)
    with pytest.raises(CannotDraw, match=r"work area of brachiograph, 120 x 80 mm by 20 mm.*scale it by 0\.8 and move"):
        check_area(of([[10, 0], [130, 100]]), brachiograph)
    with pytest.raises(CannotDraw, match=r"the page of 148 x 210 mm by 2 mm.*moved"):
        check_area(of([[-2, 0], [100, 80]]), brachiograph)
    with pytest.raises(CannotDraw, match=r"the page of 148 x 210 mm by 148 mm.*scale it by 0\.5"):
        check_area(of([[0, 0], [296, 100]]), load_machine("axidraw"))
    with pytest.raises(NothingToDraw):
        check_area(of(), brachiograph)


def test_a_page_taller_than_the_area_is_measured_from_its_home_corner():
    tall = Drawing((np.array([[0, 250], [10, 290.0]]),), ("face",), [1.0], Page(210, 297), of().pens)
    check_area(tall, load_machine("axidraw"))
    with pytest.raises(CannotDraw):
        check_area(tall, dataclasses.replace(load_machine("axidraw"), home="lower-left"))
