"""``limner plan`` as a stranger uses it."""

from __future__ import annotations

import json

import pytest

import limner
from drawings import of, segments
from limner.cli.words import clock
from limner.motion.cost import seconds
from limner.motion.machine import MACHINES, load_machine
from limner.types import PenPath

DRAWING = of([[30, 30], [120, 30], [120, 180]], [[40, 60]], [[40, 100], [90, 150]])


@pytest.fixture
def run(command, tmp_path):
    (tmp_path / "d.svg").write_bytes(limner.to_svg(DRAWING))
    return command


def test_it_tells_time_travel_and_lifts(run):
    code, out, err = run("plan", "d.svg")
    assert (code, out) == (0, "")
    assert "axidraw" in err
    assert "0.31 m of ink" in err
    assert "3 lifts" in err
    for name in MACHINES:
        code, out, err = run("plan", "d.svg", "--machine", name, "--json", "--fit")
        assert (code, err) == (0, "")
        report = json.loads(out)
        assert report["machine"]["name"] == name
        if name != "brachiograph":
            assert report["seconds"] == pytest.approx(seconds(DRAWING, load_machine(name)))


def test_films_paths_and_drawings_are_written(run, tmp_path):
    written = ["-o", "b.svg", "-o", "b.png", "--movie", "a.gif", "--path", "p.npz"]
    code, out, _ = run("plan", "d.svg", "--movie-time", "1s", "--json", *written)
    assert code == 0
    assert json.loads(out)["out"] == ["b.svg", "b.png", "a.gif", "p.npz"]
    assert (tmp_path / "b.svg").read_bytes() == limner.to_svg(limner.read_svg(tmp_path / "d.svg"))
    path = limner.load(PenPath, tmp_path / "p.npz")
    assert path.t_s[-1] == pytest.approx(json.loads(out)["seconds"])


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (["none.svg"], 2, ["none.svg"]),
        (["d.txt"], 2, [".txt", ".svg"]),
        (["d.svg", "-m", "plotomat"], 2, ["plotomat", "axidraw", ".toml"]),
        (["d.svg", "-m", "none.toml"], 2, ["none.toml"]),
        (["d.svg", "-o", "a.bmp"], 2, [".bmp", ".svg"]),
        (["d.svg", "--movie", "a.avi"], 2, [".avi", ".gif", ".mp4"]),
        (["d.svg", "--movie", "a.gif", "--movie-time", "soon"], 2, ["movie-time"]),
        (["d.svg", "--movie", "a.gif", "--movie-time", "0s"], 2, ["movie"]),
        (["d.svg", "--path", "a.txt"], 2, [".txt"]),
        (["empty.svg"], 4, ["no strokes"]),
        (["d.svg", "-m", "brachiograph"], 4, ["brachiograph", "80 mm", "scale it by 0.533"]),
        (["nan.json"], 2, ["finite"]),
        (["off.svg"], 4, ["page", "moved"]),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_mistakes_are_named_in_one_line(run, tmp_path, arguments, code, words):
    (tmp_path / "empty.svg").write_bytes(limner.to_svg(of()))
    (tmp_path / "off.svg").write_bytes(limner.to_svg(of([[-5, 10], [20, 20]])))
    (tmp_path / "nan.json").write_text(
        '{"lines_mm": [[[0, NaN], [1, 1]]], "region": ["face"], "weight": [1], "page": {}, "pen": {}}'
    )
    before = sorted(tmp_path.iterdir())
    got, out, err = run("plan", *arguments)
    assert got == code, err
    (line,) = err.strip().splitlines()
    assert out == ""
    for word in words:
        assert word.lower() in line.lower()
    assert sorted(tmp_path.iterdir()) == before


def test_a_machine_is_written_to_be_changed(run, tmp_path):
    assert run("plan", "d.svg", "-m", "grbl", "--save-machine", "mine.toml")[0] == 0
    assert load_machine(str(tmp_path / "mine.toml")) == load_machine("grbl")
    text = (tmp_path / "mine.toml").read_text()
    assert "# Greatest speed with the pen down [mm/s" in text
    (tmp_path / "mine.toml").write_text(text.replace("draw_mm_s = 40.0", "draw_mm_s = 4.0"))
    slow = json.loads(run("plan", "d.svg", "-m", "mine.toml", "--json")[1])
    assert slow["draw_s"] > 8 * json.loads(run("plan", "d.svg", "-m", "grbl", "--json")[1])["draw_s"]


def test_gcode_is_written_at_the_speed_of_the_machine(run, tmp_path):
    assert run("plan", "d.svg", "-o", "a.gcode", "-o", "a.hpgl", "--set", "gcode.pen=z")[0] == 0
    text = (tmp_path / "a.gcode").read_text()
    assert "F3300" in text
    assert "G0 Z5" in text
    for name in ("a.gcode", "a.hpgl"):
        back = limner.read_drawing(tmp_path / name)
        assert segments(back.lines_mm) == segments(DRAWING.lines_mm)
        assert run("plan", name)[0] == 0


def test_one_dot_is_a_drawing(run, tmp_path):
    (tmp_path / "dot.svg").write_bytes(limner.to_svg(of([[20, 20]])))
    code, _, err = run("plan", "dot.svg")
    assert code == 0
    assert "1 stroke and 1 point:" in err


def test_times_are_told_as_one_says_them():
    assert [clock(s) for s in (0.4, 59.4, 59.6, 185, 3723)] == ["0 s", "59 s", "1:00 min", "3:05 min", "1:02:03 h"]
