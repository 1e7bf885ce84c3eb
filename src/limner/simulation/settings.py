"""What a simulated arm, its pen and its paper are like, and which faults they have."""

from __future__ import annotations

from dataclasses import dataclass

from limner.settings import SettingsGroup, group, setting
from limner.types import JointTrajectory


@dataclass(frozen=True)
class FaultSettings(SettingsGroup):
    """What is wrong, to see whether the drawing survives it."""

    paper_mm: float = setting(0.0, "the paper lies this much higher than planned", unit="mm", low=-100, high=100)
    tilt_deg: float = setting(0.0, "the paper is tilted by this about its middle", unit="deg", low=-20, high=20)
    tilt_towards_deg: float = setting(
        45.0, "direction on the sheet in which the tilt rises, from its lower edge", unit="deg", low=-360, high=360
    )
    repeat_mm: float = setting(
        0.0, "the arm misses each place it comes to rest at by up to this (1 in the thesis)", unit="mm", low=0, high=20
    )
    jitter_ms: float = setting(0.0, "each command comes late by up to this", unit="ms", low=0, high=100)
    seed: int = setting(0, "of the random errors", low=0, high=2**32 - 1)


@dataclass(frozen=True)
class SimulationSettings(SettingsGroup):
    """The arm's servos, the pen, and the paper."""

    press_mm: float | None = setting(
        None,
        "the paper lies this far above the planned way of the tip; not set: as the trajectory says",
        unit="mm",
        low=0,
        high=100,
    )
    stiff: bool = setting(False, "the pen is held stiffly instead of by a spring")
    spring_n_per_m: float = setting(200.0, "stiffness of the pen's spring", unit="N/m", low=1, high=1e5)
    preload_mm: float = setting(5.0, "the spring is compressed by this with the pen all out", unit="mm", low=0, high=50)
    slide_mm: float = setting(6.0, "how far the pen can be pushed in", unit="mm", low=0.1, high=50)
    friction: float = setting(0.3, "of the tip on the paper", low=0, high=2)
    position_gain: float = setting(
        20.0, "velocity that a servo asks for, for its error of position (assumed)", unit="1/s", low=1, high=200
    )
    velocity_hz: float = setting(50.0, "bandwidth of its velocity loop (assumed)", unit="Hz", low=1, high=100)
    feed_forward: bool = setting(True, "the servos are told velocities too, not only positions")
    armature_kg_m2: float = setting(
        0.1, "inertia of each motor seen from its joint (assumed)", unit="kg m^2", low=0, high=10
    )
    command_hz: float = setting(100.0, "commands to the servos per second", unit="Hz", low=10, high=1000)
    fault: FaultSettings = group(FaultSettings)

    def press_for(self, trajectory: JointTrajectory) -> float:
        """How far below the sheet the tip is led [mm]: as set here, else as the trajectory says."""
        return trajectory.press_mm if self.press_mm is None else self.press_mm
