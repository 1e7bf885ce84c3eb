"""A drawing and a machine go in; an error that says by how much comes out where the drawing does not fit."""

from __future__ import annotations

import dataclasses

import numpy as np

from limner.errors import CannotDraw, NothingToDraw
from limner.motion.machine import Machine
from limner.types import Drawing, Floats, Page

SLACK_MM = 1e-3
"""Less than a machine's step: no reason to refuse."""


def check_area(drawing: Drawing, machine: Machine) -> None:
    """Let a drawing pass that lies on its page and within the work area.

    The page's corner where the pen starts lies in that corner of the work area.

    Raises:
        NothingToDraw: the drawing has no strokes.
        CannotDraw: it leaves the page or the area; by how much, and which scale fits.
    """
    if not drawing.lines_mm:
        raise NothingToDraw("the drawing has no strokes; choose another file, or draw with other settings")
    points = np.concatenate(drawing.lines_mm)
    page = drawing.page
    _check(points, np.array([page.width_mm, page.height_mm]), f"the page of {page.width_mm:g} x {page.height_mm:g} mm")
    area = np.array([machine.width_mm, machine.height_mm])
    if machine.home == "upper-left":
        points = np.column_stack([points[:, 0], page.height_mm - points[:, 1]])
    _check(points, area, f"the work area of {machine.name}, {area[0]:g} x {area[1]:g} mm")


def _check(points: Floats, size: Floats, what: str) -> None:
    low, high = points.min(axis=0), points.max(axis=0)
    under, over = np.maximum(-low, 0), np.maximum(high - size, 0)
    beyond = float(max(under.max(), over.max()))
    if beyond <= SLACK_MM:
        return
    extent = high - low
    raise CannotDraw(
        f"the drawing leaves {what} by {beyond:.4g} mm; it is {extent[0]:.4g} x {extent[1]:.4g} mm"
        f" at ({low[0]:.4g}, {low[1]:.4g}); {_remedy(low, extent, size)}"
    )


def _remedy(low: Floats, extent: Floats, size: Floats) -> str:
    fits = float((size / np.maximum(extent, 1e-9)).min())
    if fits >= 1:
        return "it fits where it is moved onto it"
    whole = np.floor(fits * 1000) / 1000
    return f"scale it by {whole:g} and move it there" if (low != 0).any() else f"scale it by {whole:g}"


def fit(drawing: Drawing, machine: Machine) -> Drawing:
    """The drawing as it fits: as it is, or shrunk to the work area and put into its middle, which is then the page.

    Raises:
        NothingToDraw: the drawing has no strokes.
    """
    try:
        check_area(drawing, machine)
    except NothingToDraw:
        raise
    except CannotDraw:
        return _shrunk(drawing, machine)
    return drawing


def _shrunk(drawing: Drawing, machine: Machine) -> Drawing:
    area = np.array([machine.width_mm, machine.height_mm])
    points = np.concatenate(drawing.lines_mm)
    low, extent = points.min(axis=0), np.ptp(points, axis=0)
    # Room for the width of the pen at the edges.
    room = np.maximum(area - drawing.pen.width_mm, area / 2)
    scale = min(1.0, float((room / np.maximum(extent, 1e-9)).min()))
    lines = tuple((line - low - extent / 2) * scale + area / 2 for line in drawing.lines_mm)
    return dataclasses.replace(drawing, lines_mm=lines, page=Page(machine.width_mm, machine.height_mm, 0.0))
