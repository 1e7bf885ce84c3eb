"""Photos with their detected faces in; the thesis's figures 3.1 to 3.14, drawn from them, out."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from limner.evaluate.line_figures import line_figures
from limner.pipeline import Settings, refine_face
from limner.targets.overlay import overlay
from limner.targets.sheet import Tile, to_sheet
from limner.types import Face, Floats, Photo
from limner.vision.raster import filtered
from limner.vision.refine import RefineSettings, refine
from limner.vision.refine.eye_corners import EYE_CORNERS, SHARPEN, fast_corners
from limner.vision.refine.ground import UNIT_PX, grey_face
from limner.vision.refine.shape import shipped_shape
from limner.vision.scale import ScaleSettings, Working, to_working_scale
from limner.vision.spline_style import FEATURES
from limner.vision.splines import natural_spline

Rgb = NDArray[np.uint8]

INITIAL, CORRECTED, DIRECTION = (230, 60, 50), (40, 170, 70), (250, 200, 40)
INK = (20, 20, 24)

_VIEW = ScaleSettings(outer_eye_px=240.0, beside=1.0, above=0.8, below=1.8)
_EYES = ScaleSettings(outer_eye_px=500.0, beside=0.62, above=0.6, below=0.6)
_EYES_HIGH = 0.3  # shown above and below the eyes, in outer-eye distances
_UNIT = 240.0  # outer-eye distance of faces drawn without a photo [px]
_DEVIATIONS = 3.0  # how far a mode is shown: the thesis does not say
_SHIFT = 4

CORRECTION = "jaw-gradient,brows,jaw-spline"
"""What the thesis calls the corrected landmarks."""


def figures(photos: Sequence[Photo], faces: Sequence[Face], settings: Settings) -> dict[str, Rgb]:
    """Draw every figure but 3.4, which shows another's model.

    Args:
        photos: a few.
        faces: a frontal one in each, as detected.
        settings: of the corrections, the extractors and of trimming.

    Returns:
        (H, W, 3) uint8 RGB by the figure's number, in order.

    Raises:
        BadInput: a profile, or a face that cannot be drawn (see ``to_working_scale``).
    """
    found = list(zip(photos, faces, strict=True))
    refined = [(photo, refine_face(photo, face, settings)) for photo, face in found]
    drawn = line_figures([to_working_scale(*each, settings.scale) for each in refined], settings)
    drawn |= landmark_figures(photos, faces, settings.refinement)
    return dict(sorted(drawn.items(), key=lambda item: int(item[0].partition(".")[2])))


def landmark_figures(photos: Sequence[Photo], faces: Sequence[Face], settings: RefineSettings) -> dict[str, Rgb]:
    """Draw figures 3.5 to 3.11, about landmarks, their corrections and the splines through them."""
    views = [to_working_scale(photo, face, _VIEW) for photo, face in zip(photos, faces, strict=True)]
    several = [(photo, face, settings) for photo, face in zip(photos, faces, strict=True)]
    return {
        "3.5": to_sheet([Tile(overlay(view.photo, [view.face]), "") for view in views]),
        "3.6": to_sheet([tile for view in views for tile in _directions(view, settings)], columns=3),
        "3.7": to_sheet([Tile(_corners(*each), "") for each in several], columns=1, tile_px=700),
        "3.8": to_sheet([tile for view in views for tile in _estimate(view, settings)], columns=2),
        "3.9": modes(),
        "3.10": to_sheet([tile for view in views for tile in _two_curves(view, settings)], columns=2),
        "3.11": _all_curves(views, settings),
    }


def modes() -> Rgb:
    """Figure 3.9: the mean face, and what the first two components add to it and take from it."""
    model = shipped_shape()
    tiles = [Tile(_drawn(model.mean), "mean")]
    for number in (0, 1):
        share = model.variance_kept(number + 1) - (model.variance_kept(number) if number else 0)
        for sign, word in ((1, "+"), (-1, "-")):
            title = f"component {number + 1}, {word}{_DEVIATIONS:g} sigma"
            tiles.append(
                Tile(_drawn(model.mode(number, sign * _DEVIATIONS)), title, f"{100 * share:.0f} % of variance")
            )
    return to_sheet(tiles, columns=len(tiles))


def _drawn(points: Floats) -> Rgb:
    """A face of the shape model's frame in ink on white."""
    image = np.full((round(2.1 * _UNIT), round(2.1 * _UNIT), 3), 255, np.uint8)
    return _with_curves(image, points * _UNIT + np.array(image.shape[:2]) / 2, INK)


