"""The definition of FollowJointTrajectory goes in; message classes come out that any ROS 1 controller understands."""

from __future__ import annotations

import functools
from importlib import resources
from types import SimpleNamespace
from typing import Any

NAME = "FollowJointTrajectory"

_TOLERANCE = "string name\nfloat64 position\nfloat64 velocity\nfloat64 acceleration\n"
_BREAK = "\n" + "=" * 80 + "\n"


def definitions() -> dict[str, str]:
    """Text of each message of the action in ``control_msgs``, by its name; what an action consists of is genaction's.

    Debian packages no control_msgs, so they are generated when needed.
    """
    text = (resources.files(__package__) / f"{NAME}.action").read_text()
    goal, result, feedback = text.split("---\n")
    parts = {"Goal": goal, "Result": result, "Feedback": feedback}
    whole = {f"{NAME}{part}": body for part, body in parts.items()}
    for part in parts:
        first = "actionlib_msgs/GoalID goal_id" if part == "Goal" else "actionlib_msgs/GoalStatus status"
        whole[f"{NAME}Action{part}"] = f"Header header\n{first}\n{NAME}{part} {part.lower()}\n"
    fields = [f"{NAME}Action{part} action_{part.lower()}\n" for part in parts]
    return {f"{NAME}Action": "".join(fields), **whole, "JointTolerance": _TOLERANCE}


@functools.cache
def generated(dynamic: Any, others: tuple[Any, ...]) -> SimpleNamespace:
    """Classes of the action's messages, by their names in ``control_msgs``.

    Args:
        dynamic: the module ``genpy.dynamic``.
        others: message classes of other packages that the definitions name.
    """
    texts = definitions()
    core = texts.pop(f"{NAME}Action")
    parts = [core, *(f"MSG: control_msgs/{name}\n{text}" for name, text in texts.items())]
    parts += [f"MSG: {other._type}\n{_own_text(other)}" for other in others]
    classes = dynamic.generate_dynamic(f"control_msgs/{NAME}Action", _BREAK.join(parts))
    return SimpleNamespace(
        **{name.partition("/")[2]: kind for name, kind in classes.items() if name.startswith("control_msgs/")}
    )


def _own_text(kind: Any) -> str:
    """A class keeps the text of all that it contains behind its own."""
    text: str = kind._full_text
    return text.split("\n" + "=" * 80, 1)[0]
