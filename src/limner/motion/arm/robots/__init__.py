"""The name of a robot, or a URDF of one's own, goes in; the arm comes out."""

from __future__ import annotations

import dataclasses
import tomllib
from importlib import resources
from pathlib import Path
from typing import Any

from limner import storage
from limner.errors import BadInput
from limner.motion.arm.robot import Robot
from limner.motion.arm.urdf import ChainRequest, parse_urdf

ROBOTS = ("dumbo", "lwa4d", "ur5e")
"""Robots that come with limner."""


def load_robot(source: str | Path, base: str = "", tip: str = "") -> Robot:
    """A robot by name, or from a file.

    Args:
        source: one of ``ROBOTS``, or a .urdf; beside it a .toml of the same name may hold what URDF cannot say (the
            fields of ``ChainRequest``).
        base: link that the chain starts from, instead of the robot's own.
        tip: link at the tip of the pen, likewise.

    Raises:
        BadInput: no such robot or file, or one that cannot be used.
        MissingExtra: the URDF reader is not installed.
    """
    urdf, toml = _files(str(source))
    robot = parse_urdf(urdf, str(source), _request(toml, str(source), base, tip))
    return dataclasses.replace(robot, name=Path(source).stem)


def _files(source: str) -> tuple[bytes, bytes]:
    if source in ROBOTS:
        folder = resources.files(__name__)
        return (folder / f"{source}.urdf").read_bytes(), (folder / f"{source}.toml").read_bytes()
    path = Path(source)
    if path.suffix.lower() != ".urdf":
        raise BadInput(f"robot: '{source}' is not known; choose {', '.join(ROBOTS)}, or a file ending in .urdf")
    beside = path.with_suffix(".toml")
    return storage.read_bytes(path), storage.read_bytes(beside) if beside.exists() else b""


def _request(toml: bytes, source: str, base: str, tip: str) -> ChainRequest:
    try:
        values: dict[str, Any] = tomllib.loads(toml.decode())
    except (ValueError, RecursionError) as error:
        raise BadInput(f"{Path(source).with_suffix('.toml')}: is no TOML ({error})") from error
    values |= {name: link for name, link in (("base", base), ("tip", tip)) if link}
    fields = {field.name for field in dataclasses.fields(ChainRequest)}
    if unknown := sorted(set(values) - fields):
        raise BadInput(
            f"{Path(source).with_suffix('.toml')}: {unknown[0]} does not exist; choose {', '.join(sorted(fields))}"
        )
    for name, value in values.items():
        if not isinstance(value, _KINDS[name]):
            wanted = _KINDS[name].__name__
            raise BadInput(f"{Path(source).with_suffix('.toml')}: {name} = {value!r}, expected a {wanted}")
    for name in ("acceleration", "jerk"):
        if name in values:
            values[name] = tuple(values[name])
    return ChainRequest(**values)


_KINDS: dict[str, type] = {"base": str, "tip": str, "controller": str, "frozen": dict, "poses": dict}
_KINDS |= {"acceleration": list, "jerk": list, "sheet_box_m": list}
