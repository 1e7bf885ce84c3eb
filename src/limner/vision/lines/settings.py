"""What can be chosen between a photo and its strokes: the settings of every stage and style, as one tree."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

from limner.settings import NONE, SettingsGroup, group, setting
from limner.vision.cartoon.settings import CartoonSettings
from limner.vision.completion import CompletionSettings, names_of
from limner.vision.edges import CannySettings, GaborPyramidSettings, GaborSettings
from limner.vision.figure import FigureSettings
from limner.vision.painterly.settings import PainterlySettings
from limner.vision.portrait import PortraitSettings
from limner.vision.regions import RegionSettings
from limner.vision.scale import ScaleSettings
from limner.vision.spline_style import SplinesSettings
from limner.vision.tonal.ink import InkSettings
from limner.vision.tonal.scribble import ScribbleSettings
from limner.vision.tonal.stipple import OneLineSettings, StippleSettings
from limner.vision.tone import ToneSettings
from limner.vision.trace import TraceSettings
from limner.vision.trim import TrimSettings


@dataclass(frozen=True)
class LineSettings(SettingsGroup):
    """Everything between a photo and its strokes; a style's group bears its name, with _ for -."""

    scale: ScaleSettings = group(ScaleSettings)
    figure: FigureSettings = group(FigureSettings)
    portrait: PortraitSettings = group(PortraitSettings)
    canny: CannySettings = group(CannySettings)
    gabor: GaborSettings = group(GaborSettings)
    gabor_pyramid: GaborPyramidSettings = group(GaborPyramidSettings)
    splines: SplinesSettings = group(SplinesSettings)
    ink: InkSettings = group(InkSettings)
    stipple: StippleSettings = group(StippleSettings)
    one_line: OneLineSettings = group(OneLineSettings)
    cartoon: CartoonSettings = group(CartoonSettings)
    scribble: ScribbleSettings = group(ScribbleSettings)
    painterly: PainterlySettings = group(PainterlySettings)
    trim: TrimSettings = group(TrimSettings)
    trace: TraceSettings = group(TraceSettings)
    regions: RegionSettings = group(RegionSettings)
    complete: str = setting(
        NONE,
        "Features whose missing stretches are drawn through the landmarks, joined by commas: jaw, brow, eye, nose,"
        " mouth; all, or none; nothing in stipple, one-line and scribble",
    )
    completion: CompletionSettings = group(CompletionSettings)
    tone: ToneSettings = group(ToneSettings)

    def __post_init__(self) -> None:
        super().__post_init__()
        names_of(self.complete)

    def of_style(self, style: str) -> Any:
        """The group of a style."""
        return getattr(self, style.replace("-", "_"))

    def with_points(self, style: str, points: int) -> Self:
        """The same with another number of points for a style of ``MEASURED``."""
        return self.replace(**{style.replace("-", "_"): self.of_style(style).replace(points=points)})
