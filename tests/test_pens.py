"""Several pens: kept apart and together through every stage, in every file, and changed at a stop."""

import dataclasses
import json

import numpy as np
import pytest
from hypothesis import given, settings

from drawings import PENS, drawings, of, segments
from limner import storage
from limner.drawing.clean import CleanSettings, clean
from limner.drawing.compose import ComposeSettings, compose
from limner.drawing.measure import measure
from limner.drawing.order import OrderSettings, order
from limner.drawing.select import SelectSettings, select
from limner.errors import BadInput, NothingToDraw
from limner.motion.machine import load_machine
from limner.motion.pen import plan
from limner.targets.gcode import to_gcode
from limner.targets.gcode_read import read_gcode
from limner.targets.hpgl import to_hpgl
from limner.targets.hpgl_read import read_hpgl
from limner.targets.image import to_rgb
from limner.targets.journal import Journal
from limner.targets.send import Control, send
from limner.targets.svg import to_svg
from limner.targets.svg_read import read_svg
from limner.types import Drawing, Page, Pen, Strokes
from plotters import counted, grbl, inked

SEVERAL = drawings(most_pens=3)
CROSS = [[20, 20], [40, 20]], [[40, 20], [40, 40]], [[30, 10], [30, 30]]


def several(*some, layer):
    return dataclasses.replace(of(*some), pens=PENS, layer=layer)


def of_each_pen(drawing):
    return {drawing.pens[part.layer[0]]: segments(part.lines_mm) for part in drawing.by_pen()}


@given(SEVERAL)
def test_json_npz_and_svg_bring_the_pens_back(drawing):
    assert storage.from_json(Drawing, storage.to_json(drawing)) == drawing
    assert storage.from_npz(Drawing, storage.to_npz(drawing)) == drawing
    data = to_svg(drawing)
    back = read_svg(data)
    assert to_svg(back) == data
    if drawing.lines_mm:
        assert (back.pens, back.layer.tolist()) == (drawing.pens, drawing.layer.tolist())


def test_drawings_stored_before_there_were_several_pens_load():
    drawing = of(*CROSS)
    fields = storage.to_fields(drawing)
    del fields["pens"], fields["layer"]
    old = fields | {"pen": {"width_mm": 0.3}}
    assert storage.from_json(Drawing, json.dumps(old)) == dataclasses.replace(drawing, pens=(Pen(0.3),))
    arrays = storage.unpack_npz(storage.to_npz(drawing))
    del arrays["pens"], arrays["layer"]
    arrays["pen"] = np.array('{"width_mm": 0.3}')
    assert storage.from_npz(Drawing, storage.pack_npz(arrays)).pens == (Pen(0.3),)


@settings(max_examples=25)
@given(SEVERAL)
def test_ordering_moves_no_line_to_another_pen(drawing):
    for by in ("travel", "audience"):
        assert of_each_pen(order(drawing, OrderSettings(by=by))) == of_each_pen(drawing)


@given(SEVERAL)
def test_cleaning_a_drawing_cleans_what_each_pen_draws(drawing):
    how = CleanSettings(min_length_mm=0)
    parts = {}
    for part in drawing.by_pen():
        try:
            parts[part.pens[part.layer[0]]] = segments(clean(part, how).lines_mm)
        except NothingToDraw:
            continue
    assert of_each_pen(clean(drawing, how)) == parts


@given(SEVERAL)
def test_what_is_chosen_keeps_its_pen(drawing):
    chosen = select(drawing, SelectSettings(points=9, coarsest=0))
    where = {tuple(map(tuple, line.tolist())): k for line, k in zip(drawing.lines_mm, drawing.layer, strict=True)}
    if len(where) == len(drawing.lines_mm):
        for line, k in zip(chosen.lines_mm, chosen.layer, strict=True):
            whole = where.get(tuple(map(tuple, line.tolist())))
            assert whole in (None, k)


def test_strokes_are_composed_pen_by_pen_with_one_width():
    strokes = Strokes(tuple(map(np.array, CROSS)), ("eye", "jaw", "nose"), [3, 2, 1], (60, 60), PENS[:2], [1, 0, 1])
    drawing = compose(strokes, Page(), ComposeSettings(), Pen(0.3))
    assert drawing.region == ("jaw", "eye", "nose")
    assert drawing.layer.tolist() == [0, 1, 1]
    assert drawing.pens == tuple(dataclasses.replace(pen, width_mm=0.3) for pen in PENS[:2])


