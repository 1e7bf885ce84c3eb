"""What the page for users of MoveIt and ROS tells to do works, as it stands there; other blocks of `text` need ROS."""

from __future__ import annotations

import functools
import io
import re
import shlex
import sys
from contextlib import redirect_stdout
from pathlib import Path

import pytest

from arms import drawing, robot
from limner.cli import jobs, main
from limner.targets import bag
from limner.targets.fake_rosbridge import FakeRosbridge
from limner.targets.recording import TOPICS
from limner.targets.rosbridge import Rosbridge, RosbridgeSettings
from limner.targets.svg import to_svg
from test_rosbridge import PACE, arm_clock, fake_arm

for package, extra in (("urdf_parser_py", "robot"), ("toppra", "robot"), ("rosbags", "ros"), ("websockets", "ros")):
    pytest.importorskip(package, reason=f"pip install 'limner[{extra}]'")

PAGE = (Path(__file__).parents[1] / "docs" / "how-to" / "moveit.md").read_text()


def blocks(language):
    return [text for kind, text in re.findall(r"^```(\w*)\n(.*?)^```$", PAGE, re.M | re.S) if kind == language]


COMMANDS = [
    line for kind in ("sh", "text") for block in blocks(kind) for line in block.splitlines() if "limner " in line
]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Where every command of the page has run, on a small drawing."""
    folder = tmp_path_factory.mktemp("moveit")
    (folder / "me.svg").write_bytes(to_svg(drawing()))
    with pytest.MonkeyPatch.context() as patch, fake_arm() as fake:
        patch.chdir(folder)
        patch.setattr(jobs, "Rosbridge", functools.partial(Rosbridge, silence_s=40.0, clock=arm_clock(PACE)))
        for line in COMMANDS:
            words = shlex.split(line.replace("localhost:9090", f"127.0.0.1:{fake.port}"))
            patch.setattr(sys, "argv", words)
            with pytest.raises(SystemExit) as exit_:
                main()
            assert exit_.value.code == 0, line
    assert isinstance(fake, FakeRosbridge)
    assert (fake.breaches, len(fake.done)) == ([], 2 + len(drawing().lines_mm)), "there, every stroke, and back"
    return folder


def test_every_command_is_limners():
    assert len(COMMANDS) >= 5
    assert all(line.startswith("limner ") for line in COMMANDS)


def test_every_command_writes_what_it_names(folder):
    for name in ("motion.json", "motion.bag", "motion.mcap/motion.mcap", "waypoints.json", "waypoints.csv"):
        assert (folder / name).stat().st_size > 1000


def test_the_python_block_groups_the_strokes(folder, monkeypatch):
    monkeypatch.chdir(folder)
    (code,) = blocks("python")
    said = io.StringIO()
    names = {}
    with redirect_stdout(said):
        exec(compile(code, "moveit.md", "exec"), names)
    assert said.getvalue() == "arm_base_link 4 strokes\n"
    assert sum(len(poses) for _, poses in names["strokes"]) == len(names["told"]["waypoints"])


def test_topics_types_joints_and_settings_are_those_that_exist():
    told = dict(re.findall(r"^\| `(/\w+)` \| `(\w+/\w+)` \|", PAGE, re.M))
    assert told == {topic: kind.replace("/msg/", "/") for topic, kind in TOPICS.items()}
    assert set(re.findall(r"^\| `rosbridge\.(\w+)` \|", PAGE, re.M)) == {p for p, *_ in RosbridgeSettings.walk()}
    assert {robot().joints[0], robot().joints[-1], robot().base, robot().root} <= set(re.findall(r"`(\w+)`", PAGE))
    assert all(suffix in PAGE for suffix in bag.FORMATS)
