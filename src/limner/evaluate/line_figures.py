"""Photos with their faces in; the thesis's figures about lines, 3.1 to 3.3 and 3.12 to 3.14, drawn from them, out."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from limner.pipeline import Settings
from limner.targets.overlay import overlay
from limner.targets.sheet import Tile, to_sheet
from limner.types import EdgeMap
from limner.vision.edges import CannySettings, canny_edges, gabor_pyramid_edges
from limner.vision.edges.canny import thresholds_of
from limner.vision.edges.gabor_pyramid import at_level, prepared
from limner.vision.raster import Mask, dilated
from limner.vision.scale import Working
from limner.vision.skeleton import skeletonize
from limner.vision.spline_style import spline_strokes
from limner.vision.trim import TrimSettings, head_points, trim

Rgb = NDArray[np.uint8]

INK, FAINT, BOX = (20, 20, 24), (226, 190, 186), (250, 200, 40)

THRESHOLDS = (1.0, 1.75, 2.5, 4.0)
"""Figure 3.2: high thresholds over the automatic one, which the thesis raises by 2.5."""

BLURS = (0.5, 1.0, 2.0)
"""Figure 3.2: blur over the usual one."""


def line_figures(views: Sequence[Working], settings: Settings) -> dict[str, Rgb]:
    """Draw the figures.

    Args:
        views: photos at the working scale with the best landmarks.
        settings: of the extractors and of trimming.

    Returns:
        (H, W, 3) uint8 RGB by the figure's number.
    """
    return {
        "3.1": to_sheet([tile for view in views for tile in _orientations(view, settings)], columns=5, tile_px=360),
        "3.2": to_sheet([tile for view in views for tile in _canny_grid(view, settings.canny)], columns=4, tile_px=360),
        "3.3": to_sheet([tile for view in views for tile in _thinning(view, settings)], columns=3),
        "3.12": to_sheet([tile for view in views for tile in _boxes(view, settings)], columns=2),
        "3.13": to_sheet([tile for view in views for tile in _trimmed(view, settings)], columns=2),
        "3.14": to_sheet([tile for view in views for tile in _process(view, settings)], columns=3),
    }


def ink(mask: Mask, below: Mask | None = None) -> Rgb:
    """A mask (H, W) as ink on white, over a fainter one."""
    picture = np.full((*mask.shape, 3), 255, np.uint8)
    if below is not None:
        picture[below] = FAINT
    picture[mask] = INK
    return picture


def thin(mask: Mask) -> Rgb:
    """A mask thinned to lines, as they are drawn: wide enough to be seen on a sheet."""
    return ink(dilated(skeletonize(mask), 1))


def _orientations(view: Working, settings: Settings) -> list[Tile]:
    """Figure 3.1: what each orientation sees at the original resolution, and their sum; each resolution, and all."""
    bank = settings.gabor_pyramid
    grey = prepared(view.photo, bank)
    seen = at_level(grey, 0, bank.replace(share=0.0))
    tiles = [Tile(view.photo.rgb, "photo")]
    tiles += [Tile(ink(one.thick), f"lines at {np.rad2deg(one.angle_rad):.4g}\N{DEGREE SIGN}") for one in seen]
    tiles.append(Tile(ink(np.any([one.thick for one in seen], axis=0)), f"the sum of the {len(seen)}"))
    for level in reversed(range(bank.levels)):
        lines = at_level(grey, level, bank)
        title = f"1/{bank.step**level:.3g} of the resolution" if level else "original resolution"
        tiles.append(Tile(thin(np.any([one.thin for one in lines], axis=0)), title, f"{len(lines)} orientations"))
    return [*tiles, Tile(thin(_tresset(view, settings).mask), "all resolutions added up")]


def _canny_grid(view: Working, settings: CannySettings) -> list[Tile]:
    """Figure 3.2: thresholds increase from left to right, blur from top to bottom."""
    automatic = thresholds_of(view.photo, view.face, settings.replace(raise_high=1.0, high=None))[1]
    tiles = []
    for blur in BLURS:
        for factor in THRESHOLDS:
            by_hand = settings.replace(
                blur_px=min(20.0, blur * settings.blur_px), high=min(2.0, factor * automatic), low=None
            )
            edges = canny_edges(view.photo, view.face, by_hand)
            title = f"high {by_hand.high:.3f}, blur {by_hand.blur_px:.2g} px"
            tiles.append(Tile(ink(dilated(edges.mask, 1)), title, f"{factor:g} times the automatic threshold"))
    return tiles


def _thinning(view: Working, settings: Settings) -> list[Tile]:
    """Figure 3.3: the original resolution alone, before and after thinning."""
    bank = settings.gabor_pyramid
    seen = at_level(prepared(view.photo, bank), 0, bank)
    thick = np.any([one.thick for one in seen], axis=0)
    return [
        Tile(view.photo.rgb, "photo"),
        Tile(ink(thick), "before thinning"),
        Tile(thin(thick), "after thinning"),
    ]


def _boxes(view: Working, settings: Settings) -> list[Tile]:
    """Figure 3.12: boxes on the landmarks and the head's ellipse, and the edges that they limit."""
    rule = settings.trim.replace(by="boxes")
    edges = _canny(view, settings)
    kept = trim(edges, view.face, rule).mask
    return [
        Tile(_with_boxes(view, rule), "boxes on landmarks and head ellipse", f"{rule.box_px:g} px wide"),
        Tile(ink(dilated(kept, 1), dilated(edges.mask, 1)), "edges that they keep", "the others fainter"),
    ]


