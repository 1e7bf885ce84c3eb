"""Bytes of a saved value go in, to be read as each of the types."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from fuzz.contract import Broken
from limner import storage
from limner.errors import LimnerError
from limner.targets import joints
from limner.types import JointTrajectory


def _each(read: Callable[[type[Any], bytes], Any], data: bytes) -> None:
    for kind in storage.STORED:
        try:
            value = read(kind, data)
        except LimnerError as error:
            if not str(error).isprintable():
                raise Broken(repr(str(error))) from error
            continue
        assert storage.from_json(kind, storage.to_json(value)) == value
        assert storage.from_npz(kind, storage.to_npz(value)) == value


def stored_json(data: bytes) -> None:
    """JSON of each type; what was read comes back from JSON and npz as it is."""
    _each(storage.from_json, data)


def stored_npz(data: bytes) -> None:
    """Likewise npz."""
    _each(storage.from_npz, data)


def joints_csv(data: bytes) -> None:
    """A table of joint positions."""
    motion = joints.from_csv(data, "motion.csv")
    assert storage.from_json(JointTrajectory, storage.to_json(motion)) == motion
    assert joints.from_csv(joints.to_csv(motion), "again") == motion


HARNESSES = {"json": stored_json, "npz": stored_npz, "joints-csv": joints_csv}
