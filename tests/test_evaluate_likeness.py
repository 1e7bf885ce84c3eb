"""Drawings of people matched with other photos of them: the ranks, their intervals, and the command."""

from __future__ import annotations

import csv
import json

import numpy as np
import pytest
from click.testing import CliRunner

from limner.cli.evaluate import evaluate
from limner.errors import BadInput
from limner.evaluate.likeness import ALL, evaluate_likeness, read_people, to_dict


@pytest.fixture(scope="module")
def london(shared):
    return shared / "data" / "london"


@pytest.fixture(scope="module")
def rows(london):
    return evaluate_likeness(read_people(london, 12), ["splines", "canny"], [60, 400])


def row(rows, style, points, group=ALL):
    (found,) = [r for r in rows if (r.style, r.points, r.group) == (style, points, group)]
    return found


def test_people_are_in_two_photos(london):
    people = read_people(london)
    assert len(people) == 78
    assert all(person.drawn.path != person.sought.path for person in people)
    assert all(person.drawn.path.name[:3] == person.sought.path.name[:3] for person in people)
    assert {person.group for person in people} >= {"black", "white", "east_asian"}
    assert [p.name for p in read_people(london, 20, seed=3)] == [p.name for p in read_people(london, 20, seed=3)]
    assert [p.name for p in read_people(london, 20, seed=3)] != [p.name for p in read_people(london, 20, seed=4)]


def test_every_style_and_budget_has_a_row_and_groups_add_up(rows):
    assert {(r.style, r.points) for r in rows} == {("photo", 0)} | {
        (s, n) for s in ("splines", "canny") for n in (60, 400)
    }
    for style, points in {(r.style, r.points) for r in rows}:
        groups = [r for r in rows if (r.style, r.points) == (style, points) and r.group != ALL]
        whole = row(rows, style, points)
        assert sum(r.people for r in groups) == whole.people == 12
        assert sum(r.people * r.mrr.value for r in groups) == pytest.approx(12 * whole.mrr.value)


def test_figures_lie_within_their_intervals_and_hang_together(rows):
    for r in rows:
        for figure, top in ((r.rank_1, 100), (r.rank_5, 100), (r.mrr, 1)):
            assert 0 <= figure.low <= figure.value <= figure.high <= top
        assert r.rank_1.value <= r.rank_5.value
        assert r.rank_1.value / 100 <= r.mrr.value
    assert row(rows, "canny", 60).drawn_points <= 60


def test_a_photo_finds_its_person_better_than_a_few_lines_do(rows):
    assert row(rows, "photo", 0).rank_1.value >= 80
    assert row(rows, "photo", 0).mrr.value > row(rows, "canny", 60).mrr.value
    assert row(rows, "photo", 0).mrr.value > row(rows, "splines", 60).mrr.value


@pytest.mark.slow
def test_nearly_every_photo_of_london_finds_its_smile(london):
    (photo,) = [r for r in evaluate_likeness(read_people(london), [], []) if r.group == ALL]
    assert photo.people == 78
    assert photo.rank_1.value >= 95


def test_the_command_prints_writes_and_obeys(london, tmp_path):
    table = tmp_path / "likeness.csv"
    arguments = ["likeness", str(london), "--people", "10", "--styles", "splines", "--points", "100", "--seed", "2"]
    ran = CliRunner().invoke(evaluate, [*arguments, "--json", "--table", str(table)], catch_exceptions=False)
    report = json.loads(ran.stdout)
    assert report["people"] == 10
    assert {(r["style"], r["points"]) for r in report["rows"]} == {("photo", 0), ("splines", 100)}
    with table.open(newline="") as file:
        written = list(csv.DictReader(file))
    assert len(written) == len(report["rows"])
    for line, r in zip(written, report["rows"], strict=True):
        assert float(line["mrr"]) == pytest.approx(r["mrr"], rel=1e-5)
        assert np.allclose([float(line["rank_1_low"]), float(line["rank_1_high"])], r["rank_1_interval"], rtol=1e-5)


def test_the_same_seed_gives_the_same_rows(london):
    people = read_people(london, 10)
    first, second = (evaluate_likeness(people, ["splines"], [100], seed=1) for _ in range(2))
    assert [to_dict(r) for r in first] == [to_dict(r) for r in second]


@pytest.mark.parametrize(
    ("arguments", "says"),
    [(["--styles", "oil"], "choose from"), (["--points", "many"], "whole numbers"), (["--points", "1"], "2 points")],
)
def test_bad_arguments_are_named(tmp_path, arguments, says):
    ran = CliRunner().invoke(evaluate, ["likeness", str(tmp_path), *arguments])
    assert isinstance(ran.exception, BadInput)
    assert says in str(ran.exception)


def test_a_folder_without_second_photos_is_named(tmp_path):
    with pytest.raises(BadInput, match="landmarks_smiling"):
        read_people(tmp_path)
