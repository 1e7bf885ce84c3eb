"""``limner send`` as a stranger uses it: asked, paused, stopped, killed, gone on with."""

from __future__ import annotations

import functools
import json
import os
import pty
import select
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

import limner
from drawings import of
from limner.targets.fake import Fault
from limner.targets.fake_grbl import FakeGrbl
from limner.targets.journal import unfinished
from plotters import Served, counted, inked
from processes import PATIENCE_S, begun, until

LONG = of(*[[[10 + 5 * k, 10], [10 + 5 * k, 50], [12 + 5 * k, 50]] for k in range(12)], [[20, 100], [21, 101]])


@pytest.fixture
def run(command, tmp_path):
    (tmp_path / "d.svg").write_bytes(limner.to_svg(LONG))
    return functools.partial(command, "send")


@pytest.mark.parametrize("to", ["fake:", "fake:grbl", "fake:ebb"])
def test_a_fake_draws(run, tmp_path, to):
    code, out, err = run("d.svg", "--to", to, "--yes", "--json")
    assert (code, err) == (0, "")
    assert json.loads(out) == {"strokes": 13, "began": 0, "drawn": 13, "finished": True, "journal": None}
    code, out, err = run("d.svg", "--to", to, "--yes")
    assert (code, out, err) == (0, "", "drawn: 13 strokes\n")
    assert [path.name for path in tmp_path.iterdir()] == ["d.svg"], "no journal is left of a finished drawing"


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (["d.svg"], 2, ["--to"]),
        (["d.svg", "--to", "lpt1"], 2, ["lpt1", "grbl:PORT"]),
        (["d.svg", "--to", "fake:"], 2, ["--yes"]),
        (["none.svg", "--to", "fake:", "--yes"], 2, ["none.svg"]),
        (["d.svg", "--to", "fake:", "--yes", "-m", "brachiograph"], 4, ["brachiograph", "scale it by 0.879"]),
        (["big.svg", "--to", "fake:", "--yes"], 4, ["work area of grbl", "by 98 mm", "scale it by 0.757"]),
        (["big.svg", "--to", "fake:", "--yes", "--fit"], 0, []),
        (["empty.svg", "--to", "fake:", "--yes"], 4, ["no strokes"]),
        (["d.svg", "--to", "fake:", "--yes", "--resume"], 2, ["nothing to resume", "d.svg.journal"]),
        (["d.svg", "--to", "fake:", "--yes", "--resume", "--from", "2"], 2, ["--resume", "--from"]),
        (["d.svg", "--to", "fake:", "--yes", "--from", "14"], 2, ["--from 14", "13 strokes"]),
        (["d.svg", "--to", "fake:", "--yes", "--from", "13"], 0, []),
        (["d.svg", "--to", "fake:", "--yes", "--journal", "no/such/j"], 2, ["journal", "cannot be written"]),
        (["d.svg", "--to", "grbl:/dev/ttyUSB99", "--yes"], 5, ["/dev/ttyUSB99", "no such port"]),
        (["d.svg", "--to", "fake:", "--yes", "--set", "gcode.pen=laser"], 2, ["gcode.pen", "servo"]),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_mistakes_are_named_in_one_line_and_nothing_moves(run, tmp_path, arguments, code, words):
    (tmp_path / "empty.svg").write_bytes(limner.to_svg(of()))
    big = limner.Drawing((np.array([[2, 2], [398, 20]]),), ("face",), [1.0], limner.Page(400, 400))
    (tmp_path / "big.svg").write_bytes(limner.to_svg(big))
    before = sorted(tmp_path.iterdir())
    got, _, err = run(*arguments)
    assert got == code, err
    (line,) = err.strip().splitlines()
    for word in words:
        assert word.lower() in line.lower()
    assert sorted(tmp_path.iterdir()) == before


def command(*arguments):
    return [sys.executable, "-m", "limner", "send", *map(str, arguments)]


SLOW_S = 0.15
"""What a plotter takes for each thing it does once it is told to stop: it is not done before that is heard."""


@pytest.fixture
def plotter():
    """A fake that takes its time, at a port."""
    with Served(FakeGrbl(), step_s=0.02) as served:
        yield served


@pytest.mark.parametrize("which", [signal.SIGINT, signal.SIGTERM])
def test_ctrl_c_stops_with_the_pen_up_and_resume_goes_on(tmp_path, run, plotter, which):
    arguments = command("d.svg", "--to", f"grbl:{plotter.port}", "--yes")
    with begun(arguments, cwd=tmp_path, stderr=subprocess.PIPE, text=True) as process:
        until(lambda: len(plotter.fake.ink) >= 7)
        plotter.step_s = SLOW_S
        process.send_signal(which)
        _, err = process.communicate()
    plotter.step_s = 0.0
    assert process.returncode == 130, err
    assert "stopped with the pen up" in err
    assert not plotter.fake.pen_down
    assert plotter.fake.place == (0, 0)
    place = unfinished(tmp_path / "d.svg.journal", LONG)
    assert 1 <= place.stroke < 13
    assert not inked(plotter.fake) - counted(LONG.lines_mm)
    code, out, _ = run("d.svg", "--to", f"grbl:{plotter.port}", "--yes", "--resume", "--json")
    assert code == 0
    assert json.loads(out)["began"] == place.stroke
    assert inked(plotter.fake) == counted(LONG.lines_mm), "each segment once"
    assert plotter.fake.breaches == []


