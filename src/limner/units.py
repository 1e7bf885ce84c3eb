"""Text with units goes in (``12mm``, ``90s``, ``a5:landscape``); millimetres, seconds and pages come out."""

from __future__ import annotations

import math
import re

from limner.errors import BadInput
from limner.types import Page

LENGTHS_MM = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4, "pt": 25.4 / 72}
"""Millimetres in each unit of length."""

TIMES_S = {"s": 1.0, "min": 60.0, "h": 3600.0}
"""Seconds in each unit of time."""

PAGES_MM = {
    "a3": (297.0, 420.0),
    "a4": (210.0, 297.0),
    "a5": (148.0, 210.0),
    "a6": (105.0, 148.0),
    "letter": (215.9, 279.4),
}
"""Width and height of each named page, upright (ISO 216, ANSI A)."""

_LONGEST = 100  # characters: what is longer takes a pattern's time squared

_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d{1,3})?"
_QUANTITY = re.compile(rf"({_NUMBER})\s*([a-z]*)")
_SIDES = re.compile(rf"({_NUMBER}\s*[a-z]*?)\s*[x\u00d7]\s*({_NUMBER})\s*([a-z]*)")


def parse_length_mm(text: str, name: str = "length") -> float:
    """Millimetres from ``12mm``, ``1.5cm``, ``2in`` or a bare number of millimetres.

    Raises:
        BadInput: no number, or a unit that is none of ``LENGTHS_MM``; the message starts with ``name``.
    """
    return _quantity(text, name, LENGTHS_MM, "mm")


def parse_time_s(text: str, name: str = "time") -> float:
    """Seconds from ``90s``, ``5min``, ``1.5h`` or a bare number of seconds.

    Raises:
        BadInput: no number, or a unit that is none of ``TIMES_S``; the message starts with ``name``.
    """
    return _quantity(text, name, TIMES_S, "s")


def parse_minutes(text: str) -> float:
    """Minutes from ``3min``, ``90s``, ``1.5h`` or a bare number of minutes.

    Raises:
        BadInput: no number, or a unit that is none of ``TIMES_S``.
    """
    return _quantity(text, "minutes", {unit: seconds / 60 for unit, seconds in TIMES_S.items()}, "min")


def parse_page(text: str, margin_mm: float = 10.0) -> Page:
    """A page from its name or sides: ``a4``, ``letter``, ``120x160mm``, ``5x7in``, ``a5:landscape``.

    Args:
        text: the page; ``:landscape`` or ``:portrait`` after it turns it so. A unit after the last side
            holds for both, none means millimetres.
        margin_mm: what stays white on each side.

    Raises:
        BadInput: no such page, or sides and margin outside the limits of ``Page``.
    """
    if len(text) > _LONGEST:
        raise BadInput(f"page: {text:.40}... is longer than any page's name; choose {', '.join(PAGES_MM)} or sides")
    what, colon, turn = text.strip().lower().partition(":")
    width_mm, height_mm = PAGES_MM.get(what.strip()) or _sides_mm(what.strip(), text)
    if colon and turn.strip() not in ("portrait", "landscape"):
        raise BadInput(f"page: {text!r} is turned to {turn!r}; choose portrait or landscape")
    if colon:
        width_mm, height_mm = sorted((width_mm, height_mm), reverse=turn.strip() == "landscape")
    return Page(width_mm, height_mm, margin_mm)


def _sides_mm(what: str, text: str) -> tuple[float, float]:
    match = _SIDES.fullmatch(what)
    if match is None:
        raise BadInput(f"page: no page {text!r}; choose {', '.join(PAGES_MM)} or sides such as 120x160mm")
    width, height, unit = match.groups()
    if not width[-1].isalpha():
        width += unit
    return parse_length_mm(width, "page width"), parse_length_mm(height + unit, "page height")


def _quantity(text: str, name: str, units: dict[str, float], bare: str) -> float:
    match = _QUANTITY.fullmatch(text.strip().lower())
    if match is None:
        raise BadInput(f"{name}: expected a number with a unit such as 12{bare}, got {text!r}")
    number, unit = match.groups()
    if (unit or bare) not in units:
        raise BadInput(f"{name}: no unit {unit!r} in {text!r}; choose from {', '.join(units)}, or none for {bare}")
    value = float(number) * units[unit or bare]
    if not math.isfinite(value):
        raise BadInput(f"{name}: {text!r} is too large; expected a finite number")
    return value
