"""A joint trajectory goes in; URScript for an arm of Universal Robots comes out, and is read back."""

from __future__ import annotations

import itertools
import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from limner.errors import BadInput
from limner.settings import SettingsGroup, setting
from limner.types import Floats, JointTrajectory

SUFFIX = ".script"

_JOINTS = 6
_RADIUS_M = 1.0  # an arm's reach: what a turn of a joint moves at most


@dataclass(frozen=True)
class UrSettings(SettingsGroup):
    """How an arm of Universal Robots is told its motion."""

    way: str = setting(
        "servoj",
        "every position at its time, or straight lines that the arm times itself",
        choices=("servoj", "movel"),
    )
    step_s: float = setting(0.008, "time between positions of servoj", unit="s", low=0.002, high=0.1)
    lookahead_s: float = setting(0.1, "how far servoj smooths ahead", unit="s", low=0.03, high=0.2)
    gain: int = setting(300, "how stiffly servoj follows", low=100, high=2000)
    tolerance_mm: float = setting(0.1, "movel may leave the path by this", unit="mm", low=0.001, high=5)
    blend_mm: float = setting(0.3, "largest radius in which movel rounds corners", unit="mm", low=0, high=20)
    speed: float = setting(50.0, "the pen's speed with movel", unit="mm/s", low=0.1, high=1000)
    acceleration: float = setting(500.0, "the pen's acceleration with movel", unit="mm/s^2", low=1, high=1e4)
    lift_mm: float = setting(20.0, "a stopped arm draws its tool back by this", unit="mm", low=1, high=200)


@dataclass(frozen=True, eq=False)
class Moves:
    """What a program makes an arm do.

    Attributes:
        kind: ``movej``, ``movel`` or ``servoj`` of each move.
        q: (n, 6) where each ends [rad].
        t_s: (n,) when it ends, counted from the first position; moves other than servoj take no time here.
    """

    kind: tuple[str, ...]
    q: Floats
    t_s: Floats


def to_urscript(trajectory: JointTrajectory, tips_m: Floats, settings: UrSettings) -> bytes:
    """A program that goes to the first position slowly, then draws.

    Args:
        trajectory: the motion, checked.
        tips_m: (n, 3) where the pen's tip is at each sample.
        settings: servoj or movel, and how.

    Raises:
        BadInput: the arm has not six joints.
    """
    strokes = int(trajectory.stroke.max(initial=-1) + 1)
    return program(
        [
            f"# {strokes} strokes, {trajectory.t_s[-1]:.1f} s; from where the arm is, it first goes slowly to the first"
            " position",
            move_to(trajectory.q[0]),
            *motion(trajectory, tips_m, settings),
        ]
    )


def program(lines: list[str]) -> bytes:
    """Lines as one program, which the arm begins with when it has all of it."""
    return "\n".join(["def limner():", *(f"  {line}" for line in lines), "end", ""]).encode("ascii")


def move_to(q: Floats) -> str:
    """The line that goes to joint positions slowly, straight in joint space."""
    return f"movej({_list(q)}, a=0.5, v=0.25)"


def motion(trajectory: JointTrajectory, tips_m: Floats, settings: UrSettings) -> list[str]:
    """The lines that follow a trajectory from its first position and come to rest at its last.

    Raises:
        BadInput: the arm has not six joints.
    """
    check_joints(trajectory.names)
    return _streamed(trajectory, settings) if settings.way == "servoj" else _lines(trajectory, tips_m, settings)


def check_joints(names: Sequence[str]) -> None:
    """Refuse arms that URScript is not for.

    Raises:
        BadInput: there are not six joints.
    """
    if len(names) != _JOINTS:
        raise BadInput(f"URScript is for arms of {_JOINTS} joints; this one has {len(names)}")


def _streamed(trajectory: JointTrajectory, settings: UrSettings) -> list[str]:
    start, end = trajectory.t_s[[0, -1]]
    t = start + settings.step_s * np.arange(1, int(np.ceil((end - start) / settings.step_s - 1e-9)) + 1)
    tail = f"{settings.lookahead_s:g}, {settings.gain})"
    lines = [f"servoj({_list(q)}, 0, 0, {settings.step_s:g}, {tail}" for q in trajectory.at(t)]
    # The arm lags behind by what it looks ahead, and would be stopped before it arrives.
    return [*lines, f"servoj({_list(trajectory.q[-1])}, 0, 0, {settings.lookahead_s:g}, {tail}", "stopj(2)"]


