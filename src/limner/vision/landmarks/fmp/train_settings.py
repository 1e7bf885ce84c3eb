"""The settings of training a flexible mixture of parts, and the poses of its mixtures that follow from them."""

from __future__ import annotations

from dataclasses import dataclass

from limner.settings import SettingsGroup, setting
from limner.vision.landmarks.fmp.positives import Pose


@dataclass(frozen=True)
class TrainSettings(SettingsGroup):
    """How a model is trained."""

    seed: int = setting(0, "Of everything random", low=0, high=2**31)
    eye_cells: float = setting(14.0, "Distance of the outer eye corners in the template", unit="cells", low=3, high=60)
    cell_px: int = setting(4, "Side of a HOG cell", unit="px", low=2, high=16)
    interval: int = setting(4, "Sizes tried from one size to its half", low=1, high=20)
    yaw_deg: float = setting(0.0, "Turn of the two turned mixtures; 0 for none", unit="deg", low=0, high=25)
    tilt_deg: float = setting(0.0, "Tilt of the two tilted mixtures; 0 for none", unit="deg", low=0, high=45)
    shared: bool = setting(False, "All mixtures use the same filters, one for each landmark; springs are their own")
    yaw_reach_deg: float = setting(8.0, "Faces are shown turned by up to this more or less", unit="deg", low=0, high=15)
    tilt_reach_deg: float = setting(
        11.0, "Faces are shown tilted by up to this more or less", unit="deg", low=0, high=30
    )
    zoom: float = setting(1.09, "Faces are shown larger or smaller by up to this factor", low=1, high=1.5)
    views: int = setting(1, "Random views of each face for each mixture, and as many mirrored", low=1, high=50)
    overlap: float = setting(0.6, "Least overlap of a part's box with its landmark's", low=0.1, high=0.95)
    stiffness: float = setting(10.0, "Springs of the first model, times their log density", low=0.01, high=1000)
    prior: float = setting(1.0, "Share of the first model that weights are drawn to; 0 = to nothing", low=0, high=1)
    cost: float = setting(0.002, "C, of a margin that is missed", low=1e-8, high=1e4)
    positive_weight: float = setting(2.0, "Times C for a face", low=0.01, high=100)
    gap: float = setting(0.02, "Relative duality gap at which a solution will do", low=1e-6, high=0.5)
    rounds: int = setting(3, "Times that hard negatives are gathered and all weights solved for", low=1, high=50)
    per_scene: int = setting(10, "Hard negatives from one scene in a round, at most", low=1, high=1000)
    scene_px: int = setting(360, "Longer side of a scene", unit="px", low=64, high=4000)
    patches: int = setting(
        20_000, "Patches of the scenes for the statistics of what is no face", low=100, high=1_000_000
    )
    scenes: int = setting(130, "Scenes that a round looks through, drawn from those there are", low=1, high=100_000)
    textures: int = setting(126, "Made-up pictures among the scenes", low=0, high=10_000)
    memory_mb: int = setting(2000, "Features held at once, at most", unit="MB", low=10, high=100_000)
    caution: float = setting(
        0.4, "Threshold: 0 = score of what is most like a face, 1 = score of all but 5 % of the faces", low=0, high=1
    )

    @property
    def poses(self) -> tuple[Pose, ...]:
        """One for each mixture: straight, tilted either way, turned either way."""
        reach = (self.yaw_reach_deg, self.tilt_reach_deg)
        tilted = [Pose(0, tilt, *reach) for tilt in (self.tilt_deg, -self.tilt_deg) if tilt]
        turned = [Pose(yaw, 0, *reach) for yaw in (self.yaw_deg, -self.yaw_deg) if yaw]
        return (Pose(0, 0, *reach), *tilted, *turned)
