"""Nothing reaches an arm that the checks have not passed: altered and hand-made motions, on every way to a device."""

import dataclasses
import functools
import json
import socket

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given, settings, strategies as st

from limner import storage
from limner.cli import jobs, limner
from limner.cli.studio import make
from limner.errors import BadInput, CannotDraw, LimnerError
from limner.motion.arm.lifted import LiftSettings
from limner.motion.arm.pen_check import SLACK_MM, USUAL, Allowed, check_motion, pen_limits
from limner.motion.arm.place import PlaceSettings
from limner.motion.arm.plan import ArmSettings, plan_arm
from limner.motion.arm.retime import RetimeSettings
from limner.motion.arm.robots import load_robot
from limner.pipeline import Settings
from limner.simulation.outcome import simulate
from limner.studio.orders import Order
from limner.targets import joints
from limner.targets.journal import Journal
from limner.targets.rosbridge import Rosbridge
from limner.targets.send import Control
from limner.targets.ur import Ur
from limner.types import Drawing, JointTrajectory, Page

pytest.importorskip("urdf_parser_py", reason="pip install 'limner[robot]'")
pytest.importorskip("toppra", reason="pip install 'limner[robot]'")
pytest.importorskip("mujoco", reason="pip install 'limner[robot]'")
pytest.importorskip("websockets", reason="pip install 'limner[ros]'")

ROBOT = load_robot("ur5e")
PLACE = "0.45,0,0"
PAGE = Page(40, 40, 5)
LINES = ([[10, 12], [28, 20], [22, 32]], [[30, 10], [30, 30]])


def planned(where=PLACE, lines=LINES, lift=None, **speeds):
    drawn = Drawing(tuple(np.array(line, float) for line in lines), ("face",) * len(lines), np.ones(len(lines)), PAGE)
    at = ArmSettings(place=PlaceSettings(at=where), retime=RetimeSettings(**speeds), lift=lift or LiftSettings())
    return plan_arm(drawn, ROBOT, at).trajectory


@functools.cache
def usual():
    return planned()


T = dataclasses.replace


