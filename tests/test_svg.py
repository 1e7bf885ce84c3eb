"""Our SVG comes back byte for byte, other people's comes in, and bombs stay outside."""

import contextlib
import itertools
import json
import re
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from drawings import drawings, of, segments
from limner import geometry
from limner.errors import BadInput
from limner.targets import svg_guard, svg_read
from limner.targets.svg import ABOUT_NAMESPACE, SvgSettings, to_svg
from limner.targets.svg_read import TOLERANCE_MM, read_about, read_svg
from limner.types import Drawing, Page, Pen

NS = "{http://www.w3.org/2000/svg}"
A5 = 'xmlns="http://www.w3.org/2000/svg" width="148mm" height="210mm" viewBox="0 0 148 210"'


def foreign(body, head=A5):
    return read_svg(f'<svg {head}><g fill="none" stroke="red">{body}</g></svg>'.encode())


def down(drawing):
    """The lines as they stand in the SVG, y down."""
    return [line * [1, -1] + [0, drawing.page.height_mm] for line in drawing.lines_mm]


def farthest(points, line):
    ends = line if len(line) > 1 else np.repeat(line, 2, axis=0)
    return np.min([geometry.distance_to_segments(points, a, b) for a, b in itertools.pairwise(ends)], axis=0).max()


@settings(max_examples=25)
@given(drawings(), st.sampled_from([0.05, 0.15, 1.0]))
def test_as_curves_it_comes_back_within_the_tolerance(drawing, tolerance):
    back = read_svg(to_svg(drawing, how=SvgSettings(curves=True, tolerance_mm=tolerance)))
    assert back.region == drawing.region
    for got, line in zip(back.lines_mm, drawing.lines_mm, strict=True):
        assert farthest(geometry.resample(line, 0.1), got) <= tolerance + TOLERANCE_MM + 0.002
        assert farthest(geometry.resample(got, 0.1), line) <= tolerance + TOLERANCE_MM + 0.002


def test_a_circle_is_written_as_curves_and_a_square_as_lines():
    t = np.linspace(0, 2 * np.pi, 90)
    ring = np.stack([50 + 20 * np.cos(t), 60 + 20 * np.sin(t)], axis=1)
    ring[-1] = ring[0]
    text = to_svg(of(ring, [[0, 0], [9, 0], [9, 9], [0, 9], [0, 0]]), how=SvgSettings(curves=True)).decode()
    circle, square = re.findall(r'<path d="([^"]*)"', text)
    assert 2 <= circle.count("C") <= 5
    assert " L " not in circle
    assert "C" not in square
    assert circle.endswith("Z")
    assert square.endswith("Z")


@given(drawings())
def test_from_svg_to_svg_is_the_identity(drawing):
    data = to_svg(drawing)
    once = read_svg(data)
    assert to_svg(once) == data
    assert read_svg(to_svg(once)) == once


@given(drawings())
def test_what_comes_back_is_the_drawing_to_a_micron(drawing):
    once = read_svg(to_svg(drawing))
    assert (once.region, once.page, once.pen) == (drawing.region, drawing.page, drawing.pen)
    assert np.allclose(once.weight, drawing.weight, rtol=1e-5)
    for got, line in zip(once.lines_mm, drawing.lines_mm, strict=True):
        rounded = geometry.without_repeats(np.round(line * [1, -1] + [0, drawing.page.height_mm], 3))
        assert np.allclose(got * [1, -1] + [0, drawing.page.height_mm], rounded, atol=1.1e-3)
        assert len(got) == len(rounded)


