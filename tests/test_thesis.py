"""The page that follows the thesis: complete, honest about what is missing, and needing no other file."""

from __future__ import annotations

import json
import re
from html.parser import HTMLParser

import numpy as np
import pytest
from click.testing import CliRunner

from limner import storage
from limner.cli import limner as command
from limner.cli.evaluate import astronaut
from limner.errors import BadInput
from limner.evaluate.tables import Grid
from limner.evaluate.thesis.page import Section, to_html
from limner.evaluate.thesis.report import Sources, measured_tables
from limner.evaluate.thesis.trees import trees
from limner.evaluate.thesis.words import CHAPTERS, FIGURES
from limner.pipeline import Settings
from limner.vision.landmarks.fmp.model import default_model

GREY = np.full((40, 60, 3), 128, np.uint8)


class Page(HTMLParser):
    """Tags that are open, ids, addresses."""

    def __init__(self, data):
        super().__init__()
        self.open, self.ids, self.links, self.text = [], [], [], []
        self.feed(data.decode())

    def handle_starttag(self, tag, attrs):
        if tag not in ("meta", "img"):
            self.open.append(tag)
        values = dict(attrs)
        self.ids += [values["id"]] if "id" in values else []
        self.links += [values[name] for name in ("src", "href") if name in values]

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text.append(data)


def quiet(*_):
    """Told of progress."""


def test_the_page_is_whole_and_needs_no_other_file():
    grid = Grid("A <table>", ("a", "b"), (("1", "<2>"),), "a & note")
    made = [
        Section("3", "A chapter", "they & we", "we <b>", chapter=True),
        Section("Figure 3.1", "One", figures=((GREY, 'said "so"'),), grids=(grid,)),
    ]
    page = Page(to_html("T", "lead", made))
    assert page.open == []
    assert page.ids == ["s3", "sFigure 3.1"]
    assert all(link.startswith(("#", "data:")) for link in page.links)
    assert set(page.links) >= {"#s3"}
    said = " ".join(page.text)
    for words in ("they & we", "we <b>", "A <table>", "<2>", "a & note", 'said "so"'):
        assert words in said


def test_every_figure_of_the_thesis_has_words():
    assert set(FIGURES) == {f"3.{k}" for k in range(1, 15)} | {f"4.{k}" for k in range(2, 6)}
    assert set(CHAPTERS) == {"3.1", "3.2", "3.3", "3.5", "4"}


def test_without_annotated_photos_no_table_is_made():
    assert measured_tables(Sources((), ()), Settings(), quiet) == {f"3.{k}": [] for k in range(1, 5)}


def test_tables_stand_beside_the_thesiss_numbers(shared, tmp_path):
    source = shared / "data/imm-frontal"
    arrays = storage.unpack_npz(storage.read_bytes(source / "landmarks.npz"), "imm")
    few = {name: array[::30] if len(array) == len(arrays["names"]) else array for name, array in arrays.items()}
    (tmp_path / "images").mkdir()
    for name in few["names"].tolist():
        (tmp_path / "images" / name).symlink_to(source / "images" / name)
    storage.write_whole(tmp_path / "landmarks.npz", storage.pack_npz(few))
    found = measured_tables(Sources((), (), imm=str(tmp_path)), Settings(), quiet)
    assert all(found[number] for number in ("3.1", "3.2", "3.4"))
    heads = found["3.4"][0].columns
    assert any(head.startswith("thesis") for head in heads)
    assert "17.93" in found["3.4"][0].rows[0]
    with pytest.raises(BadInput):
        measured_tables(Sources((), (), imm=str(tmp_path / "absent")), Settings(), quiet)


def test_a_tree_has_a_branch_for_every_part_but_the_root():
    picture = trees(default_model())
    assert picture.ndim == 3
    root = (picture == (200, 60, 30)).all(axis=2)
    assert 20 < root.sum() < 2000


@pytest.mark.parametrize("photos", [[], [str(astronaut())] * 7])
def test_too_few_or_many_photos_give_one_line(tmp_path, photos):
    ran = CliRunner().invoke(command, ["evaluate", "thesis", *photos, "-o", str(tmp_path)])
    assert isinstance(ran.exception, BadInput)
    assert "1 to 6" in str(ran.exception)


@pytest.mark.slow
def test_one_command_makes_the_whole_page(tmp_path):
    arguments = ["evaluate", "thesis", "--photos", str(astronaut()), "-o", str(tmp_path / "report"), "--json"]
    ran = CliRunner().invoke(command, arguments, catch_exceptions=False)
    (name,) = json.loads(ran.stdout)["out"]
    data = storage.read_bytes(name)
    page = Page(data)
    assert {f"sFigure {number}" for number in FIGURES} <= set(page.ids)
    assert len(data) < 4e6
    assert not re.search(rb'(src|href)="(?!#|data:)', data)
    said = " ".join(page.text)
    assert "Not measured" in said
    assert re.search(r"Drawing times.*\d+ s", said, re.DOTALL)
