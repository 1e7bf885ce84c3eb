"""The command line as a stranger uses it: every command over good, bad and degenerate input."""

from __future__ import annotations

import io
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image

import limner
from limner import storage
from limner.cli import COMMANDS, limner as command, main
from limner.cli.evaluate import astronaut
from limner.vision.landmarks.fmp.matlab import import_matlab
from limner.vision.landmarks.fmp.model import load_model

DRAWING_COMMANDS = ("draw", "face", "compare")


class Ran:
    """What a run of the command ended with."""

    def __init__(self, code, out, err):
        self.code, self.out, self.err = code, out, err


@pytest.fixture
def run(monkeypatch, capfdbinary, tmp_path):
    """Run ``limner`` in this process, in an empty folder, through the same ``main`` as the command."""

    def run(*arguments, stdin=b""):
        monkeypatch.chdir(tmp_path)
        monkeypatch.setattr(sys, "argv", ["limner", *map(str, arguments)])
        monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(stdin)))
        capfdbinary.readouterr()
        with pytest.raises(SystemExit) as exit_:
            main()
        out, err = capfdbinary.readouterr()
        return Ran(exit_.value.code, out.decode(), err.decode())

    return run


@pytest.fixture(scope="session")
def photo(tmp_path_factory):
    """The head of the astronaut, as JPEG."""
    path = tmp_path_factory.mktemp("photo") / "astronaut.jpg"
    Image.open(astronaut()).crop((80, 0, 380, 300)).save(path, quality=95)
    return path


@pytest.fixture(scope="session")
def face_file(tmp_path_factory, photo):
    """Her landmarks in a file, so that most tests need not look for her."""
    path = tmp_path_factory.mktemp("face") / "face.json"
    faces = limner.find_faces(limner.load_photo(photo))
    path.write_text(json.dumps({"faces": [storage.to_fields(face) for face in faces]}))
    return path


def one_line(ran):
    """The only line on stderr."""
    (line,) = ran.err.strip().splitlines()
    assert line.startswith("limner: ")
    assert "Traceback" not in ran.err
    return line


def test_draw_writes_what_was_asked_for(run, photo, tmp_path):
    ran = run("draw", photo, "-o", "a.svg", "-o", "a.png", "--points", 600, "--json")
    assert ran.code == 0
    report = json.loads(ran.out)
    assert set(report) == {
        "faces", "face", "style", "strokes", "points", "ink_mm", "travel_mm", "lifts", "likeness",
        "photo_notes", "candidates", "draw_s", "page_from_photo", "seconds", "settings", "out",
    }  # fmt: skip
    assert report["faces"] == 1
    assert 200 < report["points"] <= 600
    assert report["out"] == ["a.svg", "a.png"]
    assert report["seconds"]["total"] >= max(report["seconds"].values()) > 0
    drawing = limner.read_svg(tmp_path / "a.svg")
    assert len(drawing.lines_mm) == report["strokes"]
    # Ink lies where the photo has it: the eyes, sent to the page, are within the drawing.
    affine = np.array(report["page_from_photo"])
    eye = affine[:, :2] @ report["face"]["points_px"][36] + affine[:, 2]
    ink = np.concatenate(drawing.lines_mm)
    assert np.hypot(*(ink - [eye[0], drawing.page.height_mm - eye[1]]).T).min() < 8
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.png", "a.svg"]


def test_curves_minutes_and_an_order_for_an_audience(run, photo, face_file, tmp_path):
    given = ("draw", photo, "--landmarks", face_file, "--json", "-o", "a.svg")
    plain = json.loads(run(*given, "--minutes", 0.5).out)
    assert 0.9 * 30 <= plain["draw_s"] <= 30
    assert " C " not in (tmp_path / "a.svg").read_text()
    shown = json.loads(run(*given, "--minutes", 0.5, "--curves", "--order", "audience").out)
    assert " C " in (tmp_path / "a.svg").read_text()
    assert shown["draw_s"] <= 30
    assert shown["shortest_travel_mm"] < shown["travel_mm"]


