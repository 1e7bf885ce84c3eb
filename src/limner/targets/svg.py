"""A drawing goes in; an SVG file with one path per stroke, in drawing order and millimetres, comes out."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from html import escape  # xml.sax.saxutils loads all of HTTP beside it
from typing import Any

import numpy as np
from numpy.typing import NDArray

from limner import bezier
from limner.errors import BadInput
from limner.settings import SettingsGroup, setting
from limner.types import Drawing, Floats, Pen

ABOUT_NAMESPACE = "urn:limner:1"
"""XML namespace of the element in ``<metadata>`` that says how the drawing was made."""

INKSCAPE_NAMESPACE = "http://www.inkscape.org/namespaces/inkscape"
"""XML namespace of what makes a group a layer."""

_FARTHEST_MM = 1e6
_NOT_IN_XML = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


@dataclass(frozen=True)
class SvgSettings(SettingsGroup):
    """How strokes are written to SVG."""

    curves: bool = setting(False, "Bezier curves instead of polylines")
    tolerance_mm: float = setting(0.15, "how far a curve may be from its stroke", unit="mm", low=0.001, high=10)


def to_svg(
    drawing: Drawing,
    about: Mapping[str, Any] | None = None,
    title: str = "Portrait in pen strokes",
    how: SvgSettings | None = None,
) -> bytes:
    """The drawing as an SVG document in UTF-8.

    Lengths are millimetres with three decimals, so that a file that was read comes out again byte for byte. An SVG's y
    goes down and the page frame's up: here and in ``read_svg`` the page is mirrored, nothing else changes. Each of
    several pens has its layer. Repeated points are left out; a dot is a path of no length, which the round caps of the
    line make visible.

    Args:
        drawing: strokes in the page frame.
        about: how it was made (settings, versions): anything JSON can hold, kept in ``<metadata>``.
        title: for screen readers and file managers.
        how: as curves or polylines; polylines if not given.

    Raises:
        BadInput: a point is absurdly far off the page, or ``about`` holds what JSON cannot.
    """
    page = drawing.page
    width, height = _number(page.width_mm), _number(page.height_mm)
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}mm" height="{height}mm"'
        f' viewBox="0 0 {width} {height}" data-margin-mm="{_number(page.margin_mm)}" role="img">',
        f"<title>{_text(title)}</title>",
        f"<desc>Strokes: {len(drawing.lines_mm)}, in the order in which the pen draws them.</desc>",
    ]
    if about is not None:
        lines.append(f"<metadata>{_about(about)}</metadata>")
    parts = drawing.by_pen() or [drawing]
    for number, part in enumerate(parts, 1):
        lines += [_layer(drawing.pens, part, number), *_paths(part, how), "</g>"]
    return "\n".join([*lines, "</svg>", ""]).encode()


def _layer(pens: Sequence[Pen], part: Drawing, number: int) -> str:
    """The opening of the group of a pen's strokes: a layer of Inkscape's, unless all is drawn with one black pen."""
    pen = pens[int(part.layer[0])] if len(part.layer) else pens[0]
    group = f'<g fill="none" stroke="{colour(pen)}" stroke-width="{_number(pen.width_mm)}"'
    group += ' stroke-linecap="round" stroke-linejoin="round"'
    if len(pens) == 1 and pen == Pen(pen.width_mm):
        return f"{group}>"
    layer = f'inkscape:groupmode="layer" inkscape:label="{number}-{pen.name}"'
    return f'{group} id="layer{number}" {layer} xmlns:inkscape="{INKSCAPE_NAMESPACE}">'


def colour(pen: Pen) -> str:
    """The pen's colour as SVG says it."""
    return "black" if pen.rgb == (0, 0, 0) else pen.hex


def _paths(drawing: Drawing, how: SvgSettings | None) -> Iterator[str]:
    height_mm = drawing.page.height_mm
    for line, region, weight in zip(drawing.lines_mm, drawing.region, drawing.weight, strict=True):
        path = _curved(line, height_mm, how.tolerance_mm) if how and how.curves else _path(line, height_mm)
        yield f'<path d="{path}" data-region="{region}" data-weight="{weight:.6g}"/>'


def _path(line: Floats, height_mm: float) -> str:
    microns = _microns(line, height_mm)
    new = np.ones(len(line), bool)
    new[1:] = (np.diff(microns, axis=0) != 0).any(axis=1)
    points = _written(microns[new])
    if len(points) == 1:
        points *= 2
    if len(points) > 2 and points[0] == points[-1]:
        return f"M {points[0]} L {' '.join(points[1:-1])} Z"
    return f"M {points[0]} L {' '.join(points[1:])}"


def _curved(line: Floats, height_mm: float, tolerance_mm: float) -> str:
    """The line as Bezier curves; the straight ones as lines."""
    curves = bezier.fit(line, tolerance_mm)
    parts = [f"M {_written(_microns(curves[0, :1], height_mm))[0]}"]
    for curve, flat in zip(curves, bezier.are_straight(curves), strict=True):
        points = _written(_microns(curve[1:], height_mm))
        parts.append(f"L {points[-1]}" if flat else f"C {' '.join(points)}")
    return " ".join(parts) + (" Z" if len(curves) > 1 and (line[0] == line[-1]).all() else "")


def _microns(line: Floats, height_mm: float) -> NDArray[np.int64]:
    """Thousandths of a millimetre, y down."""
    if np.abs(line).max() > _FARTHEST_MM:
        raise BadInput(f"svg: a point is more than {_FARTHEST_MM / 1000:g} m off the page; place the drawing on it")
    return np.rint(np.stack([line[:, 0], height_mm - line[:, 1]], axis=1) * 1000).astype(np.int64)


def _written(microns: NDArray[np.int64]) -> list[str]:
    return [f"{x / 1000:.10g},{y / 1000:.10g}" for x, y in microns.tolist()]


def _number(value_mm: float) -> str:
    return f"{round(value_mm * 1000) / 1000:.10g}"


def _text(text: str) -> str:
    return escape(_NOT_IN_XML.sub("\ufffd", text), quote=False)


def _about(about: Mapping[str, Any]) -> str:
    try:
        text = json.dumps(about, allow_nan=False, sort_keys=True)
    except (TypeError, ValueError) as error:
        raise BadInput(f"svg: what is told about the drawing cannot be written as JSON ({error})") from error
    return f'<limner:about xmlns:limner="{ABOUT_NAMESPACE}">{escape(text, quote=False)}</limner:about>'
