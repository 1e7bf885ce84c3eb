"""Shared fixtures: the folder with data and reference numbers that may lie beside the checkout."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

SHARED = Path(__file__).parents[2] / "shared"


@pytest.fixture(scope="session")
def shared() -> Path:
    """The folder ``shared`` beside the checkout; tests that need it skip where it is absent."""
    if not SHARED.is_dir():
        pytest.skip("needs the folder 'shared' (data and reference numbers) beside the checkout")
    return SHARED


def pytest_collection_modifyitems(config, items):
    if os.environ.get("LIMNER_SLOW") == "1" or config.option.markexpr:
        return
    skip = pytest.mark.skip(reason="slow: set LIMNER_SLOW=1 to run it")
    for item in items:
        if "slow" in item.keywords:
            item.add_marker(skip)
