"""``import limner`` offers what it says, and each name is where it says."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

import limner


def test_every_public_name_exists_and_is_documented():
    for name in limner.__all__:
        value = getattr(limner, name)
        assert name.startswith("__") or name.isupper() or value.__doc__, name
    assert set(dir(limner)) == set(limner.__all__)


def test_the_type_checker_sees_the_same_names_from_the_same_places():
    tree = ast.parse(Path(limner.__file__).read_text())
    block = next(node for node in tree.body if isinstance(node, ast.If))
    seen = {alias.name: node.module for node in block.body for alias in node.names}
    assert seen == limner._HOME


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'drow'"):
        _ = limner.drow
