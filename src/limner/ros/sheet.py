"""Plans and probed points go in; where the sheet lies comes out."""

from __future__ import annotations

import numpy as np

from limner.errors import BadInput
from limner.motion.arm.calibrate import calibrate
from limner.motion.arm.paper import Placement
from limner.types import Floats

ENOUGH = 3
"""So many points tell how a sheet lies."""

_PROBED = ("probed",)


class Sheet:
    """A sheet stays where it was found to lie until another is asked for, or it is probed anew."""

    def __init__(self) -> None:
        self._points: list[Floats] = []
        self._placement: Placement | None = None
        self._found_for: tuple[object, ...] = ()

    def lies(self, wanted: tuple[object, ...]) -> Placement | None:
        """Where it lies, if that was probed, or found for the same robot, page and settings."""
        return self._placement if self._found_for in (_PROBED, wanted) else None

    def found(self, placement: Placement, wanted: tuple[object, ...]) -> None:
        """It lies there, for this robot, page and settings."""
        self._placement, self._found_for = placement, wanted

    def probe(self, point_m: Floats) -> tuple[str, bool]:
        """Take a point (3,) of it in the robot's base frame.

        Returns:
            What came of it, in words, and whether by now it is known where the sheet lies.

        Raises:
            BadInput: the point is not finite, or the points are no sheet.
        """
        if point_m.shape != (3,) or not np.isfinite(point_m).all():
            raise BadInput("calibrate_point: the point is NaN or infinite; expected metres")
        points = [*self._points, point_m]
        if len(points) < ENOUGH:
            self._points = points
            return f"point {len(points)}; {ENOUGH - len(points)} more at least", False
        found = calibrate(np.array(points))
        self._points = points
        self.found(Placement(found.base_from_paper), _PROBED)
        told = (
            f"point {len(points)}: {found.used.sum()} of them fit a plane to {found.rms_mm:.2f} mm, tilted by"
            f" {found.tilt_deg:.2f} deg; ~plan plans for it"
        )
        return told, True

    def forget(self) -> int:
        """Probe anew: the next point is its lower left corner; how many there were."""
        count = len(self._points)
        self._points, self._placement, self._found_for = [], None, ()
        return count
