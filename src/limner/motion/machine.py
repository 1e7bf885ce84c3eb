"""The name of a machine or a TOML file goes in; how fast it can draw, and on what area, comes out."""

from __future__ import annotations

import math
from dataclasses import dataclass
from importlib import resources
from pathlib import Path

import numpy as np

from limner import settings, storage
from limner.errors import BadInput
from limner.settings import SettingsGroup, setting
from limner.types import Floats, Page

MACHINES = ("axidraw", "grbl", "brachiograph", "dumbo")
"""The machines that limner knows; a TOML file describes any other."""

CORNERS = ("arc", "deviation", "stop")
"""What limits the speed at a vertex, see ``Machine.corner``."""

HOMES = ("lower-left", "upper-left")

TYPICAL_TURN_RAD = math.radians(30)
"""How much a stroke of a portrait turns at a vertex, for the linear estimate of time."""


@dataclass(frozen=True)
class CostModel:
    """What drawing costs, roughly: seconds = the sum of each number times what it counts.

    Attributes:
        stroke_s: of a stroke: pen down and up, starting and stopping, its own and of the travel to it.
        point_s: of a vertex of a stroke.
        ink_s_per_mm: of pen-down length.
        travel_s_per_mm: of pen-up length.
    """

    stroke_s: float
    point_s: float
    ink_s_per_mm: float
    travel_s_per_mm: float


@dataclass(frozen=True)
class Machine(SettingsGroup):
    """How a machine moves its pen. Speeds and accelerations hold along the path, in any direction."""

    name: str = setting("plotter", "What it is called")
    width_mm: float = setting(300.0, "Width of the work area", unit="mm", low=1, high=100_000)
    height_mm: float = setting(200.0, "Height of the work area", unit="mm", low=1, high=100_000)
    home: str = setting("lower-left", "Corner of the page at which the pen starts and ends", choices=HOMES)
    draw_mm_s: float = setting(40.0, "Greatest speed with the pen down", unit="mm/s", low=0.01, high=10_000)
    draw_mm_s2: float = setting(500.0, "Acceleration with the pen down", unit="mm/s2", low=0.01, high=1e6)
    travel_mm_s: float = setting(100.0, "Greatest speed with the pen up", unit="mm/s", low=0.01, high=10_000)
    travel_mm_s2: float = setting(500.0, "Acceleration with the pen up", unit="mm/s2", low=0.01, high=1e6)
    corner: str = setting(
        "arc",
        "What limits the speed at a vertex: deviation = as on an arc that cuts the corner by corner_mm (as GRBL does),"
        " arc = that, and as on the arc through its neighbours; stop = a halt at each",
        choices=CORNERS,
    )
    corner_mm: float = setting(0.05, "How far that arc would leave the corner", unit="mm", low=1e-4, high=10)
    pen_down_s: float = setting(0.2, "Time to lower the pen", unit="s", low=0.01, high=60)
    pen_up_s: float = setting(0.2, "Time to raise the pen", unit="s", low=0.01, high=60)
    lift_mm: float = setting(5.0, "How high the pen is raised", unit="mm", low=0.1, high=200)
    point_s: float = setting(0.0, "Least time of a move, for a machine that halts at each", unit="s", low=0, high=60)

    def home_mm(self, page: Page) -> Floats:
        """Where the pen starts and ends on a page: (2,), page frame."""
        return np.array([0.0, page.height_mm if self.home == "upper-left" else 0.0])

    @property
    def stops(self) -> bool:
        """Whether it halts at each vertex."""
        return self.corner == "stop" or self.point_s > 0

    def cost_model(self) -> CostModel:
        """A linear estimate of the time, for choosing strokes; ``seconds`` of ``limner.motion.cost`` is exact.

        A move from rest to rest takes the time at full speed plus speed / acceleration; a slower corner costs
        (v - corner speed)^2 / (a v).
        """
        lifts_s = self.pen_down_s + self.pen_up_s
        if self.point_s > 0:
            return CostModel(lifts_s, self.point_s, 0.0, 0.0)
        start_stop_s = self.draw_mm_s / self.draw_mm_s2 + self.travel_mm_s / self.travel_mm_s2
        corner = 0.0 if self.stops else float(self.corner_speeds(np.array([TYPICAL_TURN_RAD]))[0])
        point_s = (self.draw_mm_s - corner) ** 2 / (self.draw_mm_s2 * self.draw_mm_s)
        return CostModel(lifts_s + start_stop_s, point_s, 1 / self.draw_mm_s, 1 / self.travel_mm_s)

    def corner_speeds(self, turn_rad: Floats, reach_mm: Floats | None = None) -> Floats:
        """Greatest speed at vertices [mm/s], pen down.

        As GRBL's junction deviation: the speed whose centripetal acceleration on an arc that touches both segments
        and passes the vertex at ``corner_mm`` is the acceleration; with the rule ``arc`` no more than on the arc that
        turns as much over the length of the neighbours, so that a circle is no faster for being drawn in many pieces.

        Args:
            turn_rad: (n,) change of direction, 0 = straight on.
            reach_mm: (n,) mean length of the two segments that meet; none for very long ones.
        """
        if self.stops:
            return np.zeros(len(turn_rad))
        with np.errstate(divide="ignore"):
            squared = self.draw_mm_s2 * self.corner_mm * np.cos(turn_rad / 2) / (2 * np.sin(turn_rad / 4) ** 2)
            if self.corner == "arc" and reach_mm is not None:
                squared = np.minimum(squared, self.draw_mm_s2 * reach_mm / turn_rad)
        speeds: Floats = np.minimum(np.sqrt(np.maximum(squared, 0)), self.draw_mm_s)
        return speeds


def load_machine(name: str) -> Machine:
    """A machine by its name in ``MACHINES``, or from a TOML file of the fields of ``Machine``.

    Raises:
        BadInput: no such machine, or a field that does not exist or is outside its limits.
    """
    if name in MACHINES:
        return settings.read_toml(
            Machine, resources.files("limner.motion").joinpath(f"machines/{name}.toml").read_text()
        )
    if not name.lower().endswith(".toml"):
        raise BadInput(f"machine: no machine {name!r}; choose {', '.join(MACHINES)}, or a file that ends in .toml")
    try:
        return settings.read_toml(Machine, storage.read_bytes(name, 2**20).decode())
    except UnicodeDecodeError as error:
        raise BadInput(f"{name}: not a text in UTF-8 ({error.reason} at byte {error.start})") from error
    except BadInput as error:
        raise BadInput(str(error) if name in str(error) else f"{Path(name).name}: {error}") from error