def test_same_input_same_bytes(run, photo, face_file, tmp_path):
    for name in ("a.svg", "b.svg"):
        assert run("draw", photo, "--landmarks", face_file, "-o", name).code == 0
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()


def test_the_default_is_an_svg_here(run, photo, face_file, tmp_path):
    ran = run("draw", photo, "--landmarks", face_file)
    assert ran.code == 0
    assert ran.out == ""
    assert [path.name for path in tmp_path.iterdir()] == ["astronaut.svg"]
    assert ran.err.splitlines()[-1] == "astronaut.svg"


def test_standard_input_and_output(run, photo, face_file, tmp_path):
    ran = run("draw", "-", "--landmarks", face_file, "-o", "-", stdin=photo.read_bytes())
    assert ran.code == 0
    assert limner.read_svg(ran.out.encode()).points > 100
    assert not list(tmp_path.iterdir())


def test_face_gives_landmarks_that_draw_takes(run, photo, tmp_path):
    ran = run("face", photo, "--json", "-o", "face.json", "--overlay", "face.png")
    assert ran.code == 0
    (face,) = json.loads(ran.out)["faces"]
    assert set(face) == {"points_px", "box_px", "score", "yaw_deg", "detector"}
    assert json.loads((tmp_path / "face.json").read_text()) == {"faces": [face]}
    with Image.open(tmp_path / "face.png") as picture, Image.open(photo) as original:
        assert picture.size == original.size
    drawn = json.loads(run("draw", photo, "--landmarks", "face.json", "--json").out)
    assert np.allclose(drawn["face"]["points_px"], face["points_px"])


def test_a_crop_draws_the_same_person_in_the_same_frame(run, photo):
    x, y, width, height = 30, 20, 240, 260
    whole = json.loads(run("face", photo, "--json").out)["faces"][0]
    cut = json.loads(run("face", photo, "--crop", f"{x},{y},{width},{height}", "--json").out)["faces"][0]
    unit = np.hypot(*np.subtract(whole["points_px"][36], whole["points_px"][45]))
    error = np.hypot(*np.subtract(whole["points_px"], cut["points_px"]).T)
    assert error.mean() < 0.05 * unit


def test_compare_shows_every_style(run, photo, face_file, tmp_path):
    ran = run("compare", photo, "--landmarks", face_file, "-o", "styles.png", "--json")
    assert ran.code == 0
    assert [report["style"] for report in json.loads(ran.out)["styles"]] == list(limner.STYLES)
    with Image.open(tmp_path / "styles.png") as sheet:
        assert sheet.width > 1000


def test_compare_leaves_out_a_style_that_the_budget_does_not_allow(run, photo, face_file, tmp_path):
    ran = run("compare", photo, "--landmarks", face_file, "-n", 40, "-o", "styles.png", "--json")
    assert ran.code == 0
    told = json.loads(ran.out)
    assert "no stroke" in told["left_out"]["scribble"]
    assert {report["style"] for report in told["styles"]} | set(told["left_out"]) == set(limner.STYLES)


def test_settings_go_out_and_come_in(run, photo, face_file, tmp_path):
    page = ["--page", "a6", "--margin", "1cm", "--pen", "0.3mm"]
    style = ["--style", "canny", "--set", "canny.blur_px=2.5", "--save-settings", "s.toml"]
    first = run("draw", photo, "--landmarks", face_file, "-o", "a.svg", *page, *style)
    assert first.code == 0, first.err
    assert run("draw", photo, "--settings", "s.toml", "-o", "b.svg").code == 0
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()
    assert limner.read_svg(tmp_path / "a.svg").pen.width_mm == 0.3


@pytest.mark.parametrize("points", [2, 3, 50, 250])
def test_points_are_never_exceeded(run, photo, face_file, points):
    ran = run("draw", photo, "--landmarks", face_file, "--points", points, "--json")
    report = json.loads(ran.out)
    assert ran.code == 0
    assert 2 <= report["points"] <= points


