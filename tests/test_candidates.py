"""Which of several drawings is kept, and that style `auto` keeps it."""

from __future__ import annotations

import json

import numpy as np
import pytest
from click.testing import CliRunner

import limner
from limner import storage
from limner.cli.draw import draw
from limner.vision.likeness.candidates import AUTO_STYLES, TIE, Candidate, best, candidate, why
from portraits import astronaut, plain_face


def item(style, likeness, scraps=0.0, beside=0.0):
    return Candidate(style, likeness, scraps, beside)


def test_the_most_like_is_kept():
    assert best([item("a", 0.5), item("b", 0.8), item("c", 0.6)]) == 1


def test_scraps_and_clutter_cost_and_taste_decides_between_equals():
    assert best([item("a", 0.8), item("b", 0.85, scraps=0.9)]) == 0
    assert best([item("a", 0.8, beside=0.9), item("b", 0.78)]) == 1
    assert best([item("a", 0.8), item("b", 0.8 + TIE / 2)]) == 0
    assert best([item("a", 0.8), item("b", 0.8 + 2 * TIE)]) == 1


def test_order_only_matters_among_equals():
    items = [item("a", 0.3), item("b", 0.9), item("c", 0.6)]
    for turn in range(3):
        rolled = items[turn:] + items[:turn]
        assert rolled[best(rolled)].style == "b"


def test_a_drawing_is_measured_in_outer_eye_distances():
    face = plain_face(outer_eye_px=100)
    lines = [np.array([[0.0, 0], [5, 0]]), np.array([[0.0, 0], [45, 0]]), np.array([[0.0, 0], [0, 50]])]
    seen = candidate("canny", 0.5, lines, ("eye", "jaw", "body"), face)
    assert seen.scraps == pytest.approx(1 / 3)
    assert seen.beside == pytest.approx(0.5)
    assert candidate("canny", 0.0, (), (), face).worth == 0


def test_why_names_all():
    text = why([item("a", 0.5), item("b", 0.8)])
    assert text.startswith("kept b: 0.80")
    assert "against a 0.50" in text


def test_why_explains_a_kept_one_that_is_not_the_first_by_figures():
    assert "a comes first" in why([item("a", 0.80), item("b", 0.81)])
    assert "comes first" not in why([item("a", 0.82), item("b", 0.81)])


def test_auto_keeps_the_best_of_what_it_drew_within_the_budget():
    photo, face = astronaut()
    auto = limner.draw(photo, face=face, style="auto", points=200)
    assert [seen.style for seen in auto.candidates] == list(AUTO_STYLES)
    assert auto.settings.style == auto.candidates[best(auto.candidates)].style
    assert auto.drawing.points <= 200
    alone = limner.draw(photo, face=face, style=auto.settings.style, points=200)
    assert alone.drawing == auto.drawing
    assert alone.likeness == auto.candidates[best(auto.candidates)].likeness
    assert alone.svg() == auto.svg()
    assert alone.candidates == ()


def test_the_command_says_which_and_why(tmp_path):
    photo, face = astronaut()
    from PIL import Image

    Image.fromarray(photo.rgb).save(tmp_path / "a.png")
    storage.save(face, tmp_path / "face.json")
    arguments = [str(tmp_path / "a.png"), "--landmarks", str(tmp_path / "face.json"), "-o", str(tmp_path / "a.svg")]
    ran = CliRunner().invoke(draw, [*arguments, "-s", "auto", "-n", "300", "--json"], catch_exceptions=False)
    report = json.loads(ran.stdout)
    assert report["style"] in AUTO_STYLES
    assert {seen["style"] for seen in report["candidates"]} == set(AUTO_STYLES)
    assert f"kept {report['style']}" in ran.stderr
