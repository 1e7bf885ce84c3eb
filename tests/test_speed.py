"""The benchmark measures what it says, and frames a photo without bending it."""

from __future__ import annotations

import json
from xml.etree import ElementTree

import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image

from limner.cli import limner as command
from limner.cli.evaluate import astronaut
from limner.evaluate.bench import PICTURE, Bench, to_markdown, to_picture
from limner.evaluate.peers import Peer, peers
from limner.evaluate.rates import Overhead, Rate, local_cluster, overhead, rates
from limner.evaluate.speed import LARGE_PX, SMALL_PX, Row, framed
from limner.evaluate.stages import Stage, stages_of
from limner.types import Photo
from limner.vision.photo import load_photo


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


STAGES = [Stage("photo", 0.01, 100.0), Stage("idle", 0.0001, 100.0), Stage("face", 0.5, 150.0)]
BENCH = Bench(
    {"processor": "some"},
    (Row("a figure", 3, "ms", 2.0),),
    {0.3: STAGES, 12.0: [*STAGES, Stage("order", 0.3, None)]},
    (Rate("1 worker", 50.0, 1.1, 300.0), Rate("2 workers", 95.0, 1.2, 310.0)),
    Overhead(10, 0.5, 0.9),
    (Peer("limner", 1.0, 40, 400, 1500.0, 500.0, 0.8), Peer("<other>, with all", 2.0, 90, 4000, 9000.0, 800.0, None)),
)


def test_the_page_says_what_was_measured():
    page = to_markdown(BENCH)
    assert "| photo | 10 ms, 100 MB | 10 ms, 100 MB |" in page
    assert "| order | - | 300 ms |" in page
    assert "| **all** | **510 ms, 150 MB** | **810 ms, 150 MB** |" in page
    assert "idle" not in page
    assert "| 2 workers | 95 | 1.90 | 1.20 s | 310 MB |" in page
    assert "| a figure | 3 ms | 2 ms | **no** |" in page
    assert f"]({PICTURE})" in page


def test_bars_are_as_long_as_what_they_show():
    picture = ElementTree.fromstring(to_picture(BENCH))
    bars = [float(bar.get("width")) for bar in picture.iter("{http://www.w3.org/2000/svg}rect")]
    assert any(a == pytest.approx(b * 50 / 95, abs=0.1) for a in bars for b in bars if a != b)
    assert max(bars[1:]) < bars[0]
    texts = [text.text for text in picture.iter("{http://www.w3.org/2000/svg}text")]
    assert {"95 /min", "400 points", "<other>", "810 ms"} <= set(texts)


def test_stages_of_a_photo_and_other_programs(tmp_path):
    photo = framed(load_photo(astronaut()), SMALL_PX)
    path = tmp_path / "photo.png"
    Image.fromarray(photo.rgb).save(path)
    stages = {stage.name: stage for stage in stages_of(path)}
    assert {"photo", "face", "refine", "order"} <= set(stages)
    assert all(stage.seconds > 0 for stage in stages.values())
    assert all(stage.peak_mb is None or 30 < stage.peak_mb < 700 for stage in stages.values())
    ours, other = list(peers(photo))[:2]
    assert ours.name == "limner"
    assert ours.points < other.points
    assert 0 <= other.likeness < ours.likeness <= 1


@pytest.mark.slow
def test_a_local_cluster_begins_with_all_its_workers(tmp_path):
    distributed = pytest.importorskip("distributed")
    with (
        local_cluster(2, tmp_path) as address,
        distributed.Client(address, timeout=60, set_as_default=False) as client,
    ):
        assert sorted(client.nthreads().values()) == [1, 1]
        profiled = client.run(lambda dask_worker: "profile" in dask_worker.periodic_callbacks)
        assert not any(profiled.values())


@pytest.mark.slow
def test_batches_are_timed_on_workers_and_on_a_cluster():
    noise = np.random.default_rng(0).integers(0, 256, (40, 40, 3))
    measured = list(rates(Photo(noise), 3))
    assert [rate.name for rate in measured] == ["1 worker", "2 workers", "Dask cluster of 2 here"]
    assert all(rate.per_minute > 0 and 30 < rate.peak_mb < 700 for rate in measured)
    small = overhead(20)
    assert small.photos == 20
    assert small.restart_s > 0
