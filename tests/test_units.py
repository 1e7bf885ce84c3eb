"""Lengths, times and pages written with units."""

import contextlib

import pytest
from hypothesis import given, strategies as st

from limner.errors import BadInput
from limner.types import Page
from limner.units import LENGTHS_MM, PAGES_MM, TIMES_S, parse_length_mm, parse_minutes, parse_page, parse_time_s


@pytest.mark.parametrize(
    ("text", "mm"),
    [("12mm", 12), ("1.5cm", 15), ("2in", 50.8), ("7", 7), (" 3 MM ", 3), (".5", 0.5), ("72pt", 25.4), ("-2", -2)],
)
def test_length(text, mm):
    assert parse_length_mm(text) == pytest.approx(mm)


@pytest.mark.parametrize(("text", "s"), [("90s", 90), ("5min", 300), ("1.5 h", 5400), ("30", 30)])
def test_time(text, s):
    assert parse_time_s(text) == pytest.approx(s)


@given(st.floats(-1e6, 1e6), st.sampled_from(sorted(LENGTHS_MM)))
def test_length_is_the_number_times_its_unit(number, unit):
    assert parse_length_mm(f"{number!r}{unit}") == pytest.approx(number * LENGTHS_MM[unit])


@given(st.floats(0, 1e6), st.sampled_from(sorted(TIMES_S)))
def test_time_is_the_number_times_its_unit(number, unit):
    assert parse_time_s(f"{number!r}{unit}") == pytest.approx(number * TIMES_S[unit])


@pytest.mark.parametrize(("text", "minutes"), [("3", 3), ("3min", 3), ("90s", 1.5), ("1.5 h", 90)])
def test_minutes_take_any_unit_of_time_and_are_minutes_without_one(text, minutes):
    assert parse_minutes(text) == pytest.approx(minutes)


@pytest.mark.parametrize("name", PAGES_MM)
def test_named_pages_stand_upright_and_turn(name):
    page = parse_page(name, 5)
    assert (page.width_mm, page.height_mm) == PAGES_MM[name]
    assert page.width_mm < page.height_mm
    assert page.margin_mm == 5
    turned = parse_page(f"{name.upper()}:Landscape", 5)
    assert (turned.width_mm, turned.height_mm) == (page.height_mm, page.width_mm)
    assert parse_page(f"{name}:portrait", 5) == page


@pytest.mark.parametrize(
    ("text", "page"),
    [
        ("120x160mm", Page(120, 160)),
        ("120 x 160", Page(120, 160)),
        ("120mmx16cm", Page(120, 160)),
        ("12x16cm", Page(120, 160)),
        ("160x120mm:portrait", Page(120, 160)),
        ("120\u00d7160mm:landscape", Page(160, 120)),
        ("5x7in", Page(127, 177.8)),
    ],
)
def test_pages_by_their_sides(text, page):
    got = parse_page(text)
    assert (got.width_mm, got.height_mm) == pytest.approx((page.width_mm, page.height_mm))


@pytest.mark.parametrize("text", ["", "a9", "a5:sideways", "120x", "x120", "1x2x3", "nan", "0x9", "9x1e9", "9e999x5"])
def test_bad_pages(text):
    with pytest.raises(BadInput, match="page"):
        parse_page(text)


@pytest.mark.parametrize("text", ["", "mm", "1 2", "12 parsecs", "nan", "inf", "1e999", "--1", "1,5mm", "0x1p3"])
def test_bad_lengths_and_times(text):
    with pytest.raises(BadInput, match=r"^margin: "):
        parse_length_mm(text, "margin")
    with pytest.raises(BadInput, match=r"^time: "):
        parse_time_s(text)


def test_errors_list_the_choices():
    with pytest.raises(BadInput, match=r"a4, a5.*letter.*120x160mm"):
        parse_page("b5")
    with pytest.raises(BadInput, match="mm, cm, m, in"):
        parse_length_mm("3 furlongs")
    with pytest.raises(BadInput, match="s, min, h"):
        parse_time_s("3ms")


@given(st.text(max_size=20))
def test_any_text_gives_a_value_or_one_clear_line(text):
    for parse in (parse_length_mm, parse_time_s, parse_page):
        with contextlib.suppress(BadInput):
            parse(text)


def test_messages_stay_on_one_line():
    with pytest.raises(BadInput) as error:
        parse_page("a\nb")
    assert "\n" not in str(error.value)
