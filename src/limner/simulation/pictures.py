"""A simulated drawing goes in; pictures of its ink, of ink over plan and of the force over time come out."""

from __future__ import annotations

import itertools
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from limner import geometry
from limner.simulation.ink import widths
from limner.simulation.outcome import Simulation
from limner.types import Floats, Pen

Picture = NDArray[np.uint8]

PX_PER_MM = 8.0

_FINE = 3
_SHIFT = 6
_STEP_MM = 0.02
_LEVEL_MM = 0.05
_PLAN, _INK, _TRAIL = (70, 130, 220), (25, 25, 25), (220, 40, 30)
"""Colours: of the plan, of ink where it should be, of ink in travel."""


def ink_svg(made: Simulation, pen: Pen) -> bytes:
    """The ink as SVG in millimetres: a path for each part of a line of one width, in steps of a twentieth of a mm."""
    groups: dict[float, list[Floats]] = {}
    for line, force in made.ink.lines():
        for width, part in _even_parts(line, widths(force, pen.width_mm)):
            groups.setdefault(width, []).append(part)
    page = made.paper.page
    head = (
        '<?xml version="1.0" encoding="UTF-8"?>\n<svg xmlns="http://www.w3.org/2000/svg"'
        f' width="{page.width_mm:.3f}mm" height="{page.height_mm:.3f}mm"'
        f' viewBox="0 0 {page.width_mm:.3f} {page.height_mm:.3f}">\n<title>Ink of a simulated arm</title>\n'
    )
    body = [_group(width, lines, page.height_mm) for width, lines in sorted(groups.items())]
    return "".join([head, *body, "</svg>\n"]).encode()


def _group(width: float, lines: list[Floats], height_mm: float) -> str:
    paths = []
    for line in lines:
        points = " ".join(f"{x:.2f},{height_mm - y:.2f}" for x, y in line.tolist())
        paths.append(f'<path d="M {points}"/>')
    opening = (
        f'<g fill="none" stroke="black" stroke-width="{width:.2f}" stroke-linecap="round" stroke-linejoin="round">'
    )
    return "\n".join([opening, *paths, "</g>", ""])


def _even_parts(line: Floats, width: Floats) -> list[tuple[float, Floats]]:
    level = np.maximum(1, np.rint(width / _LEVEL_MM)).astype(int)
    ends = np.r_[0, np.flatnonzero(np.diff(level)) + 1, len(line)]
    parts = []
    for a, b in itertools.pairwise(ends):
        # The first place of the next part is the last of this one, so that no gap shows.
        part = geometry.simplify(line[a : b + 1], _STEP_MM)
        parts.append((float(level[a] * _LEVEL_MM), part if len(part) > 1 else np.repeat(part, 2, axis=0)))
    return parts


def ink_picture(made: Simulation, pen: Pen, px_per_mm: float = PX_PER_MM) -> Picture:
    """The ink on its sheet (H, W, 3), black on white."""
    canvas = _canvas(made, px_per_mm)
    for line, force in made.ink.lines():
        _draw(canvas, line, widths(force, pen.width_mm), _INK, made, px_per_mm)
    return _smaller(canvas)


def overlay_picture(made: Simulation, pen: Pen, px_per_mm: float = PX_PER_MM) -> Picture:
    """The ink, where it was drawn in travel red, and the plan over it as a thin blue line (H, W, 3)."""
    canvas = _canvas(made, px_per_mm)
    for line, force in made.ink.lines():
        _draw(canvas, line, widths(force, pen.width_mm), (170, 170, 170), made, px_per_mm)
    trail = made.trail()
    for k in np.flatnonzero(trail):
        _draw(canvas, made.ink.place_mm[max(0, k - 1) : k + 1], np.full(2, pen.width_mm), _TRAIL, made, px_per_mm)
    for line in made.plan_mm.values():
        _draw(canvas, line, np.full(len(line), pen.width_mm / 4), _PLAN, made, px_per_mm)
    return _smaller(canvas)


