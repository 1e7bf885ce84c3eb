"""Settings: every value checked, every text form read back, every mistake named with what was meant."""

from __future__ import annotations

from dataclasses import dataclass

import pytest
from hypothesis import given, strategies as st

from limner.errors import BadInput
from limner.settings import SettingsGroup, group, read_toml, setting, write_toml


@dataclass(frozen=True)
class Inner(SettingsGroup):
    blur: float = setting(1.5, "Blur before the edges", unit="px", low=0, high=50)
    name: str = setting("a", "Which one", choices=("a", "b"))


@dataclass(frozen=True)
class Tree(SettingsGroup):
    points: int | None = setting(None, "At most so many vertices", low=2)
    text: str = setting("", "Any text")
    on: bool = setting(True, "Whether")
    inner: Inner = group(Inner)


@given(
    st.none() | st.integers(2, 10**6),
    st.text(st.characters(codec="utf-8", exclude_categories=["Cs"]), max_size=20),
    st.booleans(),
    st.floats(0, 50),
    st.sampled_from("ab"),
)
def test_toml_gives_back_the_same(points, text, on, blur, name):
    tree = Tree(points, text, on, Inner(blur, name))
    assert read_toml(Tree, write_toml(tree)) == tree


def test_what_is_absent_keeps_its_default():
    assert read_toml(Tree, "[inner]\nblur = 3") == Tree(inner=Inner(blur=3.0))


@pytest.mark.parametrize(
    ("toml", "match"),
    [
        ("inner = 3", "group of settings"),
        ("[inner]\nblurr = 3", "did you mean blur"),
        ("[inner]\nblur = -1", "inner.blur = -1.0 is outside .*0 to 50"),
        ("[inner]\nblur = nan", "outside"),
        ("[inner]\nblur = 'x'", "expected a number"),
        ("[inner]\nname = 'c'", "a | b"),
        ("points = 1.5", "expected a whole number"),
        ("points = true", "expected a whole number"),
        ("points = 1", "at least 2"),
        ("on = 1", "true or false"),
        ("x = [", "not TOML"),
    ],
)
def test_mistakes_are_named(toml, match):
    with pytest.raises(BadInput, match=match) as error:
        read_toml(Tree, toml)
    assert "\n" not in str(error.value).replace("\\n", "")


@pytest.mark.parametrize(
    ("path", "text", "expected"),
    [
        ("points", "600", Tree(points=600)),
        ("inner.blur", "2", Tree(inner=Inner(blur=2.0))),
        ("inner.name", "b", Tree(inner=Inner(name="b"))),
        ("text", "3", Tree(text="3")),
        ("on", "false", Tree(on=False)),
    ],
)
def test_assign_reads_text(path, text, expected):
    assert Tree().assign(path, text) == expected


@pytest.mark.parametrize("path", ["", "inner", "points.x", "inner.blurr", "blur", "inner.blur.x"])
def test_assign_names_a_wrong_path(path):
    with pytest.raises(BadInput, match="does not exist"):
        Tree().assign(path, "1")


def test_auto_takes_a_number_back():
    assert Tree(points=600).assign("points", "auto") == Tree()
    assert read_toml(Tree, "points = 'auto'") == Tree()
    assert Tree().assign("text", "auto") == Tree(text="auto")
    with pytest.raises(BadInput, match="expected a number"):
        Tree().assign("inner.blur", "auto")


def test_walk_names_every_setting():
    assert [path for path, _, _ in Tree.walk()] == ["points", "text", "on", "inner.blur", "inner.name"]


def test_values_are_checked_on_construction_too():
    with pytest.raises(BadInput):
        Inner(blur=99.0)
    assert isinstance(Inner(blur=2).blur, float)
