"""G-code says what the drawing is: replayed by our reader, and by a strict plotter that knows nothing of the writer."""

from __future__ import annotations

import contextlib
import math
import re

import numpy as np
import pytest
from hypothesis import given, strategies as st

from drawings import drawings, of, segments
from limner.errors import BadInput
from limner.targets.files import FORMATS, READABLE, read_drawing, to_bytes
from limner.targets.gcode import MODES, GcodeSettings, number, rounded, to_gcode
from limner.targets.gcode_read import read_gcode

PENS = (
    GcodeSettings(),
    GcodeSettings(servo_up=700, servo_down=0),
    GcodeSettings(pen="z"),
    GcodeSettings(pen="z", z_up_mm=-1, z_down_mm=-3.5),
)


def strict_plotter(text, settings):
    """What is drawn; every rule of the house checked at each line."""
    feed_said = pen_down = False
    place, lines, mode_said = (0.0, 0.0), [], False
    for line in text.splitlines():
        code = re.sub(r"\(.*?\)", "", line).strip()
        if not code:
            continue
        assert re.fullmatch(r"([A-Z]-?\d+(\.\d{1,3})?)( [A-Z]-?\d+(\.\d{1,3})?)*", code), code
        assert len(code) < 80
        words = [(word[0], float(word[1:])) for word in code.split()]
        if code == MODES:
            mode_said = True
            continue
        assert mode_said, "modes come first"
        values, kind = dict(words), words[0]
        if kind == ("M", 3):
            assert values["S"] in (settings.servo_up, settings.servo_down)
            lowers = values["S"] == settings.servo_down
        elif "Z" in values:
            assert values["Z"] in (settings.z_up_mm, settings.z_down_mm)
            lowers = values["Z"] == settings.z_down_mm
            assert not {"X", "Y"} & set(values)
            assert not lowers or (kind == ("G", 1) and "F" in values), "lowered at a feed of its own"
        else:
            lowers = None
        if lowers is not None:
            if lowers and not pen_down:
                lines.append([place])
            pen_down, feed_said = lowers, False
        elif kind in (("G", 0), ("G", 1)):
            assert (kind == ("G", 1)) == pen_down, "G0 only raised, G1 only lowered"
            feed_said = feed_said or "F" in values
            assert feed_said or not pen_down, "the feed is said at every change of mode"
            place = (values["X"], values["Y"])
            if pen_down:
                lines[-1].append(place)
        else:
            assert kind in (("G", 4), ("M", 2)), code
    assert not pen_down
    assert place == (0.0, 0.0)
    return lines


@given(drawings(), st.sampled_from(PENS))
def test_replayed_it_is_the_drawing(drawing, settings):
    data = to_gcode(drawing, settings)
    back = read_gcode(data)
    want = [rounded(line) for line in drawing.lines_mm]
    assert len(back.lines_mm) == len(want)
    assert all(np.array_equal(a, b) for a, b in zip(back.lines_mm, want, strict=True))
    assert (back.region, back.page, back.pen) == (drawing.region, drawing.page, drawing.pen)
    assert to_gcode(back, settings) == data


@given(drawings(), st.sampled_from(PENS))
def test_a_strict_plotter_draws_the_same_ink(drawing, settings):
    lines = strict_plotter(to_gcode(drawing, settings).decode(), settings)
    got = segments([np.array(line) for line in lines])
    want = segments([rounded(line) for line in drawing.lines_mm])
    inked = [s for s in want if len(s) == 2]
    assert [s for s in got if len(s) == 2] == inked
    touched = {point for segment in got for point in segment}
    assert all(s[0] in touched for s in want), "dots are drawn"


def test_the_strict_plotter_can_fail():
    text = to_gcode(of([[10, 10], [20, 20]])).decode()
    for wrong in (
        text.replace("G1", "G0"),
        text.replace(" F2400", ""),
        text.replace(MODES, ""),
        text.replace("M3 S700\n", ""),
    ):
        with pytest.raises(AssertionError):
            strict_plotter(wrong, GcodeSettings())


