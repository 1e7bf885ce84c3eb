"""Many photos: each drawn once, broken ones are rows, and whatever ends a run the next goes on from there."""

from __future__ import annotations

import errno
import io
import itertools
import json
import os
import re
import resource
import signal
import sqlite3
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import pytest
from hypothesis import given, strategies as st

from batches import (
    QUICK,
    expected_svg,
    files_of,
    leftovers,
    order_for,
    put_photo,
    put_photos,
    report_of,
    rows_of,
    run_batch,
)
from limner import storage
from limner.batch import lock, work
from limner.batch.engine import Engine, in_order, local_engine
from limner.batch.everything import draw_batch
from limner.batch.listing import check_words, photos_of
from limner.batch.manifest import COLUMNS, CSV, PARQUET, Manifest, Row
from limner.batch.names import drawing_name
from limner.batch.run import draw_all
from limner.batch.sheet import NAME as SHEET
from limner.batch.state import Known, State
from limner.batch.summary import Summary
from limner.batch.workers import WorkerDied, Workers
from limner.errors import BadInput
from processes import PATIENCE_S, begun, until

FIGURES = {"drawing": "a.svg", "error": "", "strokes": 3, "points": 9, "ink_mm": 1.5, "travel_mm": 0.5, "seconds": 0.1}


def listed(*words, stdin=b"", out=None):
    return list(photos_of([str(word) for word in words], io.BytesIO(stdin), out))


def test_photos_come_from_folders_patterns_lists_and_stdin(tmp_path):
    for name in ("b.jpg", "a.PNG", "notes.md", ".hidden.jpg", "deep/c.webp", ".git/d.jpg", "out/e.png"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).touch()
    (tmp_path / "list.txt").write_bytes(b"b.jpg\r\n\nsome where.jpg\ns3://x/y.jpg")
    (tmp_path / "list.csv").write_text('who,image\nAnn,"a,b.jpg"\nBob,b.jpg\n')
    (tmp_path / "plain.csv").write_text("b.jpg,1\nc.jpg,2\n")
    in_folder = [f"{tmp_path}/{name}" for name in ("a.PNG", "b.jpg", "deep/c.webp")]
    assert listed(tmp_path, out=tmp_path / "out") == in_folder
    assert listed(tmp_path) == [*in_folder, f"{tmp_path}/out/e.png"]
    assert listed(tmp_path / "*.jpg") == [f"{tmp_path}/b.jpg"]
    assert listed(tmp_path / "**/*.[wp]*", out=tmp_path / "out") == [f"{tmp_path}/deep/c.webp"]
    assert listed(tmp_path / "notes.md") == [f"{tmp_path}/notes.md"]
    assert listed(tmp_path / "list.txt") == [f"{tmp_path}/b.jpg", f"{tmp_path}/some where.jpg", "s3://x/y.jpg"]
    assert listed(tmp_path / "list.csv") == [f"{tmp_path}/a,b.jpg", f"{tmp_path}/b.jpg"]
    assert listed(tmp_path / "plain.csv") == [f"{tmp_path}/b.jpg", f"{tmp_path}/c.jpg"]
    assert listed("-", stdin=b"a b.jpg\nc.jpg\n") == ["a b.jpg", "c.jpg"]
    assert listed("-", stdin=b"a\nb.jpg\0c.jpg\0") == ["a\nb.jpg", "c.jpg"]
    assert os.fsencode(listed("-", stdin=b"\xff.jpg")[0]) == b"\xff.jpg"


