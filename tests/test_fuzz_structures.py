"""Readers of outside data over inputs built by their own grammar, nearly right: a value or one line, in time."""

from __future__ import annotations

import json
from types import SimpleNamespace as Message

import fuzz
import numpy as np
import pytest
from fuzz import contract
from hypothesis import HealthCheck, example, given, settings, strategies as st

from drawings import drawings
from limner import storage
from limner.errors import LimnerError
from limner.ros.messages import ENCODINGS, to_motion, to_photo, to_stroke
from limner.settings import write_toml
from limner.types import Page

HARNESSES = fuzz.harnesses()
FEW = settings(max_examples=60, suppress_health_check=list(HealthCheck))

numbers = st.one_of(
    st.floats(),
    st.integers(-(10**30), 10**30),
    st.sampled_from([0, -0.0, 1e-320, 1e308, float("nan"), float("inf")]),
)
lengths = numbers.flatmap(lambda value: st.sampled_from(["", "mm", "px", "%", "em", "e", " "]).map(f"{value}".__add__))


def kept(name, text):
    contract.check(HARNESSES[name], text if isinstance(text, bytes) else text.encode("utf-8", "replace"))


# SVG: groups in groups, transforms, every kind of shape, uses of what may not be there.
paths = st.lists(st.tuples(st.sampled_from("MmLlHhVvCcSsQqTtAaZz"), st.lists(numbers, max_size=7)), max_size=6).map(
    lambda parts: " ".join(letter + " ".join(map(str, values)) for letter, values in parts)
)
transforms = st.lists(
    st.tuples(
        st.sampled_from(["matrix", "translate", "scale", "rotate", "skewX", "none"]), st.lists(numbers, max_size=6)
    ),
    max_size=3,
).map(lambda parts: " ".join(f"{name}({','.join(map(str, values))})" for name, values in parts))
shapes = st.one_of(
    paths.map(lambda d: f'<path id="a" d="{d}"/>'),
    st.tuples(lengths, lengths, lengths).map(lambda v: f'<circle cx="{v[0]}" cy="{v[1]}" r="{v[2]}"/>'),
    st.tuples(lengths, lengths).map(lambda v: f'<rect width="{v[0]}" height="{v[1]}" rx="{v[0]}"/>'),
    st.lists(numbers, max_size=9).map(lambda v: f'<polyline points="{" ".join(map(str, v))}"/>'),
    st.sampled_from(["a", "g", "absent"]).map(lambda name: f'<use href="#{name}" x="3"/>'),
)
groups = st.recursive(
    shapes,
    lambda inner: st.tuples(transforms, st.lists(inner, max_size=4)).map(
        lambda parts: f'<g id="g" transform="{parts[0]}">{"".join(parts[1])}</g>'
    ),
    max_leaves=12,
)


@FEW
@given(lengths, lengths, st.lists(numbers, max_size=5), groups)
def test_svg(width, height, box, content):
    view = " ".join(map(str, box))
    root = f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="{view}">'
    kept("svg", f"{root}{content}</svg>")


# JSON of the types: a right one in which something is another thing.
values = st.recursive(
    st.one_of(st.none(), st.booleans(), numbers, st.text(max_size=5)),
    lambda inner: st.one_of(
        st.lists(inner, max_size=4), st.dictionaries(st.sampled_from(["x", "page", "pens"]), inner)
    ),
    max_leaves=8,
)


@FEW
@given(drawings(most=3, most_pens=3), st.data())
def test_a_drawing_with_one_thing_changed(drawing, data):
    fields = storage.to_fields(drawing)
    place, key = fields, data.draw(st.sampled_from(sorted(fields)))
    while isinstance(place[key], list | dict) and place[key] and data.draw(st.booleans()):
        place = place[key]
        key = data.draw(st.sampled_from(sorted(place) if isinstance(place, dict) else range(len(place))))
    place[key] = data.draw(values)
    kept("json", json.dumps(fields))


@FEW
@given(st.data())
def test_settings_with_one_line_changed(data):
    from limner.pipeline import Settings

    lines = write_toml(Settings()).splitlines()
    row = data.draw(st.sampled_from([k for k, line in enumerate(lines) if " = " in line]))
    name = lines[row].lstrip("# ").partition(" = ")[0]
    value = data.draw(st.one_of(values.map(lambda v: json.dumps(v, allow_nan=True)), st.text(max_size=9)))
    kept("settings", "\n".join([*lines[:row], f"{name} = {value}", *lines[row + 1 :]]))


words = st.lists(st.tuples(st.sampled_from("GMXYZIJKRFSPTN"), numbers), max_size=6).map(
    lambda parts: "".join(f"{letter}{value}" for letter, value in parts)
)