def test_killed_it_goes_on_and_only_the_line_in_doubt_is_drawn_again(tmp_path, run, plotter):
    arguments = command("d.svg", "--to", f"grbl:{plotter.port}", "--yes")
    with begun(arguments, cwd=tmp_path) as process:
        until(lambda: len(plotter.fake.ink) >= 7)
        process.kill()
    plotter.step_s = 0.0
    place = unfinished(tmp_path / "d.svg.journal", LONG)
    assert 1 <= place.stroke < 13
    until(lambda: plotter.fake._state() == "Idle")
    code, _, err = run("d.svg", "--to", f"grbl:{plotter.port}", "--yes", "--resume")
    assert code == 0, err
    got = inked(plotter.fake)
    assert not counted(LONG.lines_mm) - got, "nothing is lost"
    assert not got - counted(LONG.lines_mm) - counted([LONG.lines_mm[place.stroke]])


def test_a_failing_machine_is_exit_5_in_one_line(run, tmp_path):
    with Served(FakeGrbl(fault=Fault("unplug", 20))) as served:
        code, out, err = run("d.svg", "--to", f"grbl:{served.port}", "--yes")
    assert (code, out) == (5, "")
    (line,) = err.strip().splitlines()
    assert "unplugged" in line
    assert "pen state unknown" in line
    assert "--resume" in line
    with Served(FakeGrbl()) as served:
        assert run("d.svg", "--to", f"grbl:{served.port}", "--yes", "--resume")[0] == 0
    assert served.fake.breaches == []


AT_TERMINAL = """
import fcntl, os, sys, termios
os.setsid()
fcntl.ioctl(0, termios.TIOCSCTTY, 0)
os.execvp(sys.argv[1], sys.argv[1:])
"""


class Terminal:
    """A program at a terminal, as a user has it."""

    def __init__(self, arguments, folder):
        self._file, theirs = pty.openpty()
        ends = dict.fromkeys(("stdin", "stdout", "stderr"), theirs)
        # Not by ``pty.fork``: the plotter's thread may hold a lock that the child would wait for.
        self._process = subprocess.Popen([sys.executable, "-c", AT_TERMINAL, *arguments], cwd=folder, **ends)
        os.close(theirs)
        self.seen = ""

    def until(self, words):
        until(lambda: words in self.seen or self._read(0.1) is None, lambda: self.seen)

    def press(self, keys):
        os.write(self._file, keys.encode())

    def end(self):
        while self._read(PATIENCE_S):
            pass
        os.close(self._file)
        return self._process.wait(PATIENCE_S)

    def _read(self, timeout):
        if not select.select([self._file], [], [], timeout)[0]:
            return b""
        try:
            data = os.read(self._file, 4096)
        except OSError:
            return b""
        self.seen += data.decode(errors="replace")
        return data


def test_it_asks_shows_the_time_left_pauses_and_goes_on(tmp_path, run, plotter):
    terminal = Terminal(command("d.svg", "--to", f"grbl:{plotter.port}"), tmp_path)
    terminal.until("Begin?")
    assert "13 strokes" in terminal.seen
    assert "lower left corner" in terminal.seen
    assert plotter.fake.lines == 0, "nothing is sent before the answer"
    terminal.press("y\r")
    until(lambda: len(plotter.fake.ink) >= 4)
    plotter.step_s = SLOW_S
    terminal.press(" ")
    terminal.until("paused with the pen up; space goes on")
    plotter.step_s = 0.02
    until(lambda: not plotter.fake.pen_down and plotter.fake._state() == "Idle")
    drawn = len(plotter.fake.ink)
    time.sleep(0.5)
    assert len(plotter.fake.ink) == drawn
    terminal.press(" ")
    until(lambda: len(plotter.fake.ink) > drawn)
    assert terminal.end() == 0, terminal.seen
    assert "left" in terminal.seen
    assert "drawn: 13 strokes" in terminal.seen
    assert inked(plotter.fake) == counted(LONG.lines_mm)


def test_no_is_an_answer(tmp_path, run, plotter):
    terminal = Terminal(command("d.svg", "--to", f"grbl:{plotter.port}"), tmp_path)
    terminal.until("Begin?")
    terminal.press("n\r")
    assert terminal.end() == 130
    assert plotter.fake.lines == 0
    assert [path.name for path in tmp_path.iterdir()] == ["d.svg"]