@given(
    st.builds(Page, st.floats(1, 10_000), st.floats(1, 10_000), st.floats(0, 0.4)),
    st.builds(Pen, st.floats(0.01, 50)),
)
def test_any_page_and_pen_come_back(page, pen):
    data = to_svg(Drawing((np.array([[0.5, 0.5], [0.7, 0.9]]),), ("eye",), np.ones(1), page, (pen,)))
    once = read_svg(data)
    assert to_svg(once) == data
    for name in ("width_mm", "height_mm", "margin_mm"):
        assert getattr(once.page, name) == pytest.approx(getattr(page, name), abs=1e-3)
    assert once.pen.width_mm == pytest.approx(pen.width_mm, abs=1e-3)


@given(drawings())
def test_one_path_per_stroke_in_drawing_order_within_the_page_in_millimetres(drawing):
    root = ElementTree.fromstring(to_svg(drawing))
    width, height = drawing.page.width_mm, drawing.page.height_mm
    assert root.get("width") == f"{width:g}mm"
    assert root.get("viewBox") == f"0 0 {width:g} {height:g}"
    paths = root.findall(f".//{NS}path")
    assert len(paths) == len(drawing.lines_mm)
    assert [path.get("data-region") for path in paths] == list(drawing.region)
    for path, line in zip(paths, drawing.lines_mm, strict=True):
        numbers = re.findall(r"[-\d.]+", path.get("d"))
        assert all(len(number.partition(".")[2]) <= 3 for number in numbers)
        assert [float(n) for n in numbers[:2]] == pytest.approx([line[0, 0], height - line[0, 1]], abs=6e-4)
        assert path.get("d").endswith("Z") == geometry.is_closed(geometry.without_repeats(np.round(line, 3)))


def test_golden():
    drawing = Drawing(
        (
            np.array([[10, 200], [20.5, 190], [-0.0001, 200.12345]]),
            np.array([[5, 5], [9, 5], [9, 9], [5, 5.0]]),
            [[1, 2]],
        ),
        ("eye", "jaw", "hair"),
        np.array([1.5, 1 / 3, 0]),
        Page(100, 210, 5),
        (Pen(0.4),),
    )
    assert to_svg(drawing, {"b": 1, "a": "<&>"}, 'Ann & "Bob"\x00').decode().splitlines() == [
        '<?xml version="1.0" encoding="UTF-8"?>',
        '<svg xmlns="http://www.w3.org/2000/svg" width="100mm" height="210mm" viewBox="0 0 100 210"'
        ' data-margin-mm="5" role="img">',
        '<title>Ann &amp; "Bob"\ufffd</title>',
        "<desc>Strokes: 3, in the order in which the pen draws them.</desc>",
        '<metadata><limner:about xmlns:limner="urn:limner:1">{"a": "&lt;&amp;&gt;", "b": 1}</limner:about></metadata>',
        '<g fill="none" stroke="black" stroke-width="0.4" stroke-linecap="round" stroke-linejoin="round">',
        '<path d="M 10,10 L 20.5,20 0,9.877" data-region="eye" data-weight="1.5"/>',
        '<path d="M 5,205 L 9,205 9,201 Z" data-region="jaw" data-weight="0.333333"/>',
        '<path d="M 1,208 L 1,208" data-region="hair" data-weight="0"/>',
        "</g>",
        "</svg>",
    ]


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | st.text(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3),
    max_leaves=8,
)


@given(st.dictionaries(st.text(), JSON, max_size=4), st.text())
def test_what_is_told_about_the_drawing_comes_back(about, title):
    data = to_svg(of([[1, 1], [2, 2]]), about, title)
    assert read_about(data) == json.loads(json.dumps(about))
    assert to_svg(read_svg(data), read_about(data), title) == data
    assert ElementTree.fromstring(data).find(f".//{{{ABOUT_NAMESPACE}}}about") is not None


def test_what_cannot_be_told_is_refused():
    with pytest.raises(BadInput, match="JSON"):
        to_svg(of(), {"a": object()})
    with pytest.raises(BadInput, match="JSON"):
        to_svg(of(), {"a": float("nan")})
    assert read_about(b'<svg xmlns="http://www.w3.org/2000/svg"/>') == {}