@pytest.mark.parametrize("words", [(), ("gone.jpg",), ("none*.jpg",)])
def test_a_word_that_names_nothing_is_said_at_once(words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(BadInput, match=r"no photos named|no such file"):
        check_words(words)


@given(st.text(st.characters(exclude_characters="/\0"), max_size=300), st.integers(0), st.integers(0))
def test_names_of_drawings_are_plain_and_never_meet(stem, first, second):
    marks = [f"{number:064x}"[::-1] for number in (first, second)]
    names = [drawing_name(f"some/where/{stem}.jpg", mark) for mark in marks]
    assert names[0] == drawing_name(f"elsewhere/{stem}.jpg", marks[0])
    assert (names[0] == names[1]) == (marks[0][:12] == marks[1][:12])
    for name in names:
        assert len(name.encode()) < 120
        assert not re.search(r"[\s/\\:*?\"'<>|$&;`\x00-\x1f]", name)
        assert name[0] not in "-."


def test_odd_names_and_broken_files_are_rows(tmp_path):
    folder, out = tmp_path / "photos", tmp_path / "out"
    good = ["with space.png", "Ünïcødé 顔.png", "new\nline.png", "-dash.png", 'comma,quote".png']
    for shade, name in enumerate(good):
        put_photo(folder / name, shade)
    undecodable = put_photo(folder / os.fsdecode(b"\xff\xfe.png"), 20)
    twin = put_photo(folder / "twin.png", 0)
    (folder / "link.png").symlink_to(twin)
    (folder / "link.json").symlink_to(twin.with_suffix(".json"))
    (folder / "dangling.png").symlink_to(folder / "nowhere.png")
    (folder / "loop").symlink_to(folder)
    (folder / "empty.png").touch()
    (folder / "junk.png").write_bytes(b"no picture")
    os.mkfifo(folder / "pipe.png")
    command = [sys.executable, "-m", "limner", "batch", folder, "-o", out, "--workers", "1", "--style", "splines"]
    command += ["--sidecars", "--parquet", "--also", "png", "--json"]
    ran = subprocess.run(command, capture_output=True, text=True, check=True)
    report, rows = report_of(ran), rows_of(out)
    assert (report["photos"], report["drawn"], report["kept"], report["failed"]) == (12, 6, 2, 4)
    assert ran.stderr == ""
    by_name = {os.path.basename(row["photo"]): row for row in rows}
    errors = {name: row["error"] for name, row in by_name.items() if row["error"]}
    assert set(errors) == {"dangling.png", "empty.png", "junk.png", "pipe.png"}
    assert "empty" in errors["empty.png"]
    assert all(not by_name[name]["strokes"] and not by_name[name]["drawing"] for name in errors)
    assert by_name["twin.png"]["drawing"] == by_name["link.png"]["drawing"] == by_name["with space.png"]["drawing"]
    assert set(files_of(out)) == {row["drawing"] for row in rows if row["drawing"]}
    assert len(files_of(out)) == len(files_of(out, ".png")) == 6
    for name in good:
        assert (out / by_name[name]["drawing"]).read_bytes() == expected_svg(folder / name)
    assert r"\udcff" in next(row["photo"] for row in rows if row["photo"].endswith(r"\udcfe.png"))
    assert undecodable.exists()
    assert leftovers(out) == set()
    sheet = (out / SHEET).read_text()
    assert "comma,quote&quot;.png" in sheet
    assert not re.search(r"(src|href)=\"(?!data:|[^:\"]*\")", sheet)


def test_parquet_holds_the_rows_of_the_csv(tmp_path):
    from pyarrow import parquet

    photos = [*put_photos(tmp_path / "in", 2), tmp_path / "gone\n.jpg"]
    _, rows = run_batch(photos, tmp_path / "out", parquet=True)
    table = parquet.read_table(tmp_path / "out" / PARQUET).to_pylist()
    assert [*table[0]] == [*COLUMNS]
    assert [row["photo"] for row in table] == [row["photo"] for row in rows] == [*map(str, photos)]
    assert [row["strokes"] for row in table] == [*(int(row["strokes"]) for row in rows[:2]), None]
    assert table[2]["error"] == rows[2]["error"] != ""


class Refusing(ThreadPoolExecutor):
    """Does nothing but look at files."""

    def submit(self, fn, /, *args, **kwargs):
        assert fn is not work.draw_one, "drawn again"
        return super().submit(fn, *args, **kwargs)


def test_only_what_is_missing_or_changed_is_drawn(tmp_path):
    photos, out = put_photos(tmp_path / "in", 4), tmp_path / "out"
    (tmp_path / "in" / "p003.png").write_bytes(b"junk")
    first, rows = run_batch(photos, out)
    assert (first.drawn, first.kept, first.failed) == (3, 0, 1)
    with Refusing(1) as refusing:
        again, rows_again = run_batch(photos, out, Engine(refusing, 1))
    assert (again.drawn, again.kept, again.failed) == (0, 3, 1)
    assert rows_again == rows
    (out / rows[0]["drawing"]).unlink()
    put_photo(photos[1], 77)
    os.rename(photos[2], tmp_path / "in" / "moved.png")
    os.rename(photos[2].with_suffix(".json"), tmp_path / "in" / "moved.json")
    third, rows_third = run_batch([*photos[:2], tmp_path / "in" / "moved.png"], out)
    assert (third.drawn, third.kept, third.failed) == (2, 1, 0)
    assert (out / rows[0]["drawing"]).read_bytes() == expected_svg(photos[0])
    assert (out / rows_third[1]["drawing"]).read_bytes() == expected_svg(photos[1])
    assert rows_third[2]["drawing"] == rows[2]["drawing"]


def test_other_settings_draw_anew_and_back_again(tmp_path):
    photos, out = put_photos(tmp_path / "in", 1), tmp_path / "out"
    run_batch(photos, out)
    before = files_of(out)
    wide, _ = run_batch(photos, out, settings=QUICK.assign("page.size", "a4"))
    assert wide.drawn == 1
    assert files_of(out).keys() == before.keys()
    assert files_of(out) != before
    back, _ = run_batch(photos, out)
    assert back.drawn == 1
    assert files_of(out) == before


def test_a_face_beside_the_photo_that_moved_is_drawn_anew(tmp_path):
    (photo,), out = put_photos(tmp_path / "in", 1), tmp_path / "out"
    run_batch([photo], out)
    shifted = json.loads(photo.with_suffix(".json").read_text())
    shifted["points_px"][30][0] += 5
    photo.with_suffix(".json").write_text(json.dumps(shifted))
    again, _ = run_batch([photo], out)
    assert again.drawn == 1


def test_memory_does_not_grow_with_the_list(tmp_path):
    taken = itertools.count()
    put_photo(tmp_path / "a.png", 1)
    names = (f"{tmp_path}/{'a' if k % 3 else 'gone'}.png" for k in iter(lambda: next(taken), 3000))
    with State.opened(tmp_path) as state, ThreadPoolExecutor(1) as here:
        engine = Engine(here, 2)
        for done, _ in enumerate(draw_all(names, engine, order_for(tmp_path / "out"), state)):
            ahead = next(taken)
            assert ahead - 2 * done - 2 <= 2 * engine.ahead + 4
            if done == 500:
                break


# What workers of the tests do.


def settings_of_threads():
    import cv2
    from threadpoolctl import threadpool_info

    return cv2.getNumThreads(), {pool["num_threads"] for pool in threadpool_info()}, os.environ["LIMNER_CORES"]


def die_once(mark):
    if not os.path.exists(mark):
        open(mark, "w").close()
        os.kill(os.getpid(), signal.SIGKILL)
    return os.getpid()


def die():
    os.kill(os.getpid(), signal.SIGKILL)


def twice(number):
    return 2 * number


def refuse():
    raise BadInput("no")


def test_workers_use_one_thread_and_survive_what_kills_them(tmp_path):
    with local_engine(2) as engine:
        assert isinstance(engine.executor, Workers)
        assert list(in_order(engine, twice, range(100))) == [2 * number for number in range(100)]
        assert engine.executor.submit(settings_of_threads).result() == (1, {1}, "1")
        assert engine.executor.submit(die_once, str(tmp_path / "mark")).result() in engine.executor.pids()
        with pytest.raises(WorkerDied, match="signal 9"):
            engine.executor.submit(die).result()
        with pytest.raises(BadInput, match=r"^no$"):
            engine.executor.submit(refuse).result()
        assert engine.executor.submit(twice, 4).result() == 8
        pids = engine.executor.pids()
        assert len(pids) <= 2
    assert not any(os.path.exists(f"/proc/{pid}") for pid in pids)


def test_a_worker_killed_in_the_middle_loses_nothing(tmp_path):
    photos, killed = put_photos(tmp_path / "in", 12), []
    with local_engine(2) as engine:

        def watch(summary):
            if summary.photos == 3:
                killed.extend(engine.executor.pids())
                for pid in killed:
                    os.kill(pid, signal.SIGKILL)

        summary, rows = run_batch(photos, tmp_path / "out", engine, watch)
    assert killed
    assert (summary.drawn, summary.failed) == (12, 0)
    assert [row["photo"] for row in rows] == [*map(str, photos)]
    assert files_of(tmp_path / "out") == {
        row["drawing"]: expected_svg(photo) for row, photo in zip(rows, photos, strict=True)
    }


def test_a_photo_that_kills_its_workers_is_a_row(tmp_path):
    class Deadly(ThreadPoolExecutor):
        def submit(self, fn, /, *args, **kwargs):
            if fn is work.draw_one and args[0].photo.endswith("p001.png"):
                return super().submit(self.kill)
            return super().submit(fn, *args, **kwargs)

        def kill(self):
            raise WorkerDied("its worker died")

    photos, out = put_photos(tmp_path / "in", 3), tmp_path / "out"
    with Deadly(1) as deadly:
        summary, rows = run_batch(photos, out, Engine(deadly, 1))
    assert (summary.drawn, summary.failed) == (2, 1)
    assert rows[1]["error"] == "its worker died"
    again, _ = run_batch(photos, out)
    assert (again.drawn, again.kept) == (1, 2)


def test_ctrl_c_keeps_what_is_done(tmp_path):
    photos, out = put_photos(tmp_path / "in", 80), tmp_path / "out"
    words, how = [sys.executable, "-m", "limner", "batch"], ["-o", out, "--workers", "2"]
    how += ["--style", "splines", "--sidecars"]
    pipes = {"stdin": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    # From a list whose last name never comes: it cannot be over before it is interrupted.
    with begun([*words, "-", *how], start_new_session=True, **pipes) as running:
        running.stdin.write("".join(f"{photo}\n" for photo in photos[:-1]))
        running.stdin.flush()
        until(lambda: (out / CSV).exists() and len((out / CSV).read_bytes().splitlines()) > 3)
        os.killpg(running.pid, signal.SIGINT)
        assert running.wait(PATIENCE_S) == 130
        told = running.stderr.read()
    assert re.fullmatch(r"\d+ photos: .*goes on from here\n+limner: interrupted\n", told)
    assert leftovers(out) == set()
    (done,) = re.findall(r"^\d+", told)
    assert len(rows_of(out)) == int(done) >= 3
    ran = subprocess.run([*words, tmp_path / "in", *how, "--json"], capture_output=True, text=True, check=True)
    report = report_of(ran)
    assert report["kept"] >= int(done)
    assert report["kept"] + report["drawn"] == report["photos"] == len(files_of(out)) == 80


def test_one_run_at_a_time(tmp_path):
    (photo,), out = put_photos(tmp_path / "in", 1), tmp_path / "out"
    out.mkdir()
    with lock.held(out) as before:
        assert before == ""
        with pytest.raises(BadInput, match=rf"process {os.getpid()} on .*; wait for its end"):
            run_batch([photo], out)
        assert not (out / CSV).exists()
    with pytest.raises(ZeroDivisionError), lock.held(out):
        1 / 0  # noqa: B018 - the run ends badly
    with lock.held(out) as before:
        assert before.startswith(f"process {os.getpid()} on ")
    assert run_batch([photo], out)[0].drawn == 1


class Full(io.BytesIO):
    def write(self, data):
        raise OSError(errno.ENOSPC, "No space left on device")


def test_a_full_disk_is_one_line_and_nothing_is_half_written(tmp_path, monkeypatch):
    photos, out = put_photos(tmp_path / "in", 6), tmp_path / "out"
    opened, whole = os.fdopen, itertools.count()

    def fdopen(handle, *how):
        if next(whole) < 3:
            return opened(handle, *how)
        os.close(handle)
        return Full()

    with monkeypatch.context() as patch:
        patch.setattr("os.fdopen", fdopen)
        with pytest.raises(BadInput, match="No space left on device"):
            run_batch(photos, out)
    assert len(files_of(out)) == 3
    assert leftovers(out) == set()
    again, rows = run_batch(photos, out)
    assert (again.kept, again.drawn) == (3, 3)
    assert files_of(out) == {row["drawing"]: expected_svg(photo) for row, photo in zip(rows, photos, strict=True)}


def test_workers_that_meet_a_full_disk_end_the_run(tmp_path):
    put_photos(tmp_path / "in", 6)
    command = [sys.executable, "-m", "limner", "batch", tmp_path / "in", "-o", tmp_path / "out", "--workers", "1"]
    command += ["--style", "splines", "--sidecars", "--also", "npz", "--sheet", "0"]

    def small_files():
        resource.setrlimit(resource.RLIMIT_FSIZE, (4096, resource.RLIM_INFINITY))

    (tmp_path / "out").mkdir()
    with State.opened(tmp_path / "out"):
        pass  # the database is larger than that already when it is empty
    ran = subprocess.run(command, capture_output=True, text=True, preexec_fn=small_files)
    assert ran.returncode == 2
    assert re.fullmatch(r"limner: .*(File too large|full|disk I/O error).*\n", ran.stderr)
    assert leftovers(tmp_path / "out") <= {".state.sqlite-journal"}
    assert subprocess.run(command, capture_output=True).returncode == 0
    assert len(files_of(tmp_path / "out")) == len(files_of(tmp_path / "out", ".npz")) == 6


def test_the_manifest_and_the_state_stay_whole_on_a_full_disk(tmp_path):
    with Manifest.written(tmp_path / CSV) as rows:
        rows.add(Row("a.jpg"))
        before, limits = (tmp_path / CSV).read_bytes(), resource.getrlimit(resource.RLIMIT_FSIZE)
        resource.setrlimit(resource.RLIMIT_FSIZE, (len(before) + 5, limits[1]))
        try:
            with pytest.raises(BadInput, match=r"manifest.csv: cannot be written \(File too large\)"):
                rows.add(Row("b.jpg"))
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        assert (tmp_path / CSV).read_bytes() == before
    with State.opened(tmp_path) as state:
        state.keep_done("a", Known("m", FIGURES, b""))
        state.commit()
        state._base.execute("PRAGMA max_page_count = 8")
        with pytest.raises(BadInput, match="full"):
            state.keep_done("b", Known("m", FIGURES, bytes(10**6)))
    with State.opened(tmp_path) as state:
        assert state.done("a") == Known("m", FIGURES, b"")
        assert state.done("b") is None


@pytest.mark.parametrize(
    "damage",
    [
        {"drawing": "../a.svg"},
        {"drawing": None},
        {"strokes": "3"},
        {"photo": "b.jpg"},
        {"other": 1},
    ],
)
def test_what_was_kept_and_is_damaged_is_as_if_it_was_never_drawn(tmp_path, damage):
    with State.opened(tmp_path) as state:
        state.keep_done("a", Known("m", FIGURES | damage, b""))
        state.keep_done("b", Known("m", FIGURES, b""))
        assert state.done("a") is None
        assert state.done("b") is not None


def test_a_state_of_another_version_is_refused(tmp_path):
    with State.opened(tmp_path):
        pass
    base = sqlite3.connect(tmp_path / ".state.sqlite")
    base.execute("PRAGMA user_version = 99")
    base.close()
    with pytest.raises(BadInput, match="another version"), State.opened(tmp_path):
        pass
    (tmp_path / ".state.sqlite").write_bytes(b"no database" * 1000)
    with pytest.raises(BadInput, match="cannot be read or written"), State.opened(tmp_path):
        pass


def test_a_list_of_nothing_is_an_error(tmp_path):
    with pytest.raises(BadInput, match="no photos there"):
        run_batch([], tmp_path / "out")


def test_the_sheet_shows_drawings_made_before_without_a_tile(tmp_path):
    photos, out = put_photos(tmp_path / "in", 2), tmp_path / "out"
    run_batch(photos, out, tiles=0)
    path = re.search(r'd="(M [^"]*)"', (out / rows_of(out)[0]["drawing"]).read_text())[1]
    run_batch(photos, out)
    assert path in (out / SHEET).read_text()


def test_a_trajectory_for_each_drawing(tmp_path):
    from limner.types import JointTrajectory

    pytest.importorskip("toppra")
    (photo,), out = put_photos(tmp_path / "in", 1), tmp_path / "out"
    summary, rows = run_batch([photo], out, formats=("svg", "json", "trajectory"))
    assert summary.drawn == 1
    stem = rows[0]["drawing"].removesuffix(".svg")
    motion = storage.load(JointTrajectory, out / f"{stem}.trajectory.json")
    assert motion.t_s[-1] > 1


def test_changes_between_hashing_and_drawing_are_noticed(tmp_path):
    (photo,), out = put_photos(tmp_path / "in", 1), tmp_path / "out"

    class Late(ThreadPoolExecutor):
        def submit(self, fn, /, *args, **kwargs):
            if fn is work.draw_one:
                put_photo(photo, 99)
            return super().submit(fn, *args, **kwargs)

    with Late(1) as late:
        summary, rows = run_batch([photo], out, Engine(late, 1))
    assert summary.failed == 1
    assert "changed while" in rows[0]["error"]
    again, _ = run_batch([photo], out)
    assert again.drawn == 1
    assert files_of(out) == {rows_of(out)[0]["drawing"]: expected_svg(photo)}


def test_a_summary_counts_what_it_is_told(tmp_path):
    summary, rows = run_batch([*put_photos(tmp_path / "in", 2), "gone.jpg"], tmp_path / "out")
    assert summary.strokes == sum(int(row["strokes"]) for row in rows[:2])
    assert summary.ink_mm == pytest.approx(sum(float(row["ink_mm"]) for row in rows[:2]))
    assert summary.errors.total() == 1
    with ThreadPoolExecutor(1) as here:
        fresh = Summary(0)
        draw_batch(iter(["x.jpg"]), Engine(here, 1), order_for(tmp_path / "other"), fresh, lambda told: None)
    assert not (tmp_path / "other" / SHEET).exists()


def test_workers_keep_freed_memory():
    """What Dask asks of the C library costs a fault for every page of every array; workers take it back."""
    program = (
        "import resource, numpy as np; from limner.batch.threads import hold_threads; {}\n"
        "faults = lambda: resource.getrusage(resource.RUSAGE_SELF).ru_minflt\n"
        "np.ones(2**17).sum(); before = faults()\n"
        "for _ in range(200): np.ones(2**17).sum()\n"
        "print(faults() - before)"
    )
    counts = [
        int(subprocess.run(
            [sys.executable, "-c", program.format(held)],
            env=os.environ | {"MALLOC_TRIM_THRESHOLD_": "65536"}, capture_output=True, check=True,
        ).stdout)
        for held in ("", "hold_threads()")
    ]  # fmt: skip
    assert counts[0] > 20_000
    assert counts[1] < 2_000
