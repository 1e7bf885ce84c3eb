"""Names and values go in, the settings of every stage come out: one tree, from which flags and files derive."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from limner import units
from limner.drawing.clean import CleanSettings
from limner.drawing.compose import ComposeSettings
from limner.drawing.order import OrderSettings
from limner.drawing.select import SelectSettings
from limner.drawing.thread import ThreadSettings
from limner.motion.arm.plan import ArmSettings
from limner.settings import SettingsGroup, group, setting
from limner.simulation.settings import SimulationSettings
from limner.targets.ebb import EbbSettings
from limner.targets.gcode import GcodeSettings
from limner.targets.rosbridge import RosbridgeSettings
from limner.targets.svg import SvgSettings
from limner.targets.urscript import UrSettings
from limner.types import Page, Pen
from limner.vision.landmarks import DetectSettings
from limner.vision.likeness.candidates import AUTO, AUTO_STYLES
from limner.vision.lines import STYLES, LineSettings
from limner.vision.refine import REFINEMENTS, RefineSettings


@dataclass(frozen=True)
class PageSettings(SettingsGroup):
    """The sheet and the pen."""

    size: str = setting("a5", "Paper: a3 to a6, letter, 120x160mm, 5x7in, a5:landscape")
    margin_mm: float = setting(10.0, "White on each side of the sheet", unit="mm", low=0)
    pen_mm: float = setting(0.5, "Width of the pen's line", unit="mm", low=0.01, high=50)

    def page(self) -> Page:
        """The sheet."""
        return units.parse_page(self.size, self.margin_mm)

    def pen(self) -> Pen:
        """What draws, where nothing else is asked for: black, of this width."""
        return Pen(self.pen_mm)


@dataclass(frozen=True)
class Settings(LineSettings):
    """Everything that decides how a portrait looks, stage by stage."""

    style: str = setting(
        "portrait",
        f"From photo to strokes; {AUTO} = the best of {', '.join(AUTO_STYLES)} by likeness",
        choices=(*STYLES, AUTO),
    )
    detect: DetectSettings = group(DetectSettings)
    refine: str = setting(
        AUTO,
        f"Corrections of the landmarks, one after the other, joined by commas: {', '.join(REFINEMENTS)}; or none;"
        " auto = best, and none for landmarks from a file",
    )
    refinement: RefineSettings = group(RefineSettings)
    page: PageSettings = group(PageSettings)
    compose: ComposeSettings = group(ComposeSettings)
    clean: CleanSettings = group(CleanSettings)
    machine: str = setting("axidraw", "What draws, where minutes are given: a machine's name or its TOML file")
    select: SelectSettings = group(SelectSettings)
    thread: ThreadSettings = group(ThreadSettings)
    order: OrderSettings = group(OrderSettings)
    svg: SvgSettings = group(SvgSettings)
    gcode: GcodeSettings = group(GcodeSettings)
    ebb: EbbSettings = group(EbbSettings)
    arm: ArmSettings = group(ArmSettings)
    ur: UrSettings = group(UrSettings)
    rosbridge: RosbridgeSettings = group(RosbridgeSettings)
    simulation: SimulationSettings = group(SimulationSettings)


def changed(settings: Settings, changes: dict[str, Any]) -> Settings:
    """Settings with some changed by name, as ``draw`` takes them."""
    short = {"points": "select.points", "minutes": "select.minutes", "page": "page.size"}
    for name, value in changes.items():
        settings = settings.assign(short.get(name, name.replace("__", ".")), str(value))
    return settings
