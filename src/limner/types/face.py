"""A face in a photo: its landmarks, its box, and the unit in which lengths on it are given."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from limner.errors import BadInput
from limner.types.values import Floats, Value, frozen_array

LANDMARK_COUNTS = (68, 39)
"""Points of a frontal face (iBUG-68) and of a profile (MultiPIE-39)."""


@dataclass(frozen=True, eq=False)
class Face(Value):
    """A face found in a photo.

    Attributes:
        points_px: (68, 2) landmarks in iBUG-68 order, or (39, 2) in MultiPIE-39 order for a profile; photo frame.
        box_px: (4,) x0, y0, x1, y1 around the face.
        score: the detector's own, higher is better.
        yaw_deg: turn of the head; positive = the nose points to image right.
        detector: the name of what found it.
    """

    points_px: Floats
    box_px: Floats
    score: float = 0.0
    yaw_deg: float = 0.0
    detector: str = "file"

    def __post_init__(self) -> None:
        self._freeze("points_px", frozen_array(self.points_px, np.float64, (None, 2), "Face.points_px"))
        self._freeze("box_px", frozen_array(self.box_px, np.float64, (4,), "Face.box_px"))
        if len(self.points_px) not in LANDMARK_COUNTS:
            raise BadInput(f"Face.points_px: expected 68 or 39 landmarks, got {len(self.points_px)}")
        for name in ("score", "yaw_deg"):
            self._freeze(name, float(frozen_array(getattr(self, name), np.float64, (), f"Face.{name}")))
        if not isinstance(self.detector, str):
            raise BadInput(f"Face.detector: expected a name, got {self.detector!r}")
        if self.box_px[2] <= self.box_px[0] or self.box_px[3] <= self.box_px[1]:
            raise BadInput(f"Face.box_px: expected x0 < x1 and y0 < y1, got {self.box_px.tolist()}")

    @property
    def frontal(self) -> bool:
        """Whether all 68 landmarks are there, as the drawing needs."""
        return len(self.points_px) == 68

    @property
    def outer_eye_px(self) -> float:
        """Distance of the outer eye corners, the unit in which lengths on a face are given.

        Raises:
            BadInput: the face is a profile, or both corners are one point.
        """
        if not self.frontal:
            raise BadInput("face: a profile of 39 landmarks has one eye; expected a frontal face with 68")
        distance = float(np.hypot(*(self.points_px[45] - self.points_px[36])))
        if distance < 1e-6:
            raise BadInput("face: both outer eye corners (landmarks 36 and 45) are one point; expected two places")
        return distance