def test_svg_has_a_layer_of_inkscapes_for_each_pen():
    text = to_svg(several(*CROSS, layer=[0, 1, 2])).decode()
    assert [text.count(f'inkscape:label="{name}"') for name in ("1-black", "2-red ink", "3-blue")] == [1, 1, 1]
    assert text.count('inkscape:groupmode="layer"') == 3
    assert 'stroke="#c81e28"' in text
    assert "inkscape" not in to_svg(of(*CROSS)).decode()


def test_another_makes_layers_are_pens():
    head = 'xmlns="http://www.w3.org/2000/svg" xmlns:i="http://www.inkscape.org/namespaces/inkscape"'
    layer = '<g i:groupmode="layer" i:label="{}"><g stroke="{}"><path d="M 1 1 L 20 20"/></g></g>'
    body = layer.format("3 - (green)", "#00ff00") + layer.format("", "red")
    got = read_svg(f'<svg {head} width="40mm" height="40mm" viewBox="0 0 40 40">{body}</svg>'.encode())
    assert [(pen.name, pen.rgb) for pen in got.pens] == [("green", (0, 255, 0)), ("pen 2", (255, 0, 0))]


def test_ink_is_in_the_pens_colours_and_adds_up_where_lines_cross():
    picture = to_rgb(several(CROSS[0], CROSS[2], layer=[1, 2]), 10)
    height = 2100
    assert picture[height - 200, 250].tolist() == list(PENS[1].rgb)
    assert picture[height - 150, 300].tolist() == list(PENS[2].rgb)
    both = [round(a * b / 255) for a, b in zip(PENS[1].rgb, PENS[2].rgb, strict=True)]
    assert np.abs(picture[height - 200, 300].astype(int) - both).max() <= 1


@given(SEVERAL)
def test_gcode_and_hpgl_change_the_pen(drawing):
    data = to_gcode(drawing)
    back = read_gcode(data)
    assert to_gcode(back) == data
    assert back.layer.tolist() == drawing.layer.tolist()
    assert data.count(b"\nM0\n") == drawing.changes().sum()
    words = to_hpgl(drawing)
    assert read_hpgl(words, drawing.page).layer.tolist() == drawing.layer.tolist()
    assert to_hpgl(read_hpgl(words, drawing.page)) == words


def test_the_pen_is_raised_where_it_is_changed():
    meets = several(CROSS[0], CROSS[1], layer=[0, 1])
    one = several(CROSS[0], CROSS[1], layer=[0, 0])
    assert (measure(meets).lifts, measure(one).lifts) == (2, 1)
    raised = [int((np.diff(plan(d, load_machine("axidraw")).down.astype(int)) == -1).sum()) for d in (meets, one)]
    assert raised == [2, 1]


def test_sending_waits_for_each_pen(tmp_path):
    drawing = several(*CROSS, layer=[0, 1, 2])
    fake, target = grbl()
    control, waited = Control(), []

    def watch(place, waits):
        if waits:
            waited.append(place.stroke)
            control.pause = False

    journal = Journal(tmp_path / "journal", drawing, resume=False)
    assert send(drawing, target, journal, control, watch).stroke == 3
    journal.close()
    assert waited == [1, 2]
    assert inked(fake) == counted(drawing.lines_mm)


def test_wrong_pens_are_named():
    for bad in (
        lambda: Pen(0.5, (0, 0, 256)),
        lambda: Pen(0.5, (0, 0)),
        lambda: Pen(0.5, name="(x)"),
        lambda: several(*CROSS, layer=[0, 1, 3]),
        lambda: several(*CROSS, layer=[0, 1]),
        lambda: several(*CROSS, layer=[1, 0, 0]),
        lambda: dataclasses.replace(of(*CROSS), pens=()),
        lambda: dataclasses.replace(of(*CROSS), pens=Pen()),
    ):
        with pytest.raises(BadInput, match="expected"):
            bad()