@pytest.mark.parametrize("far", [1e7, -1e300])
def test_absurdly_far_points_are_refused(far):
    with pytest.raises(BadInput, match="off the page"):
        to_svg(of([[0, 0], [far, 1]]))


def test_from_a_file(tmp_path):
    drawing = of([[1, 1], [2, 2]])
    (tmp_path / "a.svg").write_bytes(to_svg(drawing))
    assert read_svg(tmp_path / "a.svg") == drawing
    assert read_svg(str(tmp_path / "a.svg")) == drawing
    with pytest.raises(BadInput, match=r"missing\.svg"):
        read_svg(tmp_path / "missing.svg")


@pytest.mark.parametrize(
    ("body", "lines"),
    [
        ('<path d="M10,20 L30,40 50 60"/>', [[[10, 20], [30, 40], [50, 60]]]),
        ('<path d="m10,20 l20,20 h5 v-5 z"/>', [[[10, 20], [30, 40], [35, 40], [35, 35], [10, 20]]]),
        ('<path d="M1,1 L2,2 M5,5 L6,6"/>', [[[1, 1], [2, 2]], [[5, 5], [6, 6]]]),
        ('<path d="M1,1 L2,2 3,1 Z L9,9"/>', [[[1, 1], [2, 2], [3, 1], [1, 1]], [[1, 1], [9, 9]]]),
        ('<path d="M1,1 L3,1 3,3 1,1 Z"/>', [[[1, 1], [3, 1], [3, 3], [1, 1]]]),
        ('<path d="M1,1"/><path d=""/><path/>', []),
        ('<line x1="1" y1="2" x2="3" y2="4"/>', [[[1, 2], [3, 4]]]),
        ('<polyline points="1,2 3,4 5,2"/>', [[[1, 2], [3, 4], [5, 2]]]),
        ('<polygon points="1,2 3,4 5,2"/>', [[[1, 2], [3, 4], [5, 2], [1, 2]]]),
        ('<rect x="1" y="2" width="3" height="4"/>', [[[1, 2], [4, 2], [4, 6], [1, 6], [1, 2]]]),
        ('<g transform="translate(10 0) scale(2)"><line x1="1" y1="2" x2="3" y2="4"/></g>', [[[12, 4], [16, 8]]]),
        ('<g transform="rotate(90)"><line x1="1" y1="-2" x2="3" y2="-4"/></g>', [[[2, 1], [4, 3]]]),
        ('<line x1="1cm" y1="1in" x2="20mm" y2="0"/>', None),
        ('<defs><path id="a" d="M0,0 L1,1"/></defs><use href="#a" x="5" y="6"/>', [[[5, 6], [6, 7]]]),
        ('<path d="M1,1 L2,2" style="display:none"/><path d="M1,1 L2,2" visibility="hidden"/>', []),
        ('<path d="M1,1 L2,2" stroke="none"/>', []),
        ('<symbol id="s"><path d="M0,0 L1,1"/></symbol>', []),
        ('<symbol id="s"><path d="M0,0 L1,1"/></symbol><use href="#s" x="5"/>', [[[5, 0], [6, 1]]]),
        ('<marker id="m"><path d="M0,0 L1,1"/></marker><mask id="k"><rect width="3" height="3"/></mask>', []),
        ('<path d="M1,1 L2,2" stroke="none" fill="blue"/>', [[[1, 1], [2, 2]]]),
        ("<text>Hello</text><image href='a.png' width='5' height='5'/>", []),
        ('<metadata><a xmlns="urn:x"/></metadata><g><g><line x2="3" y2="4"/></g></g>', [[[0, 0], [3, 4]]]),
    ],
)
def test_what_others_write(body, lines):
    got = down(foreign(body))
    if lines is None:
        assert all(np.isfinite(line).all() for line in got)
        return
    assert len(got) == len(lines)
    for a, b in zip(got, lines, strict=True):
        assert np.allclose(a, b, atol=1e-5)