def test_as_it_stands():
    drawing = of([[10, 20], [30, 20.0004]], [[30, 20], [30, 40]], [[5, 5]], regions=["eye", "nose", "mouth"])
    assert to_gcode(drawing, GcodeSettings(pen="z", header="M8\nG4 P1 (for {strokes})", footer="")).decode() == (
        "(limner: page 148 x 210 mm, margin 10, pen 0.5)\n(pen up Z5, down Z0)\nG21 G90 G17 G94\n"
        "M8\nG4 P1 (for 3)\nG0 Z5\n"
        "(stroke 1: eye)\nG0 X10 Y20\nG1 Z0 F600\nG1 X30 Y20 F2400\n(stroke 2: nose)\nG1 X30 Y40\nG0 Z5\n"
        "(stroke 3: mouth)\nG0 X5 Y5\nG1 Z0 F600\nG0 Z5\nG0 X0 Y0\n"
    )


def test_another_makes_gcode():
    text = b"""%
    N10 G20 G91 G17
    g0 x1 y1 z0.2 ; above
    G01Z-0.4F10
    X1
    Y1 (up)
    G2 X0 Y-2 I0 J-1
    G0 Z0.4
    G90 G21 G92 X0 Y0
    G0 X10 Y0
    G1 Z0
    X10 Y10
    M30"""
    got = read_gcode(text, GcodeSettings(pen="z"))
    first, second = got.lines_mm
    assert np.allclose(first[:3], np.array([[1, 1], [2, 1], [2, 2]]) * 25.4)
    assert np.allclose(first[-1], np.array([2, 0]) * 25.4)
    assert np.allclose(np.hypot(*(first[3:] - [2 * 25.4, 25.4]).T), 25.4, atol=0.05)
    assert first[3:, 0].max() == pytest.approx(3 * 25.4, abs=0.06), "clockwise: by the right"
    assert np.allclose(second, np.array([[2 * 25.4 + 10, 0], [2 * 25.4 + 10, 10]]))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("hello", "line 1"),
        ("G21\nG1 X1 Yabc", "line 2"),
        ("G18", "XZ"),
        ("G33 X1", "G33"),
        ("M3 S700\nG2 X1 Y1 R5", "centre"),
        ("M3 S700\nG2 X1 Y1 I" + "9" * 30, "line 2.*arc"),
        ("G1 X" + "9" * 400, "finite"),
    ],
)
def test_what_is_not_understood_is_named(text, words):
    with pytest.raises(BadInput, match=words):
        read_gcode(text.encode())


@given(st.binary(max_size=200))
def test_any_bytes_are_read_or_refused(data):
    with contextlib.suppress(BadInput):
        read_gcode(data)


@pytest.mark.parametrize(
    "wrong",
    [{"servo_up": 5, "servo_down": 5}, {"pen": "z", "z_up_mm": 0}, {"pen": "laser"}, {"draw_mm_min": 0}],
)
def test_settings_are_checked(wrong):
    with pytest.raises(BadInput):
        GcodeSettings(**wrong)


def test_templates_are_checked():
    with pytest.raises(BadInput, match=r"gcode\.header.*\{width\}"):
        to_gcode(of([[1, 1]]), GcodeSettings(header="{depth}"))


def test_a_point_far_off_is_refused():
    for suffix in (".gcode", ".hpgl"):
        with pytest.raises(BadInput, match="off"):
            to_bytes(of([[0, 0], [1e9, 0]]), suffix)


@given(st.floats(-1e5, 1e5))
def test_numbers_have_three_decimals_and_no_exponent(value):
    assert re.fullmatch(r"-?\d+(\.\d{1,3})?", number(value))
    assert math.isclose(float(number(value)), value, abs_tol=0.0005 + 1e-9)
    assert number(value) != "-0"


def test_every_format_is_written_and_most_are_read(tmp_path):
    drawing = of([[10, 10], [20, 20]], [[30, 30], [35, 30]])
    for suffix in FORMATS:
        (tmp_path / f"a{suffix}").write_bytes(to_bytes(drawing, suffix))
        if suffix in READABLE:
            back = read_drawing(tmp_path / f"a{suffix}")
            assert segments(back.lines_mm) == segments(drawing.lines_mm)
    with pytest.raises(BadInput, match=r"\.png"):
        read_drawing(tmp_path / "a.png")
