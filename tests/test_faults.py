"""Kills at random moments, full disks, folders that cannot be written, clocks that jump, two processes at once."""

import ast
import asyncio
import os
import random
import re
import resource
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import limner
from batches import expected_svg, files_of, leftovers, put_photo, put_photos, report_of, rows_of
from drawings import of
from limner import storage
from limner.errors import BadInput
from limner.studio.folder import own_folder
from limner.studio.jobs import Jobs
from limner.studio.orders import Order
from limner.studio.visitors import HeldDrawing
from limner.targets.fake_grbl import FakeGrbl
from limner.targets.journal import Journal, Place
from limner.targets.send import Control, send
from plotters import Served, counted, grbl, inked, settled
from processes import PATIENCE_S, begun, until

ROOT = Path(__file__).parents[1]
LINES = of(*[[[10 + 5 * k, 10], [10 + 5 * k, 50]] for k in range(12)])
NOWHERE = "/proc/limner"
"""A folder that nobody can make, not even root."""


def command(*words):
    return [sys.executable, "-m", "limner", *map(str, words)]


def draw_command(tmp_path, out):
    photo = put_photo(tmp_path / "in" / "p.png", 3)
    return command("draw", photo, "--style", "splines", "--landmarks", photo.with_suffix(".json"), "-o", out)


def small_files(size):
    """For a child: the disk is full after so many bytes of a file; writing beyond is an error, not a signal."""

    def limit():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))

    return limit


# Killed.

WRITE = """
import sys
from limner.storage import write_whole
for k in range(10**9):
    write_whole(sys.argv[1], bytes([k % 251]) * 2**21)
"""


def test_an_output_is_the_old_or_the_new_whatever_kills_the_writer(tmp_path):
    """What every command writes is written by this function."""
    out, random_s = tmp_path / "out", random.Random(0)
    out.write_bytes(b"old")
    for _ in range(6):
        before = out.stat().st_mtime_ns
        with begun([sys.executable, "-c", WRITE, out]) as process:

            def written(before=before, process=process):
                return out.stat().st_mtime_ns != before or process.poll() is not None

            until(written, look_s=0.002)
            time.sleep(random_s.uniform(0, 0.05))
            process.kill()
        data = out.read_bytes()
        assert len(data) == 2**21
        assert len(set(data)) == 1


def test_all_files_are_written_whole():
    """Nothing in the package opens a file to write it in place, but what is made for that, or is for nobody else."""
    ours = {
        "storage/files.py": "whole or not at all",
        "batch/manifest.py": "a row is taken back where the disk is full",
        "studio/jobs.py": "in a passing folder",
        "studio/shelf.py": "beside, then renamed",
    }
    found = {
        str(path.relative_to(ROOT / "src" / "limner"))
        for path in (ROOT / "src" / "limner").rglob("*.py")
        if "evaluate" not in path.parts
        and re.search(r"write_bytes|write_text|open\([^)]*[\"'][wax]b?\+?[\"']", path.read_text())
    }
    assert found <= set(ours)


def test_a_killed_draw_leaves_the_old_or_the_new(tmp_path):
    out, random_s = tmp_path / "p.svg", random.Random(1)
    words = draw_command(tmp_path, out)
    began = time.monotonic()
    subprocess.run(words, check=True, capture_output=True)
    took, new = time.monotonic() - began, out.read_bytes()
    for share in (0.5, random_s.uniform(0.6, 0.9), 0.98):
        out.write_bytes(b"old")
        with begun(words, stderr=subprocess.DEVNULL) as process:
            time.sleep(share * took)
            process.kill()
        assert out.read_bytes() in (b"old", new)
    subprocess.run(words, check=True, capture_output=True)
    assert out.read_bytes() == new


def test_a_killed_batch_goes_on_and_nothing_is_broken(tmp_path):
    photos, out = put_photos(tmp_path / "in", 30), tmp_path / "out"
    words = command("batch", tmp_path / "in", "-o", out, "--workers", "1", "--style", "splines", "--sidecars", "--json")
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    # From a list whose last name never comes: it cannot be over before it is killed.
    with begun([*words[:4], "-", *words[5:]], stdin=subprocess.PIPE, start_new_session=True, **quiet) as run:
        run.stdin.write(b"".join(b"%s\n" % os.fsencode(photo) for photo in photos[:-1]))
        run.stdin.flush()
        until(lambda: run.poll() is not None or len(list(out.glob("*.svg"))) >= 5)
        assert run.poll() is None
        os.killpg(run.pid, signal.SIGKILL)
    want = {photo.stem: expected_svg(photo) for photo in photos}
    done = {name.rpartition(".")[0]: data for name, data in files_of(out).items()}
    assert 5 <= len(done) < 30
    assert set(done.values()) <= set(want.values()), "what is there is whole"
    report = report_of(subprocess.run(words, capture_output=True, text=True, check=True))
    assert report["kept"] + report["drawn"] == 30
    assert sorted(files_of(out).values()) == sorted(want.values())
    assert len(rows_of(out)) == 30


