"""Drawings of one photo in several styles go in; the one that is most like the person and clean comes out, with why."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from limner import geometry
from limner.types import Face, Floats

AUTO = "auto"
"""The style that stands for the best of some."""

AUTO_STYLES = ("portrait", "gabor", "canny")
"""Those that are tried; among equals the one that comes first, by taste."""

SHORT, SCRAPS_COST, BESIDE_COST = 0.1, 0.15, 0.1
"""Strokes shorter than this [outer-eye distances], 8 mm on a face of 200 mm, are scraps; what a drawing of nothing but
scraps, or of nothing but body and background, loses of its likeness."""

TIE = 0.06
"""A later style must be better by more than this: smaller differences mean little."""


@dataclass(frozen=True)
class Candidate:
    """A drawing that could be kept.

    Attributes:
        style: it was drawn in.
        likeness: 0 to 1.
        scraps: share of its strokes that are short.
        beside: share of its ink on body and background.
    """

    style: str
    likeness: float
    scraps: float
    beside: float

    @property
    def worth(self) -> float:
        """The likeness, less what scraps and clutter cost."""
        return self.likeness - SCRAPS_COST * self.scraps - BESIDE_COST * self.beside


def candidate(style: str, likeness: float, lines_px: Sequence[Floats], region: Sequence[str], face: Face) -> Candidate:
    """Look at a drawing.

    Args:
        style: its name.
        likeness: its score.
        lines_px: its lines in the photo.
        region: of each line.
        face: in the photo.
    """
    lengths = np.array([geometry.length(line) for line in lines_px])
    aside = np.isin(np.array(region, dtype=str), ("body", "background"))
    ink = max(float(lengths.sum()), 1e-9)
    scraps = float((lengths < SHORT * face.outer_eye_px).mean()) if len(lengths) else 0.0
    return Candidate(style, likeness, scraps, float(lengths[aside].sum()) / ink)


def best(candidates: Sequence[Candidate]) -> int:
    """The place of the best; the first among those that are as good."""
    top = max(item.worth for item in candidates)
    return next(i for i, item in enumerate(candidates) if item.worth >= top - TIE)


def why(candidates: Sequence[Candidate]) -> str:
    """One line that says which was kept and why."""
    kept = candidates[best(candidates)]
    others = ", ".join(f"{item.style} {_figures(item)}" for item in candidates if item is not kept)
    if not others:
        return f"kept {kept.style}"
    tied = max(item.worth for item in candidates) > kept.worth
    rule = f"; differences of up to {TIE} mean little, and {kept.style} comes first" if tied else ""
    return f"kept {kept.style}: {_figures(kept)}; against {others}{rule}"


def _figures(item: Candidate) -> str:
    return f"{item.worth:.2f} (likeness {item.likeness:.2f}, {100 * item.scraps:.0f} % scraps)"
