"""A real Dask cluster on this machine draws the same files as one process, whatever dies meanwhile."""

from __future__ import annotations

import contextlib
import dataclasses
import functools
import http.server
import os
import signal
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor

import pytest

from batches import QUICK, expected_svg, files_of, order_for, put_photo, put_photos, report_of, rows_of, run_batch
from limner import storage
from limner.batch import remote
from limner.batch.cluster import cluster_engine
from limner.batch.engine import Engine, in_order
from limner.batch.everything import draw_batch
from limner.batch.summary import Summary
from limner.errors import BadInput
from limner.vision.landmarks.fmp.training import train
from processes import until
from test_fmp_training import TINY, faces, scenes  # noqa: F401 - fixtures

distributed = pytest.importorskip("distributed")


@contextlib.contextmanager
def local_cluster(count):
    with distributed.LocalCluster(
        n_workers=count, threads_per_worker=1, dashboard_address="127.0.0.1:0", host="127.0.0.1", memory_limit=0
    ) as cluster:
        yield cluster


@pytest.fixture(scope="module")
def cluster():
    """Two processes."""
    with local_cluster(2) as cluster:
        yield cluster


@pytest.fixture
def scheduler(cluster):
    """The address of a cluster of two processes, both there: one that was killed before has been started anew."""
    until(lambda: len(cluster.scheduler.workers) == 2)
    return cluster.scheduler_address


def expected(photos, rows):
    return {row["drawing"]: expected_svg(photo) for row, photo in zip(rows, photos, strict=True)}


@pytest.mark.parametrize("send", [False, True], ids=["shared folder", "sent along"])
def test_a_cluster_draws_the_same_files(scheduler, tmp_path, send):
    photos = put_photos(tmp_path / "in", 6)
    alone, rows_alone = run_batch(photos, tmp_path / "alone", formats=("svg", "png"))
    with cluster_engine(scheduler) as engine:
        assert engine.width == 2
        summary, rows = run_batch(photos, tmp_path / "out", engine, formats=("svg", "png"), send=send)
        again, _ = run_batch(photos, tmp_path / "out", engine, formats=("svg", "png"), send=send)
    assert (alone.drawn, summary.drawn, again.drawn, again.kept) == (6, 6, 0, 6)
    for suffix in (".svg", ".png"):
        assert files_of(tmp_path / "out", suffix) == files_of(tmp_path / "alone", suffix)
    assert files_of(tmp_path / "out") == expected(photos, rows)
    for row in (*rows, *rows_alone):
        del row["seconds"]
    assert rows == rows_alone


def process_of_worker(_):
    return os.getpid()


def test_a_worker_killed_in_the_middle_loses_nothing(scheduler, tmp_path):
    photos, killed = put_photos(tmp_path / "in", 24), []
    with cluster_engine(scheduler) as engine:

        def watch(summary):
            if summary.photos == 4:
                killed.append(engine.executor.submit(process_of_worker, 0).result())
                os.kill(killed[0], signal.SIGKILL)

        summary, rows = run_batch(photos, tmp_path / "out", engine, watch, send=True)
    assert killed
    assert (summary.photos, summary.drawn, summary.failed) == (24, 24, 0)
    assert [row["photo"] for row in rows] == [*map(str, photos)]
    assert files_of(tmp_path / "out") == expected(photos, rows)


def die_for_one(number):
    if number == 1:
        os.kill(os.getpid(), signal.SIGKILL)
    return number


def test_what_kills_every_worker_is_given_up(tmp_path):
    with local_cluster(2) as cluster:
        cluster.scheduler.allowed_failures = 1
        with cluster_engine(cluster.scheduler_address) as engine:
            # That one last: whatever waits at a worker that dies is suspected with what killed it.
            assert [engine.executor.submit(die_for_one, number).result() for number in (0, 2)] == [0, 2]
            with pytest.raises(engine.died):
                engine.executor.submit(die_for_one, 1).result()


def test_errors_and_the_order_come_back(scheduler):
    with cluster_engine(scheduler) as engine:
        assert list(in_order(engine, process_of_worker, range(40)))
        assert list(in_order(engine, functools.partial(pow, 2), range(40))) == [2**k for k in range(40)]
        with pytest.raises(BadInput, match="cannot be read"):
            engine.executor.submit(storage.read_bytes, "/no/such/file").result()


@pytest.mark.slow
def test_training_on_a_cluster_ends_the_same(scheduler, faces, scenes):  # noqa: F811 - fixtures
    quick = TINY.replace(rounds=1)
    alone = train(faces[:3], scenes[-4:], quick)
    with cluster_engine(scheduler) as engine:
        together = train(faces[:3], scenes[-4:], quick, share=functools.partial(in_order, engine))
    assert together.rounds == alone.rounds
    assert (together.model.filters == alone.model.filters).all()