def _canvas(made: Simulation, px_per_mm: float) -> Picture:
    page = made.paper.page
    shape = [max(1, round(side * px_per_mm)) * _FINE for side in (page.height_mm, page.width_mm)]
    return np.full((*shape, 3), 255, np.uint8)


def _draw(
    canvas: Picture, line: Floats, width_mm: Floats, colour: tuple[int, int, int], made: Simulation, px_per_mm: float
) -> None:
    """A line (n, 2) [mm] with a width (n,) at each place."""
    scale = px_per_mm * _FINE
    place = np.stack([line[:, 0], made.paper.page.height_mm - line[:, 1]], axis=1) * scale - 0.5
    fixed: NDArray[np.int32] = np.rint(np.clip(place, -1e5, 1e5) * 2**_SHIFT).astype(np.int32)
    thick = np.maximum(1, np.rint(width_mm * scale)).astype(int).tolist()
    for a, b, width in zip(fixed[:-1].tolist(), fixed[1:].tolist(), thick[1:], strict=True):
        cv2.line(canvas, a, b, colour, width, cv2.LINE_8, _SHIFT)
    if len(line) == 1:
        cv2.circle(canvas, fixed[0].tolist(), (thick[0] << _SHIFT) // 2, colour, cv2.FILLED, cv2.LINE_8, _SHIFT)


def _smaller(canvas: Picture) -> Picture:
    height, width = canvas.shape[:2]
    small: Picture = cv2.resize(canvas, (width // _FINE, height // _FINE), interpolation=cv2.INTER_AREA).astype(
        np.uint8
    )
    return small


def force_picture(made: Simulation, size: tuple[int, int] = (1200, 360)) -> Picture:
    """Force over time as a plot (H, W, 3): pen meant to be down shaded, the force as a line."""
    width, height = size
    left, right, top, bottom = 60, 15, 30, 40
    image = Image.new("RGB", size, "white")
    draw = ImageDraw.Draw(image)
    times, force = made.ink.t_s, made.ink.force_n
    high = max(2.0, float(np.ceil(force.max(initial=0) * 2) / 2))
    x = left + (width - left - right) * times / times[-1]
    y = height - bottom - (height - top - bottom) * force / high
    for a, b in _spans(made.ink.down):
        draw.rectangle([x[a], top, x[b - 1], height - bottom], fill=(228, 238, 250))
    for value in ticks(high, 5):
        at = height - bottom - (height - top - bottom) * value / high
        draw.line([(left, at), (width - right, at)], fill=(205, 205, 205))
        draw.text((left - 8, at), f"{value:g}", fill=(60, 60, 60), font=_font(14), anchor="rm")
    for t in ticks(float(times[-1]), 10):
        at = left + (width - left - right) * t / times[-1]
        draw.text((at, height - bottom + 8), f"{t:g}", fill=(60, 60, 60), font=_font(14), anchor="mt")
    draw.line(list(zip(x.tolist(), y.tolist(), strict=True)), fill=(190, 60, 30), width=1)
    draw.text((left, 8), "force of the pen on the paper [N]; shaded: meant to be down", fill=0, font=_font(15))
    draw.text((width - right, height - 4), "time [s]", fill=(60, 60, 60), font=_font(14), anchor="rb")
    return np.asarray(image)


def ticks(high: float, most: int) -> list[float]:
    """Round numbers from 0 to at most ``high``: ``most`` above 0 or fewer, in steps of 1, 2 or 5."""
    power = 10.0 ** np.floor(np.log10(high / most))
    step = next(factor * power for factor in (1, 2, 5, 10) if high <= most * factor * power * (1 + 1e-9))
    return [float(f"{step * k:.6g}") for k in range(int(high / step + 1e-9) + 1)]


def _font(size: int) -> Any:
    return ImageFont.load_default(size)


def _spans(mask: NDArray[np.bool_]) -> list[tuple[int, int]]:
    edges = np.flatnonzero(np.diff(np.r_[False, mask, False].astype(np.int8)))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]
