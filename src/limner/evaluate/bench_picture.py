"""Bars in panels go in; one picture of them, as SVG, comes out."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from xml.sax.saxutils import escape

_WIDTH, _LEFT, _RIGHT = 860, 190, 110
_BAR, _STEP, _HEAD, _GAP, _KEY = 22, 34, 44, 26, 24
_COLOURS = (
    "#2f4858",
    "#c2452d",
    "#e0a458",
    "#7d9d9c",
    "#576490",
    "#a26769",
    "#8a8f5c",
    "#b8a9c9",
    "#4f7c5a",
    "#d98880",
)


@dataclass(frozen=True)
class Bar:
    """One bar: its name, the parts it is made of and their unit."""

    name: str
    parts: Sequence[tuple[str, float]]
    unit: str

    @property
    def value(self) -> float:
        """Of all parts."""
        return sum(value for _, value in self.parts)


@dataclass(frozen=True)
class Panel:
    """Bars of one scale under a title."""

    title: str
    bars: Sequence[Bar]

    def names(self) -> list[str]:
        """Of the parts, in order; none where bars are of one piece."""
        fullest = sorted(self.bars, key=lambda bar: -len(bar.parts))
        return [name for name in dict.fromkeys(name for bar in fullest for name, _ in bar.parts) if name]

    def height(self) -> int:
        """In the picture [px]."""
        return _HEAD + _STEP * len(self.bars) + (_KEY if self.names() else 0) + _GAP


def to_svg(panels: Sequence[Panel]) -> str:
    """The panels below each other."""
    height = _GAP + sum(panel.height() for panel in panels)
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDTH} {height}" font-family="sans-serif"'
        ' font-size="13" fill="#2b2d33">',
        f'<rect width="{_WIDTH}" height="{height}" fill="#fffefb"/>',
    ]
    top = _GAP
    for panel in panels:
        lines += _panel(panel, top)
        top += panel.height()
    return "\n".join([*lines, "</svg>", ""])


def _panel(panel: Panel, top: int) -> Iterator[str]:
    colours = {name: _COLOURS[k % len(_COLOURS)] for k, name in enumerate(panel.names())}
    most = max((bar.value for bar in panel.bars), default=1.0) or 1.0
    per_unit = (_WIDTH - _LEFT - _RIGHT) / most
    title = 'font-family="Georgia, serif" font-style="italic" font-size="18"'
    yield f'<text x="24" y="{top + 14}" {title}>{escape(panel.title)}</text>'
    for k, bar in enumerate(panel.bars):
        y, x = top + _HEAD + k * _STEP, float(_LEFT)
        yield f'<text x="{_LEFT - 12}" y="{y + 15}" text-anchor="end">{escape(bar.name)}</text>'
        for name, value in bar.parts:
            colour = colours.get(name, _COLOURS[0])
            yield f'<rect x="{x:.1f}" y="{y}" width="{value * per_unit:.1f}" height="{_BAR}" fill="{colour}"/>'
            x += value * per_unit
        yield f'<text x="{x + 9:.1f}" y="{y + 15}" fill="#6b6862">{bar.value:,.0f} {escape(bar.unit)}</text>'
    yield from _key(colours, top + _HEAD + _STEP * len(panel.bars))


def _key(colours: dict[str, str], y: int) -> Iterator[str]:
    x = _LEFT
    for name, colour in colours.items():
        yield f'<rect x="{x}" y="{y}" width="11" height="11" fill="{colour}"/>'
        yield f'<text x="{x + 16}" y="{y + 10}" font-size="12">{escape(name)}</text>'
        x += 34 + 7 * len(name)
