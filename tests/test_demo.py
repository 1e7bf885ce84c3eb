"""The portraits of the demo: each is drawn, within its budget, and most of its ink is the person."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import limner
from limner.cli import limner as command

PHOTOS = [f"cc0_{n:03}" for n in (1, 6, 9, 11, 16, 28, 37, 39, 46, 47, 50, 57, 61, 62, 71, 72)]
PHOTOS += ["pd_astronaut_eileen_collins", "pd_grace_hopper"]
MOST_STROKES = {"portrait": 120, "gabor": 150, "canny": 150}


@pytest.mark.slow
@pytest.mark.parametrize("style", MOST_STROKES)
@pytest.mark.parametrize("name", PHOTOS)
def test_each_portrait_is_drawn(shared, tmp_path, name, style):
    (photo,) = (shared / "data" / "demo").glob(f"{name}.*")
    out = tmp_path / "out.svg"
    arguments = ["draw", str(photo), "-o", str(out), "--style", style, "--points", "600", "--json"]
    result = CliRunner().invoke(command, arguments, catch_exceptions=False)
    assert result.exit_code == 0
    report = json.loads(result.stdout)
    assert 150 <= report["points"] <= 600
    assert report["strokes"] <= MOST_STROKES[style]
    drawing = limner.read_svg(out)
    assert Path(report["out"][0]) == out
    # The landmarks' box, widened for hair, ears and neck, holds most of the ink.
    affine = np.array(report["page_from_photo"])
    box = np.reshape(report["face"]["box_px"], (2, 2)) @ affine[:, :2].T + affine[:, 2]
    box[:, 1] = drawing.page.height_mm - box[:, 1]
    low, high = box.min(axis=0), box.max(axis=0)
    margin = 0.6 * (high - low)
    ink = np.concatenate(drawing.lines_mm)
    assert ((ink > low - margin) & (ink < high + margin)).all(axis=1).mean() > 0.6