def curve_points(kind, t):
    """Points of the curves below by their definition."""
    if kind == "circle":
        return np.stack([60 + 30 * np.cos(t * 2 * np.pi), 90 + 30 * np.sin(t * 2 * np.pi)], axis=1)
    if kind == "ellipse":
        return np.stack([60 + 40 * np.cos(t * 2 * np.pi), 90 + 5 * np.sin(t * 2 * np.pi)], axis=1)
    s = 1 - t
    if kind == "cubic":
        return np.stack([10 * s**3 + 30 * s**2 * t * 3 + 5 * s * t**2 * 3 + 90 * t**3, 300 * s * s * t], axis=1)
    if kind == "quadratic":
        return np.stack([10 * s * s + 200 * s * t + 20 * t * t, 10 * s * s + 60 * s * t + 150 * t * t], axis=1)
    return np.stack([50 - 20 * np.cos(t * np.pi), 50 - 20 * np.sin(t * np.pi)], axis=1)


@pytest.mark.parametrize(
    ("kind", "body"),
    [
        ("circle", '<circle cx="60" cy="90" r="30"/>'),
        ("circle", '<g transform="translate(0 90) scale(3)"><circle cx="20" cy="0" r="10"/></g>'),
        ("ellipse", '<ellipse cx="60" cy="90" rx="40" ry="5"/>'),
        ("cubic", '<path d="M10,0 C30,100 5,0 90,0"/>'),
        ("quadratic", '<path d="M10,10 Q100,30 20,150"/>'),
        ("arc", '<path d="M30,50 A20,20 0 0 1 70,50"/>'),
    ],
)
def test_curves_are_followed_within_the_tolerance(kind, body):
    (line,) = down(foreign(body))
    curve = curve_points(kind, np.linspace(0, 1, 20_000))
    away = [geometry.distance_to_segments(curve, a, b) for a, b in itertools.pairwise(line)]
    assert np.min(away, axis=0).max() <= TOLERANCE_MM
    to_curve = [np.hypot(*(curve - point).T).min() for point in geometry.resample(line, 0.5)]
    assert max(to_curve) <= TOLERANCE_MM + 0.01
    assert len(line) < 120
    assert geometry.is_closed(line) == (kind in ("circle", "ellipse"))


@pytest.mark.parametrize(
    ("head", "page"),
    [
        ('width="148mm" height="210mm"', (148, 210)),
        ('width="14.8cm" height="8.26771654in"', (148, 210)),
        ('width="960" height="480px"', (254, 127)),
        ('viewBox="0 0 960 480"', (254, 127)),
        ('width="100%" height="100%" viewBox="0 0 960 480"', (254, 127)),
        ("", (210, 297)),
    ],
)
def test_pages(head, page):
    drawing = foreign('<line x2="1" y2="1"/>', f'xmlns="http://www.w3.org/2000/svg" {head}')
    assert (drawing.page.width_mm, drawing.page.height_mm) == pytest.approx(page, abs=1e-4)
    assert drawing.page.margin_mm == 0


def test_a_page_of_no_size_grows_with_its_lines():
    drawing = foreign('<line x2="3840" y2="96"/>', 'xmlns="http://www.w3.org/2000/svg"')
    assert (drawing.page.width_mm, drawing.page.height_mm) == pytest.approx((1016, 297))


def test_pen_region_and_weight_of_others():
    drawing = foreign(
        '<g stroke-width="0.3"><line x2="3" y2="4"/><line x2="1" y2="0" data-region="eye"/></g>'
        '<line stroke-width="2" x2="9" y2="0" data-region="moustache" data-weight="NaN"/>'
    )
    assert drawing.pen.width_mm == pytest.approx(0.3)
    assert drawing.region == (svg_read.UNKNOWN_REGION, "eye", svg_read.UNKNOWN_REGION)
    assert drawing.weight.tolist() == pytest.approx([5, 1, 9])


