"""Counts and seconds go in; the words that people say for them come out."""

from __future__ import annotations


def many(count: int, what: str) -> str:
    """So many of it: 1 stroke, 2 strokes."""
    return f"{count} {what}{'' if count == 1 else 's'}"


def clock(seconds: float) -> str:
    """Seconds as one says them: 42 s, 3:05 min, 1:02:03 h."""
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60}:{whole % 60:02d} min"
    return f"{whole // 3600}:{whole // 60 % 60:02d}:{whole % 60:02d} h"
