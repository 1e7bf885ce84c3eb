"""The style `portrait`: a photo and its face go in, few long strokes come out."""

from __future__ import annotations

from limner.vision.portrait.seen import FlowSettings, Seen, look_at
from limner.vision.portrait.settings import PortraitSettings
from limner.vision.portrait.style import portrait_strokes

__all__ = ["FlowSettings", "PortraitSettings", "Seen", "look_at", "portrait_strokes"]