def _lines(trajectory: JointTrajectory, tips_m: Floats, settings: UrSettings) -> list[str]:
    lines = []
    for a, b in _stretches(trajectory):
        part = slice(a, b + 1)
        drawing = bool(trajectory.down[b])
        # Positions of joints, not poses: whatever tool the controller knows of, it arrives where it was checked.
        way = tips_m[part] if drawing else np.column_stack([tips_m[part], _RADIUS_M * trajectory.q[part]])
        kept = a + _simplified(way, settings.tolerance_mm / 1000)
        for k, radius in zip(kept[1:], _blends(tips_m[kept], settings.blend_mm / 1000), strict=True):
            if drawing:
                speeds = f"a={settings.acceleration / 1000:g}, v={settings.speed / 1000:g}"
            else:
                fastest = (max(float(np.abs(x[part]).max()), 0.01) for x in (trajectory.qdd, trajectory.qd))
                speeds = "a={:.4f}, v={:.4f}".format(*fastest)
            lines.append(f"{'movel' if drawing else 'movej'}({_list(trajectory.q[k])}, {speeds}, r={radius:.6f})")
    return lines


def _stretches(trajectory: JointTrajectory) -> list[tuple[int, int]]:
    """First and last sample of each stroke and each travel."""
    changes = np.flatnonzero(np.diff(trajectory.stroke[1:])) + 1
    return list(itertools.pairwise([0, *changes.tolist(), len(trajectory.t_s) - 1]))


def _simplified(points: Floats, tolerance: float) -> Floats:
    """Indices of the points that a polyline (n, d) needs to stay within ``tolerance`` (Douglas & Peucker 1973)."""
    kept, todo = {0, len(points) - 1}, [(0, len(points) - 1)]
    while todo:
        a, b = todo.pop()
        if b - a < 2:
            continue
        along, inner = points[b] - points[a], points[a + 1 : b] - points[a]
        part = np.clip(inner @ along / max(float(along @ along), 1e-18), 0, 1)
        off = np.linalg.norm(inner - part[:, None] * along, axis=1)
        if off.max() > tolerance:
            middle = a + 1 + int(off.argmax())
            kept.add(middle)
            todo += [(a, middle), (middle, b)]
    return np.array(sorted(kept))


def _blends(points: Floats, largest: float) -> Floats:
    """Radius (n - 1,) of the corner at each point but the first: never overlapping, none at the end."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    radii = np.zeros(len(steps))
    radii[:-1] = np.minimum(largest, 0.45 * np.minimum(steps[:-1], steps[1:]))
    return radii


def _list(q: Floats) -> str:
    return "[" + ", ".join(f"{value:.8f}" for value in q) + "]"


_MOVE = re.compile(r"(movej|movel|servoj)\(\[([^\]]*)\], ([^()\[\]]*)\)")
_OTHER = re.compile(r"stopj\([\d.]+\)|#.*")


def read_urscript(data: bytes) -> Moves:
    """The moves of a program that ``to_urscript`` wrote.

    Raises:
        BadInput: no such program, or not all of it.
    """
    lines = [line.strip() for line in data.decode("ascii", "replace").splitlines()]
    if lines[:1] != ["def limner():"] or lines[-1:] != ["end"]:
        raise BadInput("URScript: expected a program from 'def limner():' to 'end'")
    return read_moves([line for line in lines[1:-1] if not _OTHER.fullmatch(line)])


def read_moves(lines: list[str]) -> Moves:
    """The moves of lines that are nothing else.

    Raises:
        BadInput: a line is another, or a number is none.
    """
    kinds, positions, steps = [], [], []
    for line in lines:
        found = _MOVE.fullmatch(line)
        try:
            values = [float(value) for value in found[2].split(",")] if found else []
            step = float(found[3].split(",")[2]) if found and found[1] == "servoj" else 0.0
        except (ValueError, IndexError):
            values = []
        if found is None or len(values) != _JOINTS or not np.isfinite([*values, step]).all():
            raise BadInput(f"URScript: no move of {_JOINTS} joints: {line[:80]}")
        kinds.append(found[1])
        positions.append(values)
        steps.append(step)
    return Moves(tuple(kinds), np.array(positions).reshape(-1, _JOINTS), np.cumsum(steps))