@FEW
@given(
    st.lists(st.one_of(words, st.sampled_from(["G90", "G91", "G20", "G2 X1 I1", "(", "; pen", "$$", "%"])), max_size=9)
)
def test_gcode(lines):
    kept("gcode", "\n".join(lines))


@FEW
@given(
    st.lists(
        st.tuples(
            st.sampled_from(["IN", "PU", "PD", "PA", "PR", "SP", "AA", "CI", "SC", "IP", "RO", "LB", "DT", "VS"]),
            st.lists(numbers, max_size=6),
        ),
        max_size=9,
    )
)
def test_hpgl(commands):
    kept("hpgl", "".join(f"{name}{','.join(map(str, values))};" for name, values in commands))


@FEW
@given(
    st.lists(
        st.tuples(
            st.sampled_from(["revolute", "continuous", "prismatic", "fixed", "floating", "planar", "odd"]),
            st.sampled_from("abcd"),
            st.sampled_from("abcd"),
            st.lists(numbers, min_size=3, max_size=3),
            numbers,
            numbers,
        ),
        max_size=4,
    )
)
def test_urdf(joints):
    links = "".join(f'<link name="{name}"/>' for name in "abcd")
    made = "".join(
        f'<joint name="j{k}" type="{kind}"><parent link="{a}"/><child link="{b}"/>'
        f'<origin xyz="{" ".join(map(str, xyz))}"/><axis xyz="0 0 1"/>'
        f'<limit lower="{low}" upper="{high}" velocity="1" effort="1"/></joint>'
        for k, (kind, a, b, xyz, low, high) in enumerate(joints)
    )
    kept("urdf", f'<robot name="r">{links}{made}</robot>')


# Messages of ROS, as its own generated classes hold them: whole numbers are whole, texts are texts.
whole = st.integers(0, 2**32 - 1)
header = st.sampled_from(["paper", "/paper", "map", ""]).map(lambda frame: Message(frame_id=frame))
places = st.tuples(*[st.floats(width=64)] * 3).map(
    lambda v: Message(pose=Message(position=Message(x=v[0], y=v[1], z=v[2])))
)
near = st.tuples(st.floats(0, 0.2), st.floats(0, 0.25)).map(
    lambda v: Message(pose=Message(position=Message(x=v[0], y=v[1], z=0.0)))
)


def refused_or(make, *given):
    try:
        return make(*given)
    except LimnerError as error:
        told = str(error)
    assert told.isprintable()
    return None


@FEW
@given(
    st.sampled_from([*ENCODINGS, "32FC1", "", "\n"]),
    whole | st.integers(0, 9),
    whole | st.integers(0, 9),
    whole,
    st.binary(max_size=300),
)
def test_ros_images(encoding, width, height, step, data):
    for row in (step, 3 * width, width):
        image = Message(encoding=encoding, width=width, height=height, step=row, data=data)
        photo = refused_or(to_photo, image)
        assert photo is None or photo.size_px == (width, height)


far_off = Message(pose=Message(position=Message(x=0.0, y=1.8e305, z=0.0)))


@FEW
@example(Message(frame_id="paper"), [far_off])
@given(header, st.lists(places | near, max_size=5))
def test_ros_paths(head, poses):
    stroke = refused_or(to_stroke, Message(header=head, poses=poses), Page())
    assert stroke is None or (len(stroke) == len(poses) > 0 and np.isfinite(stroke).all())


@FEW
@given(
    st.permutations(["a", "b"]) | st.lists(st.sampled_from("abc"), max_size=3),
    st.lists(st.tuples(st.floats(0, 1e9), st.lists(st.floats(), min_size=2, max_size=3)), max_size=4),
    st.booleans(),
)
def test_ros_trajectories(names, rows, forces):
    points = [
        Message(
            positions=row,
            velocities=row,
            accelerations=row if forces else [],
            time_from_start=Message(to_sec=lambda t=t: t),
        )
        for t, row in rows
    ]
    motion = refused_or(to_motion, Message(joint_names=names, points=points), ("a", "b"))
    assert motion is None or np.isfinite(motion.q).all()


@pytest.mark.parametrize("name", ["svg", "gcode", "hpgl"])
def test_the_grammars_reach_their_readers(name):
    good = {
        "svg": '<svg xmlns="http://www.w3.org/2000/svg" width="90mm" height="90mm"><path d="M 1 1 L 9 9"/></svg>',
        "gcode": "G21\nG90\nM3S700\nG1 X5 Y5 F900\nG1 X9 Y5",
        "hpgl": "IN;SP1;PU10,10;PD400,400;PU;",
    }
    assert contract.check(HARNESSES[name], good[name].encode())