def at_sample(name, change):
    """The same change of one sample, in the middle of a stroke."""
    values = getattr(usual(), name).copy()
    k = int(np.flatnonzero(usual().down)[len(np.flatnonzero(usual().down)) // 2])
    values[k] = change(values[k])
    return T(usual(), **{name: values})


def moved_sheet(x=0.0, y=0.0, z=0.0):
    return T(usual(), sheet_m=usual().sheet_m + np.array([x, y, z]))


def sunk():
    """In travel the pen stays in the sheet: its way from one stroke to the next is called travel, and nothing else."""
    whole = planned(lines=([[10, 12], [28, 20], [22, 32], [30, 30], [30, 10]],))
    drawn = np.flatnonzero(whole.down)
    down, stroke = whole.down.copy(), whole.stroke.copy()
    some = drawn[len(drawn) // 3 : 2 * len(drawn) // 3]
    down[some], stroke[some] = False, -1
    stroke[drawn[drawn > some[-1]]] = 1
    return T(whole, down=down, stroke=stroke)


ALTERED = {
    "position": (lambda: T(usual(), q=usual().q + 10), "goes to"),
    "position of a sample": (lambda: at_sample("q", lambda q: q + 0.01), "velocity|against its own velocities"),
    "velocity": (lambda: T(usual(), qd=usual().qd * 9), "velocity"),
    "velocity of a sample": (lambda: at_sample("qd", lambda v: v + 0.5), "jumps"),
    "acceleration": (lambda: at_sample("qdd", lambda a: a + 99), "acceleration"),
    "faster than planned": (lambda: T(usual(), t_s=usual().t_s / 9), "jumps|over its limit"),
    "in no time": (lambda: T(usual(), t_s=usual().t_s * 0), "velocity"),
    "pen speed": (lambda: planned(pen_speed=160.0, pen_acceleration=4000.0), "draws at"),
    "page": (lambda: moved_sheet(x=0.03), "off its page"),
    "page, other side": (lambda: moved_sheet(y=-0.03), "off its page"),
    "below the table": (lambda: moved_sheet(z=0.02), "tip goes"),
    "a table that is lower": (
        lambda: T(planned("0.45,0,-0.02"), sheet_m=usual().sheet_m),
        "tip goes",
    ),
    "above the table": (lambda: moved_sheet(z=-0.02), "above the sheet"),
    "upside down": (lambda: T(usual(), sheet_m=usual().sheet_m[::-1]), "sheet"),
    "no sheet": (lambda: T(usual(), sheet_m=np.zeros((4, 3))), "no rectangle"),
    "in travel in the sheet": (sunk, "in travel"),
    "other joints": (lambda: T(usual(), names=("a", "b", "c", "d", "e", "f")), "for the joints"),
    "fewer joints": (
        lambda: T(usual(), names=usual().names[:5], **{k: getattr(usual(), k)[:, :5] for k in ("q", "qd", "qdd")}),
        "for the joints",
    ),
    "a pen that is pressed hard": (
        lambda: T(usual(), sheet_m=np.zeros((0, 3)), press_mm=20.0),
        "tip goes",
    ),
}


def damaged(name, value):
    """Text of a motion that no JointTrajectory can be."""
    fields = storage.to_fields(usual())
    fields[name] = value(fields[name])
    return json.dumps(fields)


DAMAGED = {
    "NaN": lambda: damaged("q", lambda q: [[float("nan")] * 6, *q[1:]]),
    "infinity": lambda: damaged("qd", lambda q: [*q[:-1], [float("inf")] * 6]),
    "time that goes back": lambda: damaged("t_s", lambda t: t[::-1]),
    "NaN of a time": lambda: damaged("t_s", lambda t: [float("nan"), *t[1:]]),
    "NaN of the sheet": lambda: damaged("sheet_m", lambda s: [[float("nan")] * 3] * 4),
    "a sample less": lambda: damaged("q", lambda q: q[:-1]),
    "no samples": lambda: damaged("t_s", lambda t: []),
    "a negative press": lambda: damaged("press_mm", lambda p: -1),
}


class Ears:
    """A port at which a machine could be; whether anybody has spoken to it."""

    def __init__(self):
        self._server = socket.create_server(("127.0.0.1", 0))
        self._server.setblocking(False)
        self.port = self._server.getsockname()[1]

    def heard(self):
        try:
            self._server.accept()[0].close()
        except BlockingIOError:
            return False
        return True

    def close(self):
        self._server.close()


@pytest.fixture(scope="module")
def ears():
    made = Ears()
    yield made
    made.close()


def addresses(ears):
    """Every kind of arm that ``limner send`` and the studio lead."""
    return ("fake:", "sim:1000", f"ur:127.0.0.1:{ears.port}", f"rosbridge:ws://127.0.0.1:{ears.port}/arm/command")


def ways(file, ears):
    """Every way from a file to an arm, each a call that must refuse."""
    found = {f"send {to}": lambda to=to: jobs.arm(str(file), to, "ur5e", Settings()) for to in addresses(ears)}
    found |= {f"studio {to}": lambda to=to: make(Order(to, robot="ur5e"), str(file)) for to in addresses(ears)}
    return found | {"simulate": lambda: simulate(joints.load(file), ROBOT)}


def refused(file, ears, words):
    """Every way refuses, for the same reason, and nobody is spoken to."""
    said = set()
    for way, go in ways(file, ears).items():
        with pytest.raises((CannotDraw, BadInput), match=words) as error:
            go()
        assert "\n" not in str(error.value), way
        said.add(str(error.value))
    assert not ears.heard()
    assert len(said) == 1, said


@pytest.mark.parametrize("which", ALTERED)
def test_an_altered_motion_is_refused_on_every_way_and_nobody_is_spoken_to(tmp_path, ears, which):
    motion, words = ALTERED[which][0](), ALTERED[which][1]
    joints.save(motion, tmp_path / "motion.npz")
    refused(tmp_path / "motion.npz", ears, words)


@pytest.mark.parametrize("which", DAMAGED)
def test_a_damaged_file_is_refused_on_every_way_and_nobody_is_spoken_to(tmp_path, ears, which):
    (tmp_path / "motion.json").write_text(DAMAGED[which]())
    refused(tmp_path / "motion.json", ears, "expected")


@settings(max_examples=25)
@given(st.data())
def test_one_sample_altered_anywhere_is_refused_on_every_way(tmp_path_factory, ears, data):
    """By more than the limits let pass: a position, a velocity or an acceleration, of any joint, at any time."""
    name = data.draw(st.sampled_from(("q", "qd", "qdd")))
    k = data.draw(st.integers(1, len(usual().t_s) - 2))
    joint, sign = data.draw(st.integers(0, 5)), data.draw(st.sampled_from((-1, 1)))
    step = float(np.diff(usual().t_s[k - 1 : k + 2]).max())
    acceleration = ROBOT.acceleration[joint]
    least = {"q": 1.1 * acceleration * step**2, "qd": 2.1 * acceleration * step, "qdd": 2.1 * acceleration}[name]
    values = getattr(usual(), name).copy()
    values[k, joint] += sign * least * data.draw(st.floats(1, 100))
    file = tmp_path_factory.mktemp("altered") / "motion.npz"
    joints.save(T(usual(), **{name: values}), file)
    refused(file, ears, "trajectory: ")


@pytest.mark.parametrize("which", ["pen speed", "page", "below the table"])
def test_the_command_says_so_in_one_line_and_ends_with_4(tmp_path, ears, which):
    joints.save(ALTERED[which][0](), tmp_path / "motion.json")
    for to in addresses(ears):
        ran = CliRunner().invoke(
            limner, ["send", str(tmp_path / "motion.json"), "--to", to, "--robot", "ur5e", "--yes"]
        )
        assert ran.exit_code == 4 or isinstance(ran.exception, CannotDraw), ran.output
        assert not (tmp_path / "motion.json.journal").exists()
    assert not ears.heard()


def test_what_is_refused_would_have_been_sent(tmp_path, ears, monkeypatch):
    """The same motion, unaltered, passes every check, and machines are spoken to."""
    for driver in (Ur, Rosbridge):
        monkeypatch.setattr(jobs, driver.__name__, functools.partial(driver, silence_s=0.2))
    for suffix in joints.FORMATS:
        joints.save(usual(), tmp_path / f"motion{suffix}")
        check_motion(joints.load(tmp_path / f"motion{suffix}"), ROBOT)
    for to in addresses(ears)[2:]:
        job = jobs.arm(str(tmp_path / "motion.npz"), to, "ur5e", Settings())
        journal = Journal(tmp_path / "journal", job.drawing, resume=False)
        # Nobody answers there: it gives up as soon as it has been heard.
        with pytest.raises(LimnerError):
            job.run(journal, Control(stop=True), lambda place, waits: None)
        journal.close()
        assert ears.heard()


def test_what_a_pen_may_do_can_be_allowed():
    fast = ALTERED["pen speed"][0]()
    check_motion(fast, ROBOT, Allowed(160.0))
    with pytest.raises(CannotDraw, match="draws at"):
        check_motion(fast, ROBOT, Allowed(100.0))
    pressed = planned(lift=LiftSettings(press_mm=5.0))
    check_motion(pressed, ROBOT, Allowed(press_mm=5.0))
    with pytest.raises(CannotDraw, match="expected at most 3 mm"):
        check_motion(pressed, ROBOT)


@settings(max_examples=30)
@given(st.floats(-60, 60), st.floats(-60, 60), st.floats(-30, 30))
def test_a_sheet_elsewhere_is_refused_exactly_where_the_drawing_leaves_it(x, y, z):
    """The ink lies at least 10 mm inside of a sheet of 40 mm; its tip is led 3 mm below."""
    ink = np.concatenate([np.array(line, float) for line in LINES])
    seen = T(usual(), sheet_m=usual().sheet_m + np.array([x, y, z]) / 1000)
    beyond = np.maximum(-(ink - [x, y]), ink - [x, y] - 40).max()
    low, high = 3.0 + z, -3.0 - z
    wrong = beyond > SLACK_MM or low > 3.0 + SLACK_MM or high > SLACK_MM
    near = min(abs(beyond - SLACK_MM), abs(low - 3.0 - SLACK_MM), abs(high - SLACK_MM)) < 0.25
    if near:
        return
    try:
        check_motion(seen, ROBOT)
    except CannotDraw:
        assert wrong
    else:
        # A sheet that lies lower lets lifted ways touch it no more; one that lies higher may be met by them.
        assert not wrong


def test_a_motion_that_says_nothing_of_its_sheet_must_draw_in_a_plane():
    bare = T(usual(), sheet_m=np.zeros((0, 3)))
    check_motion(bare, ROBOT)
    assert pen_limits(bare, ROBOT, USUAL).size_mm is None
    never_down = T(bare, down=np.zeros(len(bare.t_s), bool), stroke=np.full(len(bare.t_s), -1))
    check_motion(never_down, ROBOT)
    askew = T(bare, down=np.ones(len(bare.t_s), bool))
    with pytest.raises(BadInput, match="off their plane"):
        check_motion(askew, ROBOT)


def test_files_of_before_sheets_were_kept_are_read():
    fields = storage.to_fields(usual())
    del fields["sheet_m"]
    assert not len(storage.from_fields(JointTrajectory, fields).sheet_m)
    with pytest.raises(BadInput, match="four corners"):
        storage.from_fields(JointTrajectory, fields | {"sheet_m": [[0, 0, 0]]})


def test_a_drawing_that_leaves_its_page_is_not_planned():
    with pytest.raises(CannotDraw, match="off its page"):
        planned(lines=([[10, 10], [47, 10]],))


def svg(lines, page="148mm 210mm 148 210"):
    width, height, w, h = page.split()
    paths = "".join(f'<path d="{line}"/>' for line in lines)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {w} {h}">{paths}</svg>'
    )


BEYOND = {
    "larger than the machine": ("big.svg", svg(["M0 0L900 900"], "1000mm 1000mm 1000 1000"), CannotDraw),
    "off its page": ("off.svg", svg(["M10 10L200 10"]), CannotDraw),
    "G-code beyond the machine": ("far.gcode", "G21\nG90\nM3 S40\nG1 X900 Y900 F1000\nM3 S90\n", LimnerError),
    "HP-GL beyond the machine": ("far.hpgl", "IN;SP1;PU0,0;PD32000,32000;PU;", CannotDraw),
    "JSON with NaN": ("nan.json", None, BadInput),
}


@pytest.mark.parametrize("which", BEYOND)
def test_a_drawing_beyond_the_machine_reaches_no_plotter(tmp_path, monkeypatch, which):
    """By ``limner send`` and by the studio, to each kind of plotter."""
    name, text, error = BEYOND[which]
    if text is None:
        fields = storage.to_fields(Drawing((np.zeros((2, 2)),), ("face",), np.ones(1)))
        text = json.dumps(fields | {"lines_mm": [[[0.0, 0.0], [float("nan"), 1.0]]]})
    (tmp_path / name).write_text(text)
    opened = []
    monkeypatch.setattr("limner.targets.connect.SerialLink", lambda *_: opened.append(1))
    for to in ("grbl:/dev/null", "ebb:/dev/null", "fake:", "fake:ebb", "sim:"):
        with pytest.raises(error):
            jobs.plotter(str(tmp_path / name), to, None, False, 115_200, Settings())
        with pytest.raises(error):
            make(Order(to), str(tmp_path / name))
    assert not opened


def test_the_page_of_a_motion_from_a_table_is_checked_too(tmp_path, ears):
    joints.save(moved_sheet(x=0.03), tmp_path / "motion.csv")
    refused(tmp_path / "motion.csv", ears, "off its page")
