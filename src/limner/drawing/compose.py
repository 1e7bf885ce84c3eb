"""Strokes in a photo and a page go in; the drawing on that page comes out, in millimetres."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from limner.errors import BadInput, CannotDraw, NothingToDraw
from limner.settings import SettingsGroup, setting
from limner.types import Drawing, Floats, Page, Pen, Strokes

_FARTHEST_PX = 1e7
_LEAST_CONTENT = 1 / 50
_LEAST_GROWTH = 1.02
_MOST_GROWTH = 2.0


@dataclass(frozen=True)
class ComposeSettings(SettingsGroup):
    """How the strokes are placed on the page."""

    fit: str = setting(
        "content",
        "what fills the page within its margins: the strokes that are drawn or the whole photo",
        choices=("content", "photo"),
    )
    max_width_mm: float | None = setting(
        None,
        "the drawing is made no wider than this; not set: as wide as the margins allow",
        unit="mm",
        low=1,
        high=10_000,
    )


def compose(strokes: Strokes, page: Page, settings: ComposeSettings, pen: Pen | None = None) -> Drawing:
    """Place the strokes of a photo on a page, centred within its margins, as large as they allow.

    The only place where pixels become millimetres and y turns upward. The ink, pen width included, stays off the
    margins.

    Args:
        strokes: polylines [px], photo frame.
        page: paper size and margins [mm].
        settings: what is fitted to the page.
        pen: whose width all pens have; 0.5 mm if not given.

    Returns:
        Drawing in the page frame [mm], origin at the lower left, with each pen's strokes in the order given.

    Raises:
        NothingToDraw: there is no stroke.
        CannotDraw: margins and pen width leave nothing of the page.
        BadInput: a point is absurdly far away.
    """
    if not strokes.lines_px:
        raise NothingToDraw(
            "no stroke is left to draw; use a clearer photo, a larger budget, or a style and settings that keep more"
        )
    pen = pen or Pen()
    affine = page_from_photo(strokes, page, settings, pen)
    up = np.array([[affine[0, 0], 0, affine[0, 2]], [0, -affine[1, 1], page.height_mm - affine[1, 2]]])
    lines = [line @ up[:, :2].T + up[:, 2] for line in strokes.lines_px]
    by_pen = np.argsort(strokes.layer, kind="stable").tolist()
    return Drawing(
        tuple(lines[i] for i in by_pen),
        tuple(strokes.region[i] for i in by_pen),
        strokes.weight[by_pen],
        page,
        tuple(dataclasses.replace(colour, width_mm=pen.width_mm) for colour in strokes.pens),
        strokes.layer[by_pen],
    )


def page_from_photo(strokes: Strokes, page: Page, settings: ComposeSettings, pen: Pen | None = None) -> Floats:
    """The map from photo pixels to millimetres on the page as they stand in its SVG: origin upper left, y down.

    Args, Raises: as ``compose``, which uses it.

    Returns:
        (2, 3) affine map; the same scale in x and y, no turn.
    """
    low, high = _content(strokes) if settings.fit == "content" and strokes.lines_px else _frame(strokes)
    scale = float((_room(page, pen or Pen(), settings) / (high - low)).min())
    offset = np.array([page.width_mm, page.height_mm]) / 2 - scale * (low + high) / 2
    return np.array([[scale, 0, offset[0]], [0, scale, offset[1]]])


def fill_page(drawing: Drawing, settings: ComposeSettings) -> tuple[Drawing, Floats]:
    """Enlarge what was chosen of a drawing until it fills the page again, as ``compose`` made all of it do.

    Args:
        drawing: in the page frame [mm].
        settings: as composed; with ``fit`` other than content nothing changes.

    Returns:
        The drawing, and the (2, 3) map of the page frame that was applied: at most ``_MOST_GROWTH`` times as large,
        or left alone where less than ``_LEAST_GROWTH`` is gained.
    """
    page, still = drawing.page, np.eye(2, 3)
    if settings.fit != "content" or not drawing.lines_mm:
        return drawing, still
    points = np.concatenate(drawing.lines_mm)
    low, high = points.min(axis=0), points.max(axis=0)
    scale = float((_room(page, drawing.pen, settings) / np.maximum(high - low, 1e-9)).min())
    if scale < _LEAST_GROWTH:
        return drawing, still
    scale = min(scale, _MOST_GROWTH)
    offset = np.array([page.width_mm, page.height_mm]) / 2 - scale * (low + high) / 2
    lines = tuple(line * scale + offset for line in drawing.lines_mm)
    return dataclasses.replace(drawing, lines_mm=lines), np.array([[scale, 0, offset[0]], [0, scale, offset[1]]])


def grown(affine: Floats, growth: Floats, page: Page) -> Floats:
    """A map to the page as it stands in its SVG (y down), followed by one of the page frame (y up), both (2, 3)."""
    scale, (x, y) = growth[0, 0], growth[:, 2]
    moved: Floats = affine * scale
    moved[:, 2] += [x, page.height_mm * (1 - scale) - y]
    return moved


def _room(page: Page, pen: Pen, settings: ComposeSettings) -> Floats:
    """Width and height that the lines' middles may take."""
    inset = page.margin_mm + pen.width_mm / 2
    room = np.array([page.width_mm, page.height_mm]) - 2 * inset
    if room.min() <= 0:
        raise CannotDraw(
            f"page: {page.width_mm:g} x {page.height_mm:g} mm less margins of {page.margin_mm:g} mm and the pen's width"
            " leaves no room; choose a larger page or smaller margins"
        )
    room[0] = min(room[0], settings.max_width_mm or np.inf)
    return room


def _frame(strokes: Strokes) -> tuple[Floats, Floats]:
    """Corners of the photo; its pixels' centres are on whole numbers."""
    return np.array([-0.5, -0.5]), np.maximum(strokes.size_px, 1) - 0.5


def _content(strokes: Strokes) -> tuple[Floats, Floats]:
    """Corners of the strokes' bounding box, grown where it is so small that fitting it would magnify a speck."""
    points = np.concatenate(strokes.lines_px)
    low, high = points.min(axis=0), points.max(axis=0)
    if max(-low.min(), high.max()) > _FARTHEST_PX:
        raise BadInput(f"strokes: a point is more than {_FARTHEST_PX:g} px away from the photo's corner")
    least = max(*strokes.size_px, 1) * _LEAST_CONTENT
    grow = np.maximum(least - (high - low), 0) / 2
    return low - grow, high + grow
