"""What a machine is sent: the drawing, each segment once, whatever stops it and whatever breaks."""

from __future__ import annotations

import contextlib
import itertools
import re
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from drawings import drawings, of
from limner import geometry
from limner.errors import BadInput, DeviceFailed
from limner.motion.machine import load_machine
from limner.motion.pen import plan
from limner.targets.ebb import Ebb, EbbSettings, Limits
from limner.targets.fake import FAULTS, FakeLink, Fault
from limner.targets.fake_grbl import FakeGrbl
from limner.targets.gcode import GcodeSettings
from limner.targets.grbl_words import ALARMS, ERRORS, explained
from limner.targets.journal import Journal, Place
from limner.targets.send import Control, send
from plotters import SILENCE_S, counted, ebb, grbl, inked

DRAWING = of(
    [[10, 10], [20, 10], [30, 15]],
    [[30, 15], [30, 20]],
    [[50, 50]],
    [[60, 60], [70, 70], [60, 60]],
    np.stack([np.linspace(20, 120, 60), 100 + 5 * np.sin(np.arange(60))], axis=1),
)
MACHINES = {"servo": grbl, "z": lambda **k: grbl(pen="z", **k), "ebb": ebb}


@pytest.fixture
def path(tmp_path):
    return tmp_path / "journal"


class StopAfter(Control):
    """Stops when it has been asked so often whether to go on."""

    def __init__(self, asked):
        super().__init__()
        self._left = asked

    def going_on(self):
        self._left -= 1
        self.stop = self.stop or self._left < 0
        return super().going_on()


class Witness(Journal):
    """A journal that looks at the paper whenever it is written."""

    def watch(self, fake, drawing):
        self.fake, self.drawing = fake, drawing
        return self

    def begin(self, place):
        super().begin(place)
        self.look()

    def reached(self, place):
        super().reached(place)
        self.look()

    def look(self):
        lines = [geometry.without_repeats(line) for line in self.drawing.lines_mm]
        before = lines[: self.place.stroke]
        if self.place.vertex:
            before.append(lines[self.place.stroke][: self.place.vertex + 1])
        assert segments_only(inked(self.fake)) == segments_only(counted(before))
        assert not self.fake.pen_down


def segments_only(counts):
    return {segment: n for segment, n in counts.items() if segment[0] != segment[1]}


def run(drawing, target, path, control=None, resume=False):
    journal = Journal(path, drawing, resume=resume)
    try:
        return send(drawing, target, journal, control or Control(), lambda *_: None)
    finally:
        journal.close()


def no_more_than_a_step_off(fake, drawing):
    """The ink of an AxiDraw, whose moves are cut into slices, lies on the drawing, and all of it is there."""
    ink = np.array([segment for segment in fake.ink if segment[0] != segment[1]]).reshape(-1, 2, 2)
    total = np.hypot(*(ink[:, 1] - ink[:, 0]).T).sum()
    assert total == pytest.approx(geometry.total_length(drawing.lines_mm), rel=0.01, abs=0.05)
    every = np.array(fake.ink).reshape(-1, 2, 2)
    for vertex in np.concatenate(drawing.lines_mm):
        assert geometry.distance_to_segments(np.tile(vertex, (len(every), 1)), every[:, 0], every[:, 1]).min() < 0.05
    points = every.reshape(-1, 2)
    ends = [(line[i], line[i + 1]) for line in drawing.lines_mm for i in range(max(len(line) - 1, 0))]
    ends += [(line[0], line[0]) for line in drawing.lines_mm if len(line) == 1]
    distance = np.min([geometry.distance_to_segments(points, a, b) for a, b in ends], axis=0)
    assert distance.max() < 0.05


@pytest.mark.parametrize("pen", ["servo", "z"])
@given(drawing=drawings(least=1))
@settings(max_examples=40)
def test_grbl_draws_each_segment_once(tmp_path_factory, pen, drawing):
    path = tmp_path_factory.mktemp("j") / "j"
    fake, target = grbl(pen)
    journal = Witness(path, drawing, resume=False).watch(fake, drawing)
    send(drawing, target, journal, Control(), lambda *_: None)
    assert fake.breaches == []
    assert segments_only(inked(fake)) == segments_only(counted(drawing.lines_mm))
    touched = {point for segment in inked(fake) for point in segment}
    assert all(point in touched for segment in counted(drawing.lines_mm) for point in segment)
    assert fake.place == (0, 0)
    assert not fake.pen_down