def test_who_cannot_be_reached_is_said():
    with pytest.raises(BadInput, match="cannot be reached"), cluster_engine("nonsense://127.0.0.1:1"):
        pass


def test_a_cluster_without_workers_is_said():
    with (
        local_cluster(0) as cluster,
        pytest.raises(BadInput, match="has no workers"),
        cluster_engine(cluster.scheduler_address),
    ):
        pass


def test_workers_with_another_limner_are_refused(scheduler, monkeypatch):
    monkeypatch.setattr("limner.batch.cluster.__version__", "9.9")
    with pytest.raises(BadInput, match=r"has limner .*, expected 9\.9"), cluster_engine(scheduler):
        pass


def test_the_command_draws_on_a_cluster(scheduler, tmp_path):
    photos = put_photos(tmp_path / "in", 2)
    command = [sys.executable, "-m", "limner", "batch", tmp_path / "in", "-o", tmp_path / "out", "--json"]
    command += ["--scheduler", scheduler, "--send", "--style", "splines", "--sidecars"]
    ran = subprocess.run(command, capture_output=True, text=True, check=True, cwd=tmp_path)
    assert report_of(ran)["drawn"] == 2
    assert ran.stderr == ""
    assert files_of(tmp_path / "out") == expected(photos, rows_of(tmp_path / "out"))


@pytest.fixture
def face_for_all(tmp_path):
    """Settings that take the face from a file, for photos that have no folder."""
    photo = put_photo(tmp_path / "face" / "a.png", 1)
    return QUICK.assign("detect.detector", "file").assign("detect.file", str(photo.with_suffix(".json")))


@pytest.mark.parametrize("kind", ["memory", "file"])
def test_photos_and_drawings_behind_urls(tmp_path, face_for_all, kind):
    base = "memory://batch" if kind == "memory" else f"file://{tmp_path}/store"
    photos = put_photos(tmp_path / "in", 3)
    for photo in photos:
        remote.write(f"{base}/in/{photo.name}", photo.read_bytes())
    remote.write(f"{base}/in/notes.txt", b"no photo")
    urls = list(remote.listed(f"{base}/in/*.png", [".png"]))
    assert urls == list(remote.listed(f"{base}/in/", [".png"]))
    assert [os.path.basename(url) for url in urls] == [photo.name for photo in photos]
    out, changes = tmp_path / "out", {"settings": face_for_all, "store": f"{base}/out"}
    with ThreadPoolExecutor(1) as here:
        summary, rows = run_stored([*urls, f"{base}/in/gone.png"], out, Engine(here, 1), **changes)
        again, _ = run_stored(urls, out, Engine(here, 1), **changes)
    assert (summary.drawn, summary.failed, again.drawn, again.kept) == (3, 1, 0, 3)
    assert files_of(out) == {}
    for row in rows[:3]:
        assert remote.read(f"{base}/out/{row['drawing']}", 10**6).startswith(b"<?xml")


def run_stored(photos, out, engine, settings, store):
    """``run_batch`` with drawings that go to an URL."""
    order = order_for(out, settings)
    order = dataclasses.replace(order, store=store, recipe=dataclasses.replace(order.recipe, out=store))
    summary = Summary(9)
    draw_batch(photos, engine, order, summary, lambda told: None)
    return summary, rows_of(out)


def test_photos_from_a_web_server(scheduler, tmp_path):
    photos = put_photos(tmp_path / "in", 2)
    quiet = type("Quiet", (http.server.SimpleHTTPRequestHandler,), {"log_message": lambda *_: None})
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(quiet, directory=str(tmp_path / "in")))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    base = f"http://127.0.0.1:{server.server_port}"
    settings = QUICK.assign("detect.detector", "file").assign("detect.file", str(photos[0].with_suffix(".json")))
    urls = [f"{base}/{photo.name}?size=full" for photo in photos]
    with cluster_engine(scheduler) as engine:
        summary, rows = run_batch([*urls, f"{base}/gone.png"], tmp_path / "out", engine, settings=settings)
    server.shutdown()
    server.server_close()
    assert (summary.drawn, summary.failed) == (2, 1)
    assert rows[0]["drawing"].startswith("p000-")
    assert "cannot be read" in rows[2]["error"]


def test_kinds_of_urls_that_are_not_there_are_said():
    with pytest.raises(BadInput, match=r"no such kind|needs a package"):
        remote.read("nonsense://a/b.jpg", 100)
