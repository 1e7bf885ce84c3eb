"""vpype's users have limner as a generator: their own commands read what it gives, in size and place."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

import limner
from limner.cli.evaluate import astronaut

pytest.importorskip("vpype_cli", reason="needs vpype; run: pip install 'limner[vpype]'")

VPYPE = Path(sys.executable).with_name("vpype")


def vpype(*arguments, folder):
    return subprocess.run([VPYPE, *map(str, arguments)], cwd=folder, capture_output=True, text=True)


@pytest.fixture
def folder(tmp_path):
    shutil.copy(astronaut(), tmp_path / "me.png")
    return tmp_path


def test_it_draws_what_limner_draws(folder):
    done = vpype("limner", "--points", 300, "--page", "a6", "me.png", "write", "out.svg", folder=folder)
    assert done.returncode == 0, done.stderr
    theirs = limner.read_svg(folder / "out.svg")
    ours = limner.draw(folder / "me.png", points=300, page="a6").drawing
    assert len(theirs.lines_mm) == len(ours.lines_mm)
    assert (theirs.page.width_mm, theirs.page.height_mm) == pytest.approx((105, 148), abs=0.01)
    for got, want in zip(theirs.lines_mm, ours.lines_mm, strict=True):
        assert np.abs(got[[0, -1]] - want[[0, -1]]).max() < 0.02


def test_every_pen_has_a_layer_of_its_own(folder):
    ours = limner.draw(folder / "me.png", style="cartoon", points=400, page="a6").drawing
    parts = ours.by_pen()
    assert len(parts) > 1
    command = ("rect", "1cm", "1cm", "1cm", "1cm", "limner", "--layer", "new", "--style", "cartoon", "-n", 400)
    done = vpype(*command, "--page", "a6", "me.png", "write", "out.svg", folder=folder)
    assert done.returncode == 0, done.stderr
    rect, *layers = [
        layer
        for layer in ElementTree.parse(folder / "out.svg").getroot()
        if layer.get("{http://www.inkscape.org/namespaces/inkscape}groupmode") == "layer"
    ]
    assert len(rect) == 1, "what was drawn before stays alone"
    assert [len(layer) for layer in layers] == [len(part.lines_mm) for part in parts]
    pens = [part.pens[part.layer[0]] for part in parts]
    assert [layer.get("stroke") for layer in layers] == [pen.hex for pen in pens]


def test_mistakes_are_vpypes_own_errors(folder):
    done = vpype("limner", "--style", "oil", "me.png", "write", "out.svg", folder=folder)
    assert done.returncode != 0
    assert "oil" in done.stderr
    assert not (folder / "out.svg").exists()


def test_it_has_help_among_the_generators(folder):
    done = vpype("limner", "--help", folder=folder)
    assert "PHOTO" in done.stdout
    assert "--layer" in done.stdout
