"""What the README tells to do works, as it stands there."""

from __future__ import annotations

import contextlib
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from drawings import of
from limner.cli.evaluate import astronaut
from limner.targets.svg import to_svg

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text()


def blocks(language):
    return re.findall(rf"^```{language}\n(.*?)^```", README, re.M | re.S)


COMMANDS = [
    line.partition("#")[0].strip()
    for block in blocks("")
    for line in block.splitlines()
    if line.startswith("limner ") and "DIR" not in line
]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with the photo me.jpg and some drawing me.svg in it, to be in."""
    shutil.copy(astronaut(), tmp_path / "me.jpg")
    (tmp_path / "me.svg").write_bytes(to_svg(of([[20, 20], [60, 90]])))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def files_in(folder):
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_there_is_something_to_test():
    assert len(COMMANDS) >= 4
    assert blocks("python")


@pytest.mark.parametrize("line", COMMANDS)
def test_every_command_runs(folder, line):
    before = files_in(folder)
    subprocess.run([sys.executable, "-m", *shlex.split(line)], check=True, env=os.environ | {"PYTHONWARNINGS": "error"})
    assert (files_in(folder) == before) == line.startswith("limner send"), "every other command writes a file"


@pytest.mark.parametrize("code", blocks("python"))
def test_every_python_block_runs(folder, code):
    with contextlib.redirect_stdout(None):
        exec(compile(code, "README.md", "exec"), {})
    assert (folder / "me.svg").stat().st_size > 1000


def test_every_link_leads_somewhere():
    for target in re.findall(r"\]\(([^)#]+)\)", README):
        assert target.startswith("https://") or (ROOT / target).exists(), target


def test_every_make_target_exists():
    makefile = (ROOT / "Makefile").read_text()
    for target in re.findall(r"`?make ([\w-]+)", README):
        assert re.search(rf"^{target}:", makefile, re.M), target
