"""What decides how the style `portrait` looks."""

from __future__ import annotations

from dataclasses import dataclass

from limner.settings import SettingsGroup, group, setting
from limner.vision.portrait.seen import FlowSettings


@dataclass(frozen=True)
class PortraitSettings(SettingsGroup):
    """A portrait in few long strokes; lengths are in outer-eye distances."""

    flow: FlowSettings = group(FlowSettings)
    detail: float = setting(1.0, "lines this many times fainter than usual are drawn too", low=0.1, high=10)
    hair_apart: float = setting(
        0.042, "strands of hair keep this distance", unit="outer-eye distances", low=0.01, high=1
    )
    dark_apart: float = setting(
        0.075, "strokes in dark hair keep this distance; 0 leaves it empty", unit="outer-eye distances",
        low=0, high=1,
    )  # fmt: skip
    brow_strokes: int = setting(5, "a thick brow has at most this many strokes", low=1, high=12)
    body: float = setting(
        0.75, "how far below the chin neck and shoulders are drawn", unit="outer-eye distances", low=0, high=6
    )
