"""What a training has reached in; a file from which it can go on, out, and back."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from limner.errors import BadInput
from limner.settings import SettingsGroup, write_toml
from limner.storage import pack_npz, read_bytes, unpack_npz, write_whole
from limner.types import Floats
from limner.vision.landmarks.fmp.examples import Examples, Placed, Round
from limner.vision.landmarks.fmp.learning import Learned
from limner.vision.landmarks.fmp.model import FmpModel, pack_model, unpack_model
from limner.vision.landmarks.fmp.solver import Report


@dataclass(frozen=True, eq=False)
class State:
    """A training between two rounds.

    Attributes:
        model: so far.
        start: weights that the solution is drawn to.
        placed: where the examples are, faces first.
        groups: which slack each shares.
        alpha: their dual variables.
        rounds: that were run.
        curve: how well models of ever more people do.
    """

    model: FmpModel
    start: Floats
    placed: tuple[Placed, ...]
    groups: tuple[int, ...]
    alpha: Floats
    rounds: tuple[Round, ...]
    curve: tuple[Learned, ...]


def ticket(settings: SettingsGroup, names: Sequence[str]) -> str:
    """What tells one training from another: its settings and the names of its faces and scenes."""
    return hashlib.sha256("\n".join([write_toml(settings), *names]).encode()).hexdigest()


def save(examples: Examples, rounds: Sequence[Round], curve: Sequence[Learned], path: Path, owner: str) -> None:
    """Write the state after a round.

    Raises:
        BadInput: the file cannot be written.
    """
    table = np.array([(at.source, at.level, at.component) for at in examples.placed], np.int64).reshape(-1, 3)
    arrays = {
        "ticket": np.array(owner),
        "model": np.frombuffer(pack_model(examples.model), np.uint8),
        "start": examples.start,
        "table": table,
        "cells": np.array([at.cells for at in examples.placed], np.int64),
        "groups": np.array(examples.problem.groups, np.int64),
        "alpha": examples.problem.alpha,
        "rounds": np.array(json.dumps([dataclasses.asdict(item) for item in rounds])),
        "curve": np.array(json.dumps([item.to_dict() for item in curve])),
    }
    write_whole(path, pack_npz(arrays))


def load(path: Path, owner: str) -> State:
    """Read a state.

    Raises:
        BadInput: unreadable, or of another training.
    """
    arrays = unpack_npz(read_bytes(path, 2**31), str(path), 2**32)
    if str(arrays.get("ticket")) != owner:
        raise BadInput(f"{path}: the state of a training with other settings or pictures; remove it, or name another")
    try:
        return _state(arrays, str(path))
    except (KeyError, TypeError, ValueError, OverflowError, RecursionError) as error:
        raise BadInput(f"{path}: the state of a training, damaged ({error}); remove it") from error


def _state(arrays: Mapping[str, NDArray[Any]], name: str) -> State:
    rounds = [Round(**{**item, "solution": Report(**item["solution"])}) for item in json.loads(str(arrays["rounds"]))]
    placed = [
        Placed(int(source), int(level), int(component), cells)
        for (source, level, component), cells in zip(arrays["table"], arrays["cells"], strict=True)
    ]
    model = unpack_model(arrays["model"].tobytes(), name)
    groups = tuple(int(group) for group in arrays["groups"])
    curve = tuple(Learned(**item) for item in json.loads(str(arrays["curve"])))
    return State(model, arrays["start"], tuple(placed), groups, arrays["alpha"], tuple(rounds), curve)