XLINK = 'xmlns:x="http://www.w3.org/1999/xlink"'
BOMB = '<!DOCTYPE svg [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;&a;">]>'
USES = "".join(
    f'<g id="u{k}">' + f'<use href="#u{k - 1}"/>' * 10 + "</g>" if k else '<path id="u0" d="M0,0 L1,1"/>'
    for k in range(12)
)


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"", "no SVG"),
        (b"hello", "no SVG"),
        (b"<svg", "no SVG"),
        (b"\xff\xfe\x00", "no SVG"),
        (b"<svg><x:g/></svg>", "unbound prefix"),
        (b"<html><body/></html>", "outermost element is <html>"),
        (b"<x:svg xmlns:x='urn:x'><path d='M0,0 L1,1'/></x:svg>", "xmlns"),
        (f"{BOMB}<svg {A5}><text>&b;</text></svg>".encode(), "entities"),
        (b'<!DOCTYPE svg [<!ENTITY x SYSTEM "file:///etc/passwd">]><svg>&x;</svg>', "entities"),
        (f"<svg {A5}>{USES}</svg>".encode(), "repeats too much by <use>"),
        (f'<svg {A5}><g id="a"><use href="#a"/></g></svg>'.encode(), "refers to itself"),
        (f'<svg {A5} {XLINK}><g id="a"><use x:href="#a"/></g></svg>'.encode(), "refers to itself"),
        (f"<svg {A5}>{'<g>' * 150}{'</g>' * 150}</svg>".encode(), "nested deeper than 100"),
        (f'<svg {A5}><path d="M0,0 L1e999,1" stroke="red"/></svg>'.encode(), "no finite number"),
        (f'<svg {A5}><circle r="1e12" stroke="red"/></svg>'.encode(), "straight pieces"),
        (b'<svg xmlns="http://www.w3.org/2000/svg" width="0.1mm" height="5mm"/>', "page"),
        (b'<svg xmlns="http://www.w3.org/2000/svg" width="1e9mm" height="5mm"/>', "page"),
    ],
)
def test_bad_files_give_one_clear_line(data, words):
    with pytest.raises(BadInput, match=words) as error:
        read_svg(data)
    assert str(error.value).startswith("svg: ")
    assert "\n" not in str(error.value)


def test_too_large_a_file(monkeypatch):
    monkeypatch.setattr(svg_guard, "MAX_BYTES", 2**20)
    with pytest.raises(BadInput, match="more than the 1 MB"):
        read_svg(b" " * (2**20 + 1))


def test_too_many_points(monkeypatch):
    monkeypatch.setattr(svg_read, "MAX_POINTS", 10)
    with pytest.raises(BadInput, match="more than 10 points"):
        foreign('<circle cx="60" cy="90" r="30"/>')


def test_a_doctype_without_entities_is_harmless():
    doctype = '<!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" "http://www.w3.org/Graphics/SVG/1.1/DTD/svg11.dtd">'
    drawing = read_svg(f'{doctype}<svg {A5}><line x2="3" y2="4" stroke="red"/></svg>'.encode())
    assert segments(down(drawing)) == [((0, 0), (3, 4))]


OURS = to_svg(of([[1, 1], [20, 30], [4, 5.5]], [[9, 9]], [[50, 50], [60, 50], [60, 60], [50, 50]]), {"a": [1]})


@given(st.lists(st.tuples(st.integers(0, len(OURS) - 1), st.integers(0, 255)), max_size=6), st.integers(0, len(OURS)))
def test_damaged_files_give_a_drawing_or_one_clear_line(changes, length):
    data = bytearray(OURS)
    for where, value in changes:
        data[where] = value
    for damaged in (bytes(data), bytes(data[:length])):
        for read in (read_svg, read_about):
            with contextlib.suppress(BadInput):
                read(damaged)
