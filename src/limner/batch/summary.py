"""Rows go in, one after the other; counts, rate and the commonest errors come out, and what the contact sheet shows."""

from __future__ import annotations

import time
from collections import Counter
from dataclasses import dataclass, field
from typing import Any

from limner.batch.run import Told

_KINDS = 100
"""Kinds of errors that are told apart; others are counted together."""

_OTHERS = "other errors"


@dataclass
class Summary:
    """What a run did so far.

    Attributes:
        photos: rows.
        drawn: now.
        kept: drawn before, or from a photo of the same content.
        failed: rows with an error.
        strokes, ink_mm: of all drawings, each row counted.
        draw_s, draw_cpu_s: that all the drawing of this run took, the workers added up, and of that a core's time.
        peak_mb: memory of the worker that needed most.
        errors: how often each was met.
        shown: the first rows, for the contact sheet.
        broken: the first rows with errors, for the contact sheet.
        first, last: when the first row came, and the last.
        room: how many rows of either kind are held.
    """

    room: int = 0
    photos: int = 0
    drawn: int = 0
    kept: int = 0
    failed: int = 0
    strokes: int = 0
    ink_mm: float = 0.0
    draw_s: float = 0.0
    draw_cpu_s: float = 0.0
    peak_mb: float = 0.0
    errors: Counter[str] = field(default_factory=Counter)
    shown: list[Told] = field(default_factory=list)
    broken: list[Told] = field(default_factory=list)
    began: float = field(default_factory=time.monotonic)
    first: float | None = None
    last: float = 0.0

    def add(self, told: Told) -> None:
        """Count a row."""
        row = told.row
        self.photos += 1
        self.last = time.monotonic()
        self.first = self.last if self.first is None else self.first
        self.peak_mb = max(self.peak_mb, told.peak_mb)
        if told.how == "failed":
            self.failed += 1
            self._count_error(row.error)
        else:
            self.drawn += told.how == "drawn"
            self.kept += told.how == "kept"
            self.strokes += row.strokes or 0
            self.ink_mm += row.ink_mm or 0.0
            self.draw_s += row.seconds or 0.0 if told.how == "drawn" else 0.0
            self.draw_cpu_s += told.cpu_s if told.how == "drawn" else 0.0
        keep = self.broken if told.how == "failed" else self.shown
        if len(keep) < self.room:
            keep.append(told)

    def _count_error(self, error: str) -> None:
        # What follows names a size or a file; what comes first says what kind of error it is.
        kind = error.partition(";")[0].partition("(")[0].strip()
        self.errors[kind if kind in self.errors or len(self.errors) < _KINDS else _OTHERS] += 1

    def seconds(self) -> float:
        """Since the run began."""
        return time.monotonic() - self.began

    def per_minute(self) -> float:
        """Photos, whatever became of them."""
        return 60 * self.photos / max(self.seconds(), 1e-9)

    def steady_per_minute(self) -> float:
        """Photos from the first row to the last: without what it takes to start."""
        return 60 * (self.photos - 1) / max(self.last - (self.first or 0.0), 1e-9) if self.photos > 1 else 0.0

    def report(self) -> dict[str, Any]:
        """What ``limner batch --json`` prints of it."""
        names = ("photos", "drawn", "kept", "failed", "strokes", "ink_mm", "draw_s", "draw_cpu_s", "peak_mb")
        figures = {name: getattr(self, name) for name in names}
        return figures | {
            "seconds": self.seconds(),
            "per_minute": self.per_minute(),
            "steady_per_minute": self.steady_per_minute(),
            "cpu_s": time.process_time(),
            "errors": dict(self.errors.most_common()),
        }
