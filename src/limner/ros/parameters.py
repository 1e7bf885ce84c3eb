"""Parameters of the node go in, read anew each time; settings, robot and names come out, or what is wrong with one."""

from __future__ import annotations

import os
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from limner import storage
from limner.errors import BadInput
from limner.motion.arm.robot import Robot
from limner.motion.arm.robots import load_robot
from limner.pipeline import Settings, changed
from limner.ros.feed import SILENCE_S
from limner.settings import read_toml

TARGETS = ("action", "command", "none")
"""What draws: an action server, a command topic, or a preview in the node itself."""

TREES = ("chain", "paper")
"""Transforms that the node sends: base_link to pen_tip, or the sheet where a robot_state_publisher has the rest."""

_SILENCES_S = (0.1, 60.0)

_SHORT = {"style": "style", "page": "page", "points": "points", "minutes": "minutes", "place": "arm.place.at"}
_NAMES = ("photo", "drawing", "robot", "settings", "target", "controller", "auto", "journal", "silence", "tf", *_SHORT)


@dataclass(frozen=True)
class Fixed:
    """What is read once.

    Attributes:
        robot: name of the arm, or its URDF.
        controller: name of the arm's controller.
        target: one of ``TARGETS``.
        tf: one of ``TREES``.
        journal: file that says what is drawn.
        silence_s: an arm that is not heard of for so long is lost sight of.
    """

    robot: str
    controller: str
    target: str
    tf: str
    journal: Path
    silence_s: float


def settings(given: dict[str, Any]) -> Settings:
    """Settings from parameters: ``settings`` is a TOML file or a tree, single ones have names of their own.

    Raises:
        BadInput: a parameter that does not exist, or a value outside its limits.
    """
    if unknown := [name for name in given if name not in _NAMES]:
        raise BadInput(f"parameter ~{unknown[0]} does not exist; choose from {', '.join(sorted(_NAMES))}")
    base = given.get("settings", {})
    if isinstance(base, str):
        chosen = read_toml(Settings, storage.read_bytes(base).decode("utf-8", "replace"))
    else:
        chosen = Settings.from_dict(base)
    return changed(chosen, {_SHORT[name]: value for name, value in given.items() if name in _SHORT})


def fixed(given: dict[str, Any]) -> tuple[Fixed, Robot]:
    """What is read once, and the robot.

    Raises:
        BadInput: no such robot, target or tree, or a silence that is no time.
    """
    name = str(given.get("robot", "dumbo"))
    robot = load_robot(name)
    target, tree = str(given.get("target", "action")), str(given.get("tf", "chain"))
    for what, value, choices in (("target", target, TARGETS), ("tf", tree, TREES)):
        if value not in choices:
            raise BadInput(f"parameter ~{what} = '{value}'; choose {', '.join(choices)}")
    home = os.environ.get("ROS_HOME") or tempfile.gettempdir()
    journal = Path(str(given.get("journal", Path(home) / "limner.journal")))
    controller = str(given.get("controller", robot.controller or "arm_controller"))
    return Fixed(name, controller, target, tree, journal, _silence(given.get("silence", SILENCE_S))), robot


def _silence(value: Any) -> float:
    low, high = _SILENCES_S
    if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
        raise BadInput(f"parameter ~silence = {value!r}; expected {low:g} to {high:g} seconds")
    return float(value)