def test_an_ended_connection_of_the_terminal_stops_with_the_pen_up(tmp_path):
    (tmp_path / "d.svg").write_bytes(limner.to_svg(LINES))
    with Served(FakeGrbl(), step_s=0.005) as served:
        words = command("send", "d.svg", "--to", f"grbl:{served.port}", "--yes")
        with begun(words, cwd=tmp_path, stderr=subprocess.PIPE) as process:
            until(lambda: process.poll() is not None or len(served.fake.ink) >= 3)
            served.step_s = 0.15
            process.stderr.close()
            process.send_signal(signal.SIGHUP)
            process.wait(PATIENCE_S)
        assert process.returncode >= 0, "it ended by itself, whatever it could still say to a closed terminal"
        assert not served.fake.pen_down
        assert served.fake.breaches == []
        assert (tmp_path / "d.svg.journal").exists(), "it can be gone on with"


# Two at once.


def test_two_processes_do_not_draw_by_one_journal(tmp_path):
    path = tmp_path / "journal"
    first = Journal(path, LINES, resume=False)
    first.begin(Place(0))
    first.reached(Place(3))
    written = path.read_bytes()
    for resume in (False, True):
        with pytest.raises(BadInput, match="another limner draws by this journal"):
            Journal(path, LINES, resume=resume)
    assert path.read_bytes() == written
    first.close()
    second = Journal(path, LINES, resume=True)
    assert second.place == Place(3)
    second.close()


def test_a_second_send_says_so_and_moves_nothing(tmp_path):
    (tmp_path / "d.svg").write_bytes(limner.to_svg(LINES))
    held = Journal(tmp_path / "d.svg.journal", LINES, resume=False)
    held.begin(Place(2))
    words = command("send", "d.svg", "--to", "fake:", "--yes")
    ran = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True)
    assert (ran.returncode, ran.stdout) == (2, "")
    assert "another limner draws by this journal" in ran.stderr
    held.close()


def test_two_writers_of_one_file_leave_it_whole(tmp_path):
    out = tmp_path / "out"
    texts = [bytes([65 + k]) * 2**20 for k in range(4)]
    threads = [threading.Thread(target=lambda t=t: [storage.write_whole(out, t) for _ in range(20)]) for t in texts]
    for thread in threads:
        thread.start()
    while any(thread.is_alive() for thread in threads):
        assert not out.exists() or out.read_bytes() in texts
    for thread in threads:
        thread.join()
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


# Full disks and folders that cannot be written.


@pytest.mark.parametrize("which", ["full", "no folder", "a file for a folder", "a folder for a file"])
def test_a_place_that_cannot_be_written_is_one_line_and_keeps_what_was_there(tmp_path, which):
    out, limit = tmp_path / "p.svg", None
    if which == "full":
        out.write_bytes(b"old")
        limit = small_files(200)
    elif which == "no folder":
        out = Path(NOWHERE) / "p.svg"
    elif which == "a file for a folder":
        out.write_bytes(b"old")
        out = out / "p.svg"
    else:
        out.mkdir()
    words = draw_command(tmp_path, out)
    ran = subprocess.run(words, capture_output=True, text=True, preexec_fn=limit)
    assert ran.returncode == 2
    (line,) = ran.stderr.strip().splitlines()
    assert re.fullmatch(r"limner: .*cannot be written \(.*\); choose another place", line)
    if which in ("full", "a file for a folder"):
        assert (tmp_path / "p.svg").read_bytes() == b"old"
    assert leftovers(tmp_path) == set()


@pytest.mark.skipif(os.geteuid() == 0 and not os.path.exists("/proc/self"), reason="needs /proc")
def test_a_home_that_cannot_be_written_stops_nothing(tmp_path, monkeypatch):
    words = draw_command(tmp_path, tmp_path / "p.svg")
    bare = {name: value for name, value in os.environ.items() if not name.startswith("XDG_")} | {"HOME": NOWHERE}
    subprocess.run(words, check=True, capture_output=True, env=bare)
    monkeypatch.setenv("HOME", NOWHERE)
    monkeypatch.delenv("XDG_STATE_HOME", raising=False)
    assert own_folder().is_dir()
    monkeypatch.setattr(Path, "home", lambda: (_ for _ in ()).throw(RuntimeError("no home")))
    assert own_folder().is_dir()


