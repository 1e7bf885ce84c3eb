"""The benchmark measures what it says, and frames a photo without bending it."""

from __future__ import annotations

import json

import numpy as np
import pytest
from click.testing import CliRunner

from limner.cli import limner as command
from limner.evaluate.speed import LARGE_PX, SMALL_PX, Row, framed
from limner.types import Photo


@pytest.mark.parametrize("size", [(300, 500), (640, 480), (1000, 200), (90, 70)])
@pytest.mark.parametrize("target", [SMALL_PX, (40, 90)])
def test_framing_cuts_to_size_and_keeps_shapes(size, target):
    y, x = np.indices(size[::-1]) / max(size)
    photo = Photo(np.stack([x, y, x * 0], axis=2) * 200)
    picture = framed(photo, target)
    assert picture.size_px == target
    # One pixel right and one pixel down are the same step in the photo: nothing is stretched.
    across = np.ptp(picture.rgb[..., 0].astype(int)) / target[0]
    down = np.ptp(picture.rgb[..., 1].astype(int)) / target[1]
    assert across == pytest.approx(down, rel=0.25, abs=0.05)


def test_a_figure_knows_whether_it_keeps_its_promise():
    assert Row("a", 9, "ms", 10).reached
    assert not Row("a", 11, "ms", 10).reached
    assert Row("a", 11, "ms").reached


@pytest.mark.slow
def test_the_benchmark_runs_and_memory_is_bounded():
    result = CliRunner().invoke(command, ["evaluate", "speed", "--runs", "1", "--json"], catch_exceptions=False)
    rows = {row["name"]: row for row in json.loads(result.stdout)["speed"]}
    assert all(row["value"] > 0 for row in rows.values())
    # Memory, unlike time, does not depend on how busy the machine is.
    peaks = [row["value"] for name, row in rows.items() if name.endswith("peak memory")]
    assert len(peaks) == 5
    assert max(peaks) < 600
    assert LARGE_PX[0] * LARGE_PX[1] == 12_000_000
