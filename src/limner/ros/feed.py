"""Reports of joint positions go in, whoever sends them; the last one comes out, if it is fresh."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Sequence

import numpy as np

from limner.errors import BadInput, DeviceFailed
from limner.types import Floats

SILENCE_S = 1.0
"""An arm whose joints are not heard of for so long is lost sight of."""

_KEPT = 100_000


class JointFeed:
    """The joint positions of one arm, as they come in; from any thread."""

    def __init__(self, joints: tuple[str, ...], silence_s: float = SILENCE_S) -> None:
        self.joints, self._silence_s = joints, silence_s
        self._q: Floats | None = None
        self._heard = 0.0
        self._reports = 0
        self._new: deque[Floats] = deque(maxlen=_KEPT)
        self._lock = threading.Lock()

    def take(self, names: Sequence[str], positions: Sequence[float]) -> None:
        """A report; it may hold other joints as well.

        Raises:
            BadInput: joints of this arm are missing, or a position is not finite.
        """
        if missing := [name for name in self.joints if name not in names]:
            raise BadInput(f"joint_states: no {', '.join(missing)}; heard of {', '.join(names) or 'none'}")
        if len(names) != len(positions):
            raise BadInput(f"joint_states: {len(names)} names, {len(positions)} positions; expected one each")
        q = np.array([positions[names.index(name)] for name in self.joints], dtype=np.float64)
        if not np.isfinite(q).all():
            raise BadInput("joint_states: a position is NaN or infinite; expected radians or metres")
        with self._lock:
            self._q, self._heard = q, time.monotonic()
            self._reports += 1
            self._new.append(q)

    @property
    def reports(self) -> int:
        """How many there have been: an arm that has not been heard since is not known to be where it was."""
        return self._reports

    @property
    def heard(self) -> float:
        """When the last one came [s], by the clock that never jumps."""
        return self._heard

    def q(self) -> Floats:
        """Where the arm is: (dof,).

        Raises:
            DeviceFailed: nothing was heard, or not for a while.
        """
        with self._lock:
            if self._q is None:
                raise DeviceFailed("no joint_states have been heard; is the controller running?")
            if (silent := time.monotonic() - self._heard) > self._silence_s:
                raise DeviceFailed(f"no joint_states for {silent:.1f} s; the controller is gone")
            return self._q

    def drain(self) -> list[Floats]:
        """All positions since the last time, oldest first."""
        with self._lock:
            new, self._new = list(self._new), deque(maxlen=_KEPT)
        return new