def test_the_buffer_is_filled_but_never_overrun(path):
    fake, target = grbl()
    run(DRAWING, target, path)
    assert 100 < fake.fullest <= 127
    assert fake.breaches == []


def test_an_axidraw_draws_the_drawing_in_the_planned_time(path):
    fake, target = ebb()
    run(DRAWING, target, path)
    assert fake.breaches == []
    no_more_than_a_step_off(fake, DRAWING)
    planned = plan(DRAWING, load_machine("axidraw")).t_s[-1]
    assert fake.milliseconds / 1000 == pytest.approx(planned + 0.5, rel=0.02)  # 0.5 s to raise the pen at first
    assert fake.steps == (0, 0)


@given(drawings(least=1, most=5))
@settings(max_examples=15)
def test_any_drawing_on_an_axidraw(tmp_path_factory, drawing):
    fake, target = ebb(page=drawing.page)
    run(drawing, target, tmp_path_factory.mktemp("j") / "j")
    assert fake.breaches == []
    no_more_than_a_step_off(fake, drawing)


@given(drawings(least=1), st.integers(0, 30), st.sampled_from(["servo", "z"]))
@settings(max_examples=60)
def test_stopped_anywhere_and_gone_on_it_draws_each_segment_once(tmp_path_factory, drawing, asked, pen):
    path = tmp_path_factory.mktemp("j") / "j"
    fake, target = grbl(pen)
    place = run(drawing, target, path, StopAfter(asked))
    assert not fake.pen_down
    assert fake.place == (0, 0)
    times = 0
    while place.stroke < len(drawing.lines_mm):
        times += 1
        if path.exists():
            _, target = again(fake)
            place = run(drawing, target, path, StopAfter(asked + times), resume=True)
        else:
            assert not inked(fake) - counted([[line[0]] for line in drawing.lines_mm])
            place = run(drawing, again(fake)[1], path)
    assert fake.breaches == []
    assert segments_only(inked(fake)) == segments_only(counted(drawing.lines_mm))


@pytest.mark.parametrize("asked", [0, 1, 30, 90, 150, 200, 250])
def test_an_axidraw_stops_within_a_line_slowing_down_as_planned(path, asked):
    fake, target = ebb()
    place = run(DRAWING, target, path, StopAfter(asked))
    assert not fake.pen_down
    if asked == 200:
        assert place.vertex > 0, "the last line is long"
    lines = [geometry.without_repeats(line) for line in DRAWING.lines_mm]
    drawn = lines[: place.stroke] + ([lines[place.stroke][: place.vertex + 1]] if place.vertex else [])
    if drawn:
        no_more_than_a_step_off(fake, of(*drawn))
    while place.stroke < len(lines):
        target = ebb()[1]
        target._link.fake = fake
        place = run(DRAWING, target, path, StopAfter(asked + 40), resume=path.exists())
    no_more_than_a_step_off(fake, DRAWING)
    assert fake.breaches == []


def test_an_axidraw_changes_speed_no_faster_than_planned(path):
    """Also where it is stopped: speeds of slices one after the other, as the motors see them."""
    for asked in (60, 200, 10_000):
        fake, target = ebb()
        path.unlink(missing_ok=True)
        run(DRAWING, target, path, StopAfter(asked))
        machine = load_machine("axidraw")
        slices = [(ms, a / 80, b / 80) for ms, a, b in fake.slices]
        speeds = [(ms, np.hypot((a + b) / 2, (a - b) / 2) / ms * 1000) for ms, a, b in slices]
        steepest = max(machine.travel_mm_s2, machine.draw_mm_s2)
        for (one_ms, one), (two_ms, two) in itertools.pairwise(speeds):
            # A step more or less and half a millisecond are what whole numbers leave.
            slack = 2 / 80 / min(one_ms, two_ms) * 1000 + 0.1 * max(one, two) + 8
            assert abs(one - two) <= steepest * (one_ms + two_ms) / 2000 + slack