def pictures():
    """Name -> bytes of files that hold no face, or no picture."""

    def encoded(array, kind="PNG"):
        out = io.BytesIO()
        Image.fromarray(array).save(out, kind)
        return out.getvalue()

    noise = np.random.default_rng(0).integers(0, 256, (120, 160, 3), dtype=np.uint8)
    return {
        "blank.png": (3, encoded(np.full((300, 400, 3), 255, np.uint8))),
        "black.png": (3, encoded(np.zeros((300, 400), np.uint8))),
        "noise.png": (3, encoded(noise)),
        "one pixel.png": (3, encoded(np.zeros((1, 1, 3), np.uint8))),
        "row.png": (3, encoded(np.zeros((1, 500, 3), np.uint8))),
        "column.png": (3, encoded(np.zeros((500, 1, 3), np.uint8))),
        "empty.jpg": (2, b""),
        "text.jpg": (2, b"this is not a picture"),
        "truncated.png": (2, encoded(noise)[:2000]),
        "svg.png": (2, b"<svg xmlns='http://www.w3.org/2000/svg'/>"),
    }


@pytest.mark.parametrize("name", pictures())
@pytest.mark.parametrize("verb", DRAWING_COMMANDS)
def test_degenerate_photos_give_one_clear_line(run, verb, name, tmp_path):
    code, data = pictures()[name]
    (tmp_path / name).write_bytes(data)
    ran = run(verb, name)
    assert ran.code == code, ran.err
    line = one_line(ran)
    assert ("no face found" in line and "--crop" in line and "upright" in line) if code == 3 else name in line
    assert [path.name for path in tmp_path.iterdir()] == [name]


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (["draw", "nobody.jpg"], 2, ["nobody.jpg"]),
        (["draw", "."], 2, ["folder", "limner batch"]),
        (["PHOTO"], 2, ["limner draw"]),
        (["."], 2, ["limner batch ."]),
        (["evaluate", "thesys"], 2, ["did you mean 'thesis'"]),
        (["train", "nothing"], 2, ["choose from", "fmp", "shape"]),
        (["draw", "PHOTO", "--minutes", "3x"], 2, ["3x", "min, h"]),
        (["draw", "PHOTO", "--style", "Gabr"], 2, ["did you mean gabor"]),
        (["draw", "PHOTO", "--face", "3"], 3, ["no face 3", "--face 1"]),
        (["draw", "PHOTO", "--face", "0"], 2, ["--face", "0"]),
        (["draw", "PHOTO", "--crop", "1,2,3"], 2, ["--crop", "x,y,w,h"]),
        (["draw", "PHOTO", "--crop", "0,0,9999,10"], 2, ["9999", "300"]),
        (["draw", "PHOTO", "--crop", "0,0,40,30"], 3, ["no face found"]),
        (["draw", "PHOTO", "--points", "1"], 2, ["points", "at least 2"]),
        (["draw", "PHOTO", "--points", "many"], 2, ["points", "whole number"]),
        (["draw", "PHOTO", "--style", "oil"], 2, ["style", "gabor", "canny"]),
        (["draw", "PHOTO", "--complete", "chin"], 2, ["chin", "jaw", "mouth"]),
        (["draw", "PHOTO", "--set", "trim.by=circle"], 2, ["circle", "rectangle", "length"]),
        (["draw", "PHOTO", "--page", "a99"], 2, ["a99", "a4"]),
        (["draw", "PHOTO", "--page", "20x20mm", "--margin", "10"], 2, ["margin"]),
        (["draw", "PHOTO", "--pen", "thick"], 2, ["thick"]),
        (["draw", "PHOTO", "--pen", "5in"], 2, ["pen_mm", "50"]),
        (["draw", "PHOTO", "--set", "gabor"], 2, ["NAME=VALUE"]),
        (["draw", "PHOTO", "--set", "gabor.colour=1"], 2, ["gabor.colour", "does not exist"]),
        (["draw", "PHOTO", "--settings", "none.toml"], 2, ["none.toml"]),
        (["draw", "PHOTO", "-o", "a.bmp"], 2, [".bmp", ".svg"]),
        (["draw", "PHOTO", "-o", "no/such/folder.svg"], 2, ["folder.svg"]),
        (["draw", "PHOTO", "--landmarks", "none.json"], 2, ["none.json"]),
        (["draw", "PHOTO", "--landmarks", "PHOTO"], 2, [".json"]),
        (["face", "PHOTO", "--overlay", "a.svg"], 2, [".png"]),
        (["face", "PHOTO", "-o", "a.txt"], 2, [".json"]),
        (["compare", "PHOTO", "-o", "a.svg"], 2, [".png"]),
        (["drow", "PHOTO"], 2, ["draw"]),
        (["draw"], 2, ["PHOTO"]),
        (["draw", "PHOTO", "--colour"], 2, ["--colour"]),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_mistakes_are_named_in_one_line(run, photo, arguments, code, words, tmp_path):
    ran = run(*(str(photo) if argument == "PHOTO" else argument for argument in arguments))
    assert ran.code == code, ran.err
    line = one_line(ran)
    for word in words:
        assert word.lower() in line.lower()
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("arguments", [(), ("evaluate",), ("train",), ("ros",)], ids=" ".join)
def test_a_group_alone_shows_its_help_as_it_is(run, arguments):
    ran = run(*arguments)
    assert ran.code == 2
    assert ran.err == run(*arguments, "--help").out
    told = ran.err.partition("\nCommands:\n")[2]
    assert told
    assert "..." not in told  # nothing said of a command is cut off


