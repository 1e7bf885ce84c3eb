"""Where the pen, and each joint, is at which time."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from limner.errors import BadInput
from limner.types.values import Floats, Value, frozen_array


@dataclass(frozen=True, eq=False)
class PenPath(Value):
    """Where the pen is at which time.

    Attributes:
        t_s: (n,) not decreasing.
        position_mm: (n, 3) of the tip, paper frame.
        down: (n,) whether the move that ends here draws.
        stroke: (n,) index of the stroke, -1 in travel.
    """

    t_s: Floats
    position_mm: Floats
    down: NDArray[np.bool_]
    stroke: NDArray[np.int64]

    def __post_init__(self) -> None:
        self._freeze("t_s", frozen_array(self.t_s, np.float64, (None,), "PenPath.t_s"))
        n = len(self.t_s)
        self._freeze("position_mm", frozen_array(self.position_mm, np.float64, (n, 3), "PenPath.position_mm"))
        self._freeze("down", frozen_array(self.down, np.bool_, (n,), "PenPath.down"))
        self._freeze("stroke", frozen_array(self.stroke, np.int64, (n,), "PenPath.stroke"))
        _check_time(self.t_s, "PenPath.t_s")

    def at(self, t_s: ArrayLike) -> Floats:
        """Position of the tip [mm] at the given times, linear between samples, held before and after: (..., 3)."""
        return _interpolate(t_s, self.t_s, self.position_mm)


def _no_sheet() -> Floats:
    return np.zeros((0, 3))


@dataclass(frozen=True, eq=False)
class JointTrajectory(Value):
    """Where each joint is at which time.

    Attributes:
        names: of the joints (dof).
        t_s: (n,) not decreasing.
        q, qd, qdd: (n, dof) position, velocity, acceleration [rad or m, per s, per s^2].
        down: (n,) whether the move that ends here draws.
        stroke: (n,) index of the stroke, -1 in travel.
        press_mm: how far below the sheet the tip is led where it draws; a spring takes it up.
        sheet_m: (4, 3) corners of the sheet it was planned for, counter-clockwise from the lower left, in the robot's
            base frame [m]; (0, 3) where nobody says.
    """

    names: tuple[str, ...]
    t_s: Floats
    q: Floats
    qd: Floats
    qdd: Floats
    down: NDArray[np.bool_]
    stroke: NDArray[np.int64]
    press_mm: float = 0.0
    sheet_m: Floats = field(default_factory=_no_sheet)

    def __post_init__(self) -> None:
        self._freeze("names", tuple(str(name) for name in self.names))
        self._freeze("t_s", frozen_array(self.t_s, np.float64, (None,), "JointTrajectory.t_s"))
        n, dof = len(self.t_s), len(self.names)
        for name in ("q", "qd", "qdd"):
            array = frozen_array(getattr(self, name), np.float64, (n, dof), f"JointTrajectory.{name}")
            self._freeze(name, array)
        self._freeze("down", frozen_array(self.down, np.bool_, (n,), "JointTrajectory.down"))
        self._freeze("stroke", frozen_array(self.stroke, np.int64, (n,), "JointTrajectory.stroke"))
        _check_time(self.t_s, "JointTrajectory.t_s")
        self._freeze("press_mm", float(self.press_mm))
        if not 0 <= self.press_mm <= 100:
            raise BadInput(f"JointTrajectory.press_mm: {self.press_mm:g} mm, expected 0 to 100")
        corners = np.zeros((0, 3)) if np.size(self.sheet_m) == 0 else self.sheet_m
        given = frozen_array(corners, np.float64, (None, 3), "JointTrajectory.sheet_m")
        if len(given) not in (0, 4):
            raise BadInput(f"JointTrajectory.sheet_m: expected four corners or none, got {len(given)}")
        self._freeze("sheet_m", given)

    def at(self, t_s: ArrayLike) -> Floats:
        """Joint positions at the given times, linear between samples, held before and after: (..., dof)."""
        return _interpolate(t_s, self.t_s, self.q)


def _check_time(t_s: Floats, name: str) -> None:
    if len(t_s) < 1:
        raise BadInput(f"{name}: expected at least one sample, got none")
    if (np.diff(t_s) < 0).any():
        raise BadInput(f"{name}: expected times that never go back")


def _interpolate(t_s: ArrayLike, times_s: Floats, values: Floats) -> Floats:
    t = np.asarray(t_s, dtype=np.float64)
    columns = [np.interp(t, times_s, values[:, k]) for k in range(values.shape[1])]
    return np.stack(columns, axis=-1)