def _with_curves(image: Rgb, points: Floats, color: tuple[int, int, int], dots: bool = True) -> Rgb:
    image = image.copy()
    for _, parts in FEATURES:
        for part in parts:
            line = natural_spline(points[part]).line(1.0)
            cv2.polylines(image, [_fixed(line)], False, color, 2, cv2.LINE_AA, _SHIFT)
    return _with_dots(image, points, color) if dots else image


def _with_dots(image: Rgb, points: Floats, color: tuple[int, int, int]) -> Rgb:
    for place in _fixed(points).tolist():
        cv2.circle(image, place, 3 << _SHIFT, color, cv2.FILLED, cv2.LINE_AA, _SHIFT)
    return image


def _fixed(points: Floats) -> NDArray[np.int32]:
    return np.asarray(np.rint(np.clip(points, -(2**15), 2**15) * 2**_SHIFT), np.int32)


def _corrected(view: Working, names: str, settings: RefineSettings) -> Floats:
    return refine(view.photo, view.face, names, settings).points_px


def _directions(view: Working, settings: RefineSettings) -> list[Tile]:
    """Figure 3.6: as found, where better places are looked for, and the places."""
    before, after = view.face.points_px, _corrected(view, "jaw-gradient,brows", settings)
    moved = np.flatnonzero((before != after).any(axis=1))
    middle = view.photo.rgb.copy()
    for start, end in zip(before[moved], after[moved], strict=True):
        tail, tip = _fixed(np.stack([start, end])).tolist()
        cv2.arrowedLine(middle, tail, tip, DIRECTION, 2, cv2.LINE_AA, _SHIFT, 0.25)
    which = np.arange(27)
    return [
        Tile(_with_dots(view.photo.rgb.copy(), before[which], INITIAL), "as found"),
        Tile(_with_dots(middle, before[which], INITIAL), "directions of the search"),
        Tile(_with_dots(view.photo.rgb.copy(), after[which], CORRECTED), "corrected"),
    ]


def _corners(photo: Photo, face: Face, settings: RefineSettings) -> Rgb:
    """Figure 3.7: FAST corners around the eyes; stars where the landmarks were, circles for the corners."""
    grey = grey_face(photo, face)
    view = to_working_scale(photo, face, _EYES)
    scale = _EYES.outer_eye_px / UNIT_PX
    corners = fast_corners(grey.image, settings.eye_corners) - grey.points[EYE_CORNERS[0]]
    corners = corners * scale + view.face.points_px[EYE_CORNERS[0]]
    sharp = np.clip(filtered(_grey(view.photo.rgb), SHARPEN), 0, 255).astype(np.uint8)
    image = np.repeat(sharp[..., None], 3, axis=2)
    for place in _fixed(corners).tolist():
        cv2.circle(image, place, 6 << _SHIFT, CORRECTED, 2, cv2.LINE_AA, _SHIFT)
    for place in np.rint(view.face.points_px[EYE_CORNERS]).astype(int).tolist():
        cv2.drawMarker(image, place, INITIAL, cv2.MARKER_STAR, 16, 2, cv2.LINE_AA)
    level, reach = round(float(view.face.points_px[EYE_CORNERS, 1].mean())), round(_EYES_HIGH * _EYES.outer_eye_px)
    return image[max(level - reach, 0) : max(level + reach, 1)]


def _grey(rgb: Rgb) -> NDArray[np.float32]:
    return np.asarray(cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY), np.float32)


def _estimate(view: Working, settings: RefineSettings) -> list[Tile]:
    """Figure 3.8: a face and its estimate by the shape model."""
    points = _corrected(view, "shape", settings)
    return [
        Tile(_with_dots(view.photo.rgb.copy(), view.face.points_px, INITIAL), "as found"),
        Tile(_with_dots(view.photo.rgb.copy(), points, CORRECTED), "PCA estimate"),
    ]


def _two_curves(view: Working, settings: RefineSettings) -> list[Tile]:
    """Figure 3.10: curves through the landmarks of the shape model, and of the regularised spline."""
    tiles = []
    for names, title in (("shape", "PCA"), (CORRECTION, "regularised spline")):
        points = _corrected(view, names, settings)
        tiles.append(Tile(_with_curves(view.photo.rgb, points, DIRECTION), title))
    return tiles


def _all_curves(views: Sequence[Working], settings: RefineSettings) -> Rgb:
    """Figure 3.11: the photos, and splines through landmarks as found, corrected, of the shape model and of best."""
    rows: list[Any] = [[Tile(view.photo.rgb, "") for view in views]]
    for names, title in (("none", "as found"), (CORRECTION, "corrected"), ("shape", "PCA"), ("best", "best")):
        rows.append(
            [
                Tile(
                    _with_curves(np.full_like(view.photo.rgb, 255), _corrected(view, names, settings), INK, False),
                    title,
                )
                for view in views
            ]
        )
    return to_sheet([tile for row in rows for tile in row], columns=len(views))
