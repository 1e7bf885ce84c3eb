"""Every reader of outside data keeps its promise over the corpus and changes of it: a value, or one line, in time."""

from __future__ import annotations

import io
import logging
import random
import time
import warnings
import zipfile

import fuzz
import pytest
from fuzz import contract, seeds
from fuzz.mutate import mutated
from fuzz.run import run

from limner.errors import BadInput, LimnerError

EXECUTIONS = 200
CPU_S = 0.7
"""For each harness; on a slow machine fewer are run."""

HARNESSES = fuzz.harnesses()


@pytest.mark.parametrize("name", HARNESSES)
def test_the_promise_is_kept(name):
    outcome = run(name, EXECUTIONS, cpu_s=CPU_S)
    assert not outcome.broken, "\n".join(f"{data[:200]!r}\n{text}" for data, text in outcome.broken.values())
    assert outcome.executions > len(fuzz.corpus(name))


@pytest.mark.parametrize("name", HARNESSES)
def test_every_harness_has_a_corpus_that_reaches_its_reader(name):
    inputs = fuzz.corpus(name)
    assert inputs
    assert any(contract.check(HARNESSES[name], data) for data in inputs) or name in ("grbl", "ebb", "rosbridge")
    assert sum(map(len, inputs)) < 500_000


def test_seeds_are_the_same_whenever_they_are_written(monkeypatch):
    made = list(seeds._all())
    for name in ("asctime", "ctime"):
        monkeypatch.setattr(time, name, lambda *_: "another time")
    monkeypatch.setattr(time, "time", lambda: 1e9)
    assert list(seeds._all()) == made
    (mat,) = [data for harness, _, data in made if harness == "mat"]
    assert (fuzz.CORPUS / "mat" / "seed-tiny.mat").read_bytes() == mat


def test_the_same_seed_gives_the_same_run():
    assert run("hpgl", 50).accepted == run("hpgl", 50).accepted


def raising(error):
    def read(data):
        raise error

    return read


@pytest.mark.parametrize("error", [ValueError("x"), RecursionError(), MemoryError(), UserWarning("x"), KeyError("x")])
def test_any_other_error_is_a_finding(error):
    with pytest.raises(type(error)):
        contract.check(raising(error), b"")


def warning(data):
    warnings.warn("odd", stacklevel=1)


def logging_it(data):
    logging.getLogger("some.library").error("odd")


class Long(LimnerError):
    def __str__(self):
        return "two\nlines"


@pytest.mark.parametrize(
    ("reader", "error"),
    [(warning, UserWarning), (logging_it, contract.Broken), (raising(Long()), contract.Broken)],
)
def test_whatever_else_is_said_is_a_finding(reader, error):
    with pytest.raises(error):
        contract.check(reader, b"")


def test_what_is_refused_in_one_line_is_none():
    assert contract.check(len, b"")
    assert not contract.check(raising(BadInput("x: is wrong")), b"")


def test_a_run_keeps_what_breaks_a_promise_once_for_each_place(monkeypatch):
    monkeypatch.setattr("fuzz.run.harnesses", lambda: {"hpgl": raising(KeyError("x"))})
    outcome = run("hpgl", 20)
    assert outcome.executions == len(fuzz.corpus("hpgl")) + 20
    assert outcome.accepted == 0
    ((place, (data, told)),) = outcome.broken.items()
    assert place.startswith("KeyError ")
    assert data == fuzz.corpus("hpgl")[0]
    assert "KeyError: 'x'" in told


@pytest.mark.parametrize("name", ["hpgl", "photo", "npz"])
def test_changed_inputs_differ_and_archives_can_still_be_opened(name):
    inputs, chance = fuzz.corpus(name), random.Random(0)
    changed = [mutated(inputs[k % len(inputs)], chance, inputs) for k in range(300)]
    assert sum(data not in inputs for data in changed) > 200
    assert len(set(changed)) > 150
    if name == "npz":
        assert sum(zipfile.is_zipfile(io.BytesIO(data)) for data in changed) > 200


def test_a_slow_reader_is_a_finding(monkeypatch):
    def endless(data):
        while True:
            pass

    monkeypatch.setattr(contract, "CPU_S", 0.05)
    with pytest.raises(contract.Broken, match="processor"):
        contract.check(endless, b"")


def test_an_error_is_one_line_whatever_it_quotes():
    for quoted in ("a\nb", "\x1b[31m", "\ud800", "x" * 10_000, "\u202e\x00"):
        text = str(BadInput(f"file {quoted}: is wrong"))
        assert text.isprintable()
        assert len(text) < 2000
        assert text.endswith("is wrong")
    assert str(LimnerError("as  it is, é too")) == "as  it is, é too"
