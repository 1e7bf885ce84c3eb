"""The journal knows after any crash what is drawn, and never says more than that."""

from __future__ import annotations

import os

import numpy as np
import pytest
from hypothesis import given, strategies as st

from drawings import drawings, of
from limner import geometry
from limner.errors import BadInput
from limner.targets.journal import Journal, Place, fingerprint, runs_from, unfinished
from plotters import counted

DRAWING = of([[10, 10], [20, 10], [30, 10]], [[30, 10], [30, 20]], [[50, 50]], [[60, 60], [70, 70], [60, 60]])


def killed(journal):
    """As the system lets go of the file of a process that is killed."""
    os.close(journal._file)


def test_it_goes_on_where_it_ended(tmp_path):
    path = tmp_path / "j"
    journal = Journal(path, DRAWING, resume=False)
    assert (journal.place, journal.doubtful) == (Place(0), False)
    journal.begin(Place(0))
    killed(journal)
    journal = Journal(path, DRAWING, resume=True)
    assert journal.doubtful
    journal.reached(Place(1, 0))
    journal.begin(Place(1))
    journal.reached(Place(3, 1))
    journal.close()
    assert unfinished(path, DRAWING) == Place(3, 1)
    again = Journal(path, DRAWING, resume=True)
    assert (again.place, again.doubtful) == (Place(3, 1), False)
    again.reached(Place(4))
    again.close()
    assert not path.exists(), "nothing is left to go on with"
    assert unfinished(path, DRAWING) is None


def test_a_torn_line_is_as_if_never_written(tmp_path):
    path = tmp_path / "j"
    journal = Journal(path, DRAWING, resume=False)
    states = [(path.stat().st_size, Place(0), False)]
    for stroke in range(2):
        journal.begin(Place(stroke))
        states.append((path.stat().st_size, Place(stroke), True))
        journal.reached(Place(stroke + 1))
        states.append((path.stat().st_size, Place(stroke + 1), False))
    killed(journal)
    data = path.read_bytes()
    for cut in range(len(data) + 1):
        path.write_bytes(data[:cut])
        got = Journal(path, DRAWING, resume=True)
        _, place, doubtful = max((s for s in states if s[0] <= cut), default=(0, Place(0), False))
        assert (got.place, got.doubtful) == (place, doubtful), cut
        got.begin(Place(2, 0))
        killed(got)
        after = Journal(path, DRAWING, resume=True)
        assert after.place == Place(2, 0), "what follows is read"
        killed(after)


def test_every_line_is_on_the_disk_before_the_next_step(tmp_path, monkeypatch):
    synced = []
    monkeypatch.setattr(os, "fsync", lambda file: synced.append(os.fstat(file).st_size))
    journal = Journal(tmp_path / "j", DRAWING, resume=False)
    for stroke in range(3):
        journal.begin(Place(stroke))
        assert synced[-1] == (tmp_path / "j").stat().st_size
        journal.reached(Place(stroke + 1))
        assert synced[-1] == (tmp_path / "j").stat().st_size


def test_damage_other_drawings_and_full_disks_are_named(tmp_path, monkeypatch):
    path = tmp_path / "j"
    with pytest.raises(BadInput, match="nothing to resume"):
        Journal(path, DRAWING, resume=True)
    journal = Journal(path, DRAWING, resume=False)
    journal.begin(Place(0))
    journal.reached(Place(1))
    data = path.read_bytes()
    path.write_bytes(data.replace(b"begin 0", b"begin 1"))
    with pytest.raises(BadInput, match="damaged"):
        Journal(path, DRAWING, resume=True)
    path.write_bytes(data)
    with pytest.raises(BadInput, match="another drawing"):
        Journal(path, of([[1, 1], [2, 2]]), resume=True)
    with pytest.raises(BadInput, match="cannot be written"):
        Journal(tmp_path / "none" / "j", DRAWING, resume=False)
    monkeypatch.setattr(os, "write", lambda *_: 0)
    with pytest.raises(BadInput, match="no space"):
        journal.begin(Place(1))


@given(drawings(least=1), st.randoms())
def test_runs_cover_each_segment_once_from_any_place(drawing, random):
    lines = [geometry.without_repeats(line) for line in drawing.lines_mm]
    whole, place, drawn = counted(lines), Place(0), []
    while place.stroke < len(lines):
        line, places = runs_from(lines, place)
        assert len(line) == len(places)
        assert places[-1] > place
        reached = random.randrange(len(line))
        if len(line) == 1 or reached:
            drawn.append(line[: reached + 1])
        place = places[reached] if len(line) == 1 or reached else place
    got = counted(drawn)
    assert {s: n for s, n in got.items() if s[0] != s[1]} == {s: n for s, n in whole.items() if s[0] != s[1]}
    touched = {point for segment in got for point in segment}
    assert all(point in touched for segment in whole for point in segment), "dots are drawn, alone or with a line"


def test_fingerprints_tell_drawings_apart():
    assert fingerprint(DRAWING) == fingerprint(of(*(line + 1e-5 for line in DRAWING.lines_mm)))
    others = [of(*DRAWING.lines_mm[::-1]), of(*(line + 0.01 for line in DRAWING.lines_mm)), of(DRAWING.lines_mm[0])]
    others.append(of(np.concatenate(DRAWING.lines_mm[:2]), *DRAWING.lines_mm[2:]))
    assert len({fingerprint(other) for other in [DRAWING, *others]}) == 5