def again(fake):
    """Another driver on the same machine."""
    other, target = grbl(fake.pen)
    target._link.fake = fake
    return other, target


def test_a_pause_raises_the_pen_and_goes_on(path):
    fake, target = grbl()
    control, seen = StopAfter(10_000), []
    asked = iter(range(10_000))

    def going_on():
        control.pause = control.pause or next(asked) == 30
        return not control.pause

    control.going_on = going_on

    def watch(place, waits):
        seen.append((place, waits, fake.pen_down))
        control.pause = False if waits else control.pause

    journal = Witness(path, DRAWING, resume=False).watch(fake, DRAWING)
    send(DRAWING, target, journal, control, watch)
    waited = [entry for entry in seen if entry[1]]
    assert len(waited) == 1
    assert waited[0][0].vertex > 0, "within a stroke"
    assert not any(down for _, _, down in seen)
    assert segments_only(inked(fake)) == segments_only(counted(DRAWING.lines_mm))


SMALL = of([[10, 190], [12, 190], [13, 189]], [[15, 190]], [[16, 190], [17, 191]])


def length_of(name):
    """Lines that a machine reads for the small drawing."""
    fake, target = MACHINES[name]()
    with contextlib.suppress(DeviceFailed):
        target.open()
        for line in SMALL.lines_mm:
            target.draw(line, lambda: True)
        target.home()
    return fake.lines


def faulty_lines(name):
    """All, but of an AxiDraw's many slices of motion only some, beside all that are something else."""
    count = length_of(name)
    return range(count) if name != "ebb" else [*range(14), *range(14, count, 11), *range(count - 4, count)]


@pytest.mark.parametrize("kind", FAULTS)
@pytest.mark.parametrize("name", MACHINES)
def test_a_fault_at_any_line_is_told_and_gone_on_from(tmp_path, name, kind):
    for line in faulty_lines(name):
        path = tmp_path / f"{line}"
        fake, target = MACHINES[name](fault=Fault(kind, line))
        with pytest.raises(DeviceFailed) as caught:
            run(SMALL, target, path)
        message = str(caught.value)
        assert "\n" not in message
        if "the pen is up" in message:
            assert not fake.pen_down, f"line {line}: {message}"
        else:
            assert "pen state unknown" in message
        assert [breach for breach in fake.breaches if "overrun" in breach or "goes down" in breach] == []
        place = Place(0)
        if path.exists():
            journal = Journal(path, SMALL, resume=True)
            place, doubtful = journal.place, journal.doubtful
            assert ("draws that one again" in message) == doubtful
            journal.close()
        # What the journal calls drawn is on the paper, once.
        before = counted(SMALL.lines_mm[: place.stroke])
        if name != "ebb":
            assert all(inked(fake)[segment] == n for segment, n in before.items())
        fresh, target = MACHINES[name]()
        run(SMALL, target, path, resume=path.exists())
        if name == "ebb":
            no_more_than_a_step_off(fresh, of(*SMALL.lines_mm[place.stroke :]))
        else:
            assert inked(fresh) == counted(SMALL.lines_mm[place.stroke :]), "what is not drawn, and no more"


def test_a_machine_that_recovers_has_its_pen_raised(path):
    for pen in ("servo", "z"):
        for kind in ("garbage", "error"):
            fake, target = grbl(pen, fault=Fault(kind, 12))
            with pytest.raises(DeviceFailed, match="the pen is up"):
                run(SMALL, target, path)
            assert not fake.pen_down


def test_an_alarm_is_named(path):
    fake, target = grbl(limit_mm=(-1, -1, 12.5, 250))
    with pytest.raises(DeviceFailed, match=r"alarm 2: a move would leave the machine's travel.*the pen is up"):
        run(SMALL, target, path)
    fake, target = grbl(locked=True)
    with pytest.raises(DeviceFailed, match=r"locked by an alarm; home it"):
        run(SMALL, target, path)
    assert fake.ink == []