def _with_boxes(view: Working, rule: TrimSettings) -> Rgb:
    picture = view.photo.rgb.copy()
    for x, y in head_points(view.face):
        low, high = ((round(x + s * rule.box_px / 2), round(y + s * rule.box_px / 2)) for s in (-1, 1))
        cv2.rectangle(picture, low, high, BOX, 2, cv2.LINE_AA)
    return picture


def _trimmed(view: Working, settings: Settings) -> list[Tile]:
    """Figure 3.13: both extractors, as found and trimmed."""
    return [
        Tile(thin(mask), f"{title} {name} edges")
        for name, edges in _extracted(view, settings)
        for title, mask in (("original", edges.mask), ("trimmed", trim(edges, view.face, settings.trim).mask))
    ]


def _process(view: Working, settings: Settings) -> list[Tile]:
    """Figure 3.14: from the photo through landmarks and edges to what is drawn."""
    lines = spline_strokes(view.photo, view.face, settings.splines, settings.regions).lines_px
    drawn = np.full_like(view.photo.rgb, 255)
    cv2.polylines(drawn, [np.rint(16 * line).astype(np.int32) for line in lines], False, INK, 2, cv2.LINE_AA, 4)
    tiles = [
        Tile(view.photo.rgb, "photo"),
        Tile(overlay(view.photo, [view.face]), "landmarks"),
        Tile(drawn, "splines through them"),
    ]
    for name, edges in _extracted(view, settings):
        by_landmarks = trim(edges, view.face, settings.trim.replace(by="rectangle,distance"))
        by_length = trim(by_landmarks, view.face, settings.trim.replace(by="length"))
        tiles += [
            Tile(ink(dilated(edges.mask, 1)), f"{name} edges"),
            Tile(ink(dilated(by_landmarks.mask, 1)), "trimmed by landmarks"),
            Tile(thin(by_length.mask), "and by length, thinned"),
        ]
    return tiles


def _extracted(view: Working, settings: Settings) -> list[tuple[str, EdgeMap]]:
    return [("Canny", _canny(view, settings)), ("Tresset", _tresset(view, settings))]


def _canny(view: Working, settings: Settings) -> EdgeMap:
    return canny_edges(view.photo, view.face, settings.canny)


def _tresset(view: Working, settings: Settings) -> EdgeMap:
    return gabor_pyramid_edges(view.photo, view.face, settings.gabor_pyramid)
