"""A drawing and the pen's motion in time go in; an SVG that draws itself, stroke by stroke in that time, comes out."""

from __future__ import annotations

import numpy as np

from limner import geometry
from limner.errors import BadInput
from limner.targets.svg import colour
from limner.types import Drawing, Floats, PenPath

HOLD_PART = 0.12
"""Part of each round during which the finished drawing stays."""

MAX_SECONDS = 120.0
"""No film is longer."""


def check_length(seconds: float) -> None:
    """Let the length of a film pass.

    Raises:
        BadInput: it is none, or more than ``MAX_SECONDS``.
    """
    if not 0 < seconds <= MAX_SECONDS:
        raise BadInput(f"movie: {seconds:g} s long; expected more than 0 and at most {MAX_SECONDS:g} s")


def to_animated_svg(drawing: Drawing, path: PenPath, seconds: float) -> bytes:
    """An SVG of one path per stroke, each of which grows (SMIL) while the pen draws it; it begins anew for ever.

    Where nothing moves, as on paper or in an editor, it is the finished drawing.

    Args:
        drawing: what is drawn.
        path: when, as planned; its times are scaled to the film.
        seconds: length of a round, without the hold at its end.

    Raises:
        BadInput: as ``check_length``.
    """
    check_length(seconds)
    page = drawing.page
    rounds_s = seconds / (1 - HOLD_PART)
    begin, end = stroke_times(path, len(drawing.lines_mm))
    scale = seconds / max(float(path.t_s[-1]), 1e-9) / rounds_s
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{page.width_mm:g}mm" height="{page.height_mm:g}mm"'
        f' viewBox="0 0 {page.width_mm:g} {page.height_mm:g}">',
        '<rect width="100%" height="100%" fill="white"/>',
    ]
    moments = zip(begin * scale, end * scale, strict=True)
    for part in drawing.by_pen():
        pen = drawing.pens[int(part.layer[0])]
        lines.append(
            f'<g fill="none" stroke="{colour(pen)}" stroke-width="{pen.width_mm:g}" stroke-linecap="round"'
            ' stroke-linejoin="round">'
        )
        for line, (first, last) in zip(part.lines_mm, moments, strict=False):
            lines.append(_growing(line, page.height_mm, float(first), float(last), rounds_s))
        lines.append("</g>")
    return "\n".join([*lines, "</svg>", ""]).encode()


def stroke_times(path: PenPath, strokes: int) -> tuple[Floats, Floats]:
    """When the pen begins and ends each stroke [s]: two of (strokes,)."""
    inked = np.flatnonzero(path.stroke >= 0)
    begin, end = np.full(strokes, np.inf), np.zeros(strokes)
    np.minimum.at(begin, path.stroke[inked], path.t_s[np.maximum(inked - 1, 0)])
    np.maximum.at(end, path.stroke[inked], path.t_s[inked])
    return begin, end


def _growing(line: Floats, height_mm: float, first: float, last: float, rounds_s: float) -> str:
    """A path that is drawn from ``first`` to ``last``, parts of a round."""
    points = np.stack([line[:, 0], height_mm - line[:, 1]], axis=1)
    points = points if len(points) > 1 else np.repeat(points, 2, axis=0)
    data = "M " + " L ".join(f"{x:.6g},{y:.6g}" for x, y in np.round(points, 3).tolist())
    first, last = min(max(first, 1e-6), 1 - 3e-6), min(max(last, first + 1e-6), 1 - 1e-6)
    repeat = f'dur="{rounds_s:.6g}s" repeatCount="indefinite"'
    shows = (
        f'<animate attributeName="visibility" values="hidden;visible" keyTimes="0;{first:.6f}" calcMode="discrete"'
        f" {repeat}/>"
    )
    if geometry.length(line) == 0:
        return f'<path d="{data}">{shows}</path>'
    grows = (
        f'<animate attributeName="stroke-dashoffset" values="1;1;0;0" keyTimes="0;{first:.6f};{last:.6f};1" {repeat}/>'
    )
    return f'<path d="{data}" pathLength="1" stroke-dasharray="1 2">{shows}{grows}</path>'