def test_laser_mode_is_named(path):
    fake, target = grbl(laser=True)
    with pytest.raises(DeviceFailed, match=r"laser mode.*\$32=0"):
        run(SMALL, target, path)
    assert fake.ink == []
    run(SMALL, grbl("z", laser=True)[1], path)


def test_errors_and_alarms_are_named():
    assert explained("error:22") == f"error 22: {ERRORS[22]}"
    assert explained("ALARM:1") == f"alarm 1: {ALARMS[1]}"
    for odd in ("error:99", "error:", "ALARM:x"):
        assert "unknown to limner" in explained(odd)


def test_another_machine_at_the_port_is_named(path):
    fake, _ = ebb()
    target = grbl()[1]
    target._link.fake = fake
    with pytest.raises(DeviceFailed, match="no GRBL answers"):
        run(SMALL, target, path)
    board, _ = grbl()
    target = ebb()[1]
    target._link.fake = board
    with pytest.raises(DeviceFailed, match="EBB"):
        run(SMALL, target, path)
    assert not path.exists()


def test_an_axidraw_without_power_is_named(path):
    fake, target = ebb(powered=False)
    with pytest.raises(DeviceFailed, match="no power"):
        run(SMALL, target, path)
    assert fake.ink == []


def test_an_axidraw_moved_by_hand_is_noticed(path):
    fake, target = ebb()
    taken = fake._moves

    def slip(milliseconds, one, two):
        taken(milliseconds, one, two - (fake.lines == 40))

    fake._moves = slip
    with pytest.raises(DeviceFailed, match="stands at step"):
        run(DRAWING, target, path)


def test_a_board_is_not_asked_for_more_than_it_can():
    with pytest.raises(BadInput, match="at most"):
        Ebb(FakeLink(FakeGrbl()), lambda *_: None, EbbSettings(), (0, 0), Limits(500, 1))


def test_interrupted_at_once_the_pen_goes_up(path):
    for make in MACHINES.values():
        fake, target = make()
        journal = Journal(path, SMALL, resume=False)
        draw = target.draw

        def torn(line, going_on, draw=draw):
            draw(line, going_on)
            raise KeyboardInterrupt

        target.draw = torn
        with pytest.raises(KeyboardInterrupt):
            send(SMALL, target, journal, Control(), lambda *_: None)
        assert not fake.pen_down
        assert journal.doubtful
        journal.close()


def test_the_fakes_can_find_fault():
    fake = FakeGrbl()
    link = FakeLink(fake)
    link.write(b"G1 X1 Y1\n" * 20)
    assert any("overrun" in breach for breach in fake.breaches)
    fake = FakeGrbl()
    link = FakeLink(fake)
    link.write(b"M3 S700\nG0 X5 Y5\n")
    for _ in range(9):
        link.read(0)
    assert any("goes down before" in breach for breach in fake.breaches)
    assert any("G0 with the pen down" in breach for breach in fake.breaches)
    assert any("before modes" in breach for breach in fake.breaches)
    fake, _ = ebb()
    FakeLink(fake).write(b"SM,1,100,100\r")
    FakeLink(fake).read(0)
    assert len(fake.breaches) == 2


@pytest.mark.parametrize("name", MACHINES)
def test_a_process_that_sleeps_is_not_taken_for_a_machine_that_is_silent(path, monkeypatch, name):
    asleep = SimpleNamespace(monotonic=itertools.count(0.0, 100.0).__next__, sleep=lambda seconds: None)
    for module in ("grbl", "ebb", "link"):
        monkeypatch.setattr(f"limner.targets.{module}.time", asleep)
    fake, target = MACHINES[name]()
    assert run(DRAWING, target, path) == Place(len(DRAWING.lines_mm))
    assert fake.breaches == []


def test_silence_is_not_waited_for_longer_than_needed():
    assert SILENCE_S < 1
    assert re.fullmatch(r"GRBL at .*", grbl()[1].name)
    assert GcodeSettings().pen == "servo"