@pytest.mark.parametrize("line", [0, 1, 2, 7, 12])
def test_a_disk_that_fills_up_while_a_machine_draws_raises_the_pen(tmp_path, monkeypatch, line):
    """At each line of the journal; nothing that was written before is lost."""
    fake, target = grbl()
    journal = Journal(tmp_path / "journal", LINES, resume=False)
    write, count = os.write, iter(range(1000))
    monkeypatch.setattr(
        "limner.targets.journal.os.write", lambda file, data: write(file, data[: None if next(count) < line else 3])
    )
    with pytest.raises(BadInput, match="the journal cannot be written"):
        send(LINES, target, journal, Control(), lambda place, waits: None)
    monkeypatch.undo()
    assert not settled(fake).pen_down
    assert journal.place.stroke == line // 2
    journal.close()
    if line:
        again = Journal(tmp_path / "journal", LINES, resume=True)
        fresh, target = grbl()
        send(LINES, target, again, Control(), lambda place, waits: None)
        again.close()
        both = inked(fake) + inked(fresh)
        assert not counted(LINES.lines_mm) - both, "nothing is lost"
        assert sum((both - counted(LINES.lines_mm)).values()) <= 1, "at most the stroke in doubt is drawn twice"


class Made:
    """An order that would draw."""

    drawing, begins_s, seconds, name, ready = LINES, np.zeros(12), 1.0, "a machine", ""
    ran = False

    def run(self, journal, control, watch):
        self.ran = True
        return Place(12)


def studio_job(folder, made, monkeypatch=None):
    """Start a job in a loop of its own; the state that it comes to, or the error of its start."""

    async def go():
        jobs = Jobs(folder, lambda order, file: made, lambda: None)
        jobs.start(Order("sim:"), b"npz", HeldDrawing("d", "p", b"npz", {}), None)
        ends = time.monotonic() + PATIENCE_S
        while jobs.busy:
            assert time.monotonic() < ends
            await asyncio.sleep(0.01)
        return jobs.status

    return asyncio.run(go())


def test_a_studio_whose_folder_cannot_be_written_starts_no_machine(tmp_path):
    made = Made()
    with pytest.raises(BadInput, match="the job cannot be written down"):
        studio_job(Path(NOWHERE) / "job", made)
    (tmp_path / "job").write_text("a file")
    with pytest.raises(BadInput, match="the job cannot be written down"):
        studio_job(tmp_path / "job", made)
    assert not made.ran


def test_a_studio_whose_disk_is_full_starts_no_machine(tmp_path, monkeypatch):
    made, replace = Made(), os.replace

    def full(source, target):
        if str(target).endswith("plan.json"):
            raise OSError(28, "No space left on device")
        return replace(source, target)

    monkeypatch.setattr("limner.studio.shelf.os.replace", full)
    status = studio_job(tmp_path / "job", made)
    assert status.state == "error"
    assert "No space left on device" in status.error
    assert not made.ran
    monkeypatch.undo()
    assert studio_job(tmp_path / "job", made).state == "done"


# Clocks that jump.


def test_no_clock_that_can_be_set_is_read():
    """Only clocks that never jump are asked how much time has passed."""
    for path in (ROOT / "src" / "limner").rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
                assert (node.value.id, node.attr) not in {
                    ("time", "time"),
                    ("time", "time_ns"),
                    ("datetime", "now"),
                    ("datetime", "utcnow"),
                    ("datetime", "today"),
                    ("date", "today"),
                }, path


def test_a_clock_that_jumps_changes_nothing_while_a_machine_draws(tmp_path, monkeypatch):
    jumps = iter(range(10**9))
    monkeypatch.setattr(time, "time", lambda: (-1) ** next(jumps) * 1e9)
    monkeypatch.setattr(time, "time_ns", lambda: (-1) ** next(jumps) * 10**18)
    fake, target = grbl()
    journal = Journal(tmp_path / "journal", LINES, resume=False)
    assert send(LINES, target, journal, Control(), lambda place, waits: None) == Place(12)
    journal.close()
    assert inked(fake) == counted(LINES.lines_mm)
    assert fake.breaches == []
    assert studio_job(tmp_path / "job", Made()).state == "done"


# The table.


def test_every_test_that_the_table_names_exists():
    text = (ROOT / "docs" / "reliability.md").read_text()
    named = re.findall(r"`(test_\w+)\.py::(test_\w+)`", text)
    assert len(named) > 30
    for file, test in named:
        source = (ROOT / "tests" / f"{file}.py").read_text()
        assert re.search(rf"^(async )?def {test}\(", source, re.MULTILINE), f"{file}::{test}"