def test_a_name_that_begins_with_a_dash_is_explained(run, photo, tmp_path):
    (tmp_path / "-selfie.jpg").write_bytes(photo.read_bytes())
    assert one_line(run("draw", "-selfie.jpg")) == "limner: -selfie.jpg is read as options; write ./-selfie.jpg"


@pytest.mark.parametrize(("text", "said"), [("style = gabor", "quotes"), ("[gabor]\norientation = 4", "orientations")])
def test_a_wrong_settings_file_is_named(run, photo, text, said, tmp_path):
    (tmp_path / "my.toml").write_text(text)
    line = one_line(run("draw", photo, "--settings", "my.toml"))
    assert "my.toml" in line
    assert said in line


def test_the_help_of_draw_begins_with_what_is_drawn_where(run):
    options = [line.split()[0].rstrip(",") for line in run("draw", "--help").out.splitlines() if line[:3] == "  -"]
    assert options[:4] == ["-o", "-s", "-n", "--minutes"]


@pytest.mark.parametrize(("verb", "said"), [("draw", "drawing in the style portrait"), ("compare", "10/10")])
def test_on_a_terminal_draw_and_compare_say_what_they_do(verb, said, photo, face_file, tmp_path):
    pty = pytest.importorskip("pty")
    command = [sys.executable, "-m", "limner", verb, str(photo), "--landmarks", str(face_file), "-n", "40"]
    ours, theirs = pty.openpty()
    environment = os.environ | {"TERM": "xterm", "COLUMNS": "100"}
    with subprocess.Popen(command, stderr=theirs, stdout=subprocess.DEVNULL, cwd=tmp_path, env=environment) as process:
        os.close(theirs)
        seen = b"".join(iter(lambda: _read(ours), b""))
        assert process.wait() == 0
    os.close(ours)
    assert said in seen.decode()


def _read(terminal):
    """What a terminal was told; nothing when it was closed, which Linux makes an error."""
    try:
        return os.read(terminal, 65536)
    except OSError:
        return b""


def test_two_faces_are_told_and_chosen(run, photo, tmp_path):
    with Image.open(photo) as one:
        both = Image.new("RGB", (560, 300), "white")
        both.paste(one.resize((240, 240)), (310, 20))
        both.paste(one, (0, 0))
    both.save(tmp_path / "both.png")
    ran = run("draw", "both.png", "-o", "a.svg")
    assert "1 more in the photo, choose with --face" in ran.err
    first, second = (json.loads(run("draw", "both.png", "--face", n, "--json").out) for n in (1, 2))
    assert first["faces"] == second["faces"] == 2
    assert first["face"]["box_px"][2] < 300 < second["face"]["box_px"][0]


