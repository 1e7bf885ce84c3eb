"""The name of a reader of outside data goes in; a harness that hands it bytes and knows what it promises comes out."""

from __future__ import annotations

import importlib
from pathlib import Path

from fuzz.contract import Reader

CORPUS = Path(__file__).parent / "corpus"
"""A folder of inputs for each harness, all made by ``fuzz/seeds.py`` or found by fuzzing."""

FAMILIES = (
    *("annotated", "arms", "batches", "drawings", "faces", "journals", "lists", "models"),
    *("photos", "plotters", "requests", "robots", "settings", "stored", "studio", "vectors"),
)
"""A file of harnesses each."""


def harnesses() -> dict[str, Reader]:
    """Every harness by its name."""
    found: dict[str, Reader] = {}
    for family in FAMILIES:
        found |= importlib.import_module(f"fuzz.{family}").HARNESSES
    return found


def corpus(name: str) -> list[bytes]:
    """The inputs in the repository, in the order of their names."""
    return [path.read_bytes() for path in sorted((CORPUS / name).glob("*"))]