def test_no_file_is_left_when_writing_fails(run, photo, face_file, tmp_path, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", full)
    ran = run("draw", photo, "--landmarks", face_file)
    assert ran.code == 2
    assert "No space left" in one_line(ran)
    assert not list(tmp_path.iterdir())


def test_a_bug_is_one_line_and_with_debug_a_traceback(run, photo, monkeypatch):
    def broken(*_, **__):
        raise ZeroDivisionError("oops")

    monkeypatch.setattr("limner.pipeline.draw", broken)
    ran = run("draw", photo)
    assert ran.code == 1
    assert "bug in limner" in one_line(ran)
    assert "Traceback" in run("draw", photo, "--debug").err


def test_interrupted_is_130(run, photo, monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("limner.pipeline.draw", interrupted)
    ran = run("draw", photo)
    assert ran.code == 130
    assert "interrupted" in one_line(ran)


def every_command(group, path=()):
    for name in group.list_commands(None):
        command = group.get_command(None, name)
        yield (*path, name), command
        if hasattr(command, "list_commands"):
            yield from every_command(command, (*path, name))


ALL = dict(every_command(command))


@pytest.mark.parametrize("path", ALL, ids=" ".join)
def test_every_command_and_option_has_help(path):
    result = CliRunner().invoke(command, [*path, "--help"])
    assert result.exit_code == 0
    assert ALL[path].help
    for parameter in ALL[path].params:
        named = (
            parameter.help if parameter.param_type_name == "option" else parameter.metavar.strip("[]") in result.output
        )
        assert named, f"{' '.join(path)}: nothing is said of {parameter.name}"


@pytest.mark.parametrize("name", COMMANDS)
def test_the_short_help_is_the_commands_own(name):
    assert ALL[(name,)].short_help == COMMANDS[name][1]


def test_every_command_stands_in_the_readme():
    readme = (Path(__file__).parents[1] / "README.md").read_text()
    for path in ALL:
        assert f"limner {' '.join(path)}" in readme


def test_the_command_is_installed():
    done = subprocess.run([sys.executable, "-m", "limner", "--version"], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == f"limner {limner.__version__}"


def test_a_reader_that_goes_away_is_no_error(photo, face_file):
    program = [sys.executable, "-m", "limner", "draw", str(photo), "--landmarks", str(face_file), "-o", "-"]
    with subprocess.Popen(program, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        process.stdout.close()
        err = process.stderr.read().decode()
        assert process.wait(60) in (0, 1)  # 1 is what click makes of it
    assert "Traceback" not in err
    assert "bug" not in err


def test_the_authors_models_are_imported_by_one_command(run, shared, tmp_path):
    source, out = shared / "data/zhu-ramanan/face_p99.mat", tmp_path / "p99.npz"
    ran = run("train", "import", source, "-o", out, "--json")
    report = json.loads(ran.out)
    assert (ran.code, report["out"], report["views"]) == (0, [str(out)], 13)
    assert report["parts"] == [39] * 3 + [68] * 7 + [39] * 3
    assert load_model(out) == import_matlab(source)


@pytest.mark.parametrize(
    ("content", "out", "said"),
    [(b"x" * 500, "a.npz", "face.mat"), (None, "a.npz", "face.mat"), (b"x", "a.mat", ".npz")],
)
def test_what_cannot_be_imported_gives_one_line(run, tmp_path, content, out, said):
    if content is not None:
        (tmp_path / "face.mat").write_bytes(content)
    ran = run("train", "import", tmp_path / "face.mat", "-o", tmp_path / out)
    assert (ran.code, said in ran.err, ran.err.count("\n")) == (2, True, 1)
    assert not (tmp_path / out).exists()
