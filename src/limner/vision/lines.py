"""A photo and a face go in; the strokes of a line portrait come out (thesis 3.1, 3.5, 4.3).

How a style plugs in. Its settings are a group of ``LineSettings`` that bears its name, with _ for -. It is either

- an extractor (in ``edges.EXTRACTORS``): photo at the working scale, face, its settings -> edge map, which is trimmed,
  thinned and traced as everybody's; one whose thresholds are cheap to change is in ``edges.IN_TWO``, too; or
- a way of its own (in ``OWN_WAYS``): photo, face, all ``LineSettings``, stages -> strokes of the photo, the heaviest
  first; or
- made to measure (in ``MEASURED``): a way of its own whose group has ``points``, by which the drawing is made for its
  budget instead of being chosen from.

Of the first two what is missing of a feature may then be completed, and the drawing be shaded by hatching.

What costs time goes through ``stages(name, function, *inputs)``, each with no more than the settings it needs: then a
changed setting costs only what follows it.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, Self

import cv2
import numpy as np
from numpy.typing import NDArray

from limner.errors import BadInput
from limner.settings import NONE, SettingsGroup, group, setting
from limner.stages import Stages
from limner.types import EdgeMap, Face, Photo, Strokes
from limner.vision.cartoon.settings import CartoonSettings
from limner.vision.cartoon.style import abstracted, cartoon_edges, cartoon_strokes, with_features
from limner.vision.completion import CompletionSettings, complete, names_of
from limner.vision.edges import EXTRACTORS, IN_TWO, CannySettings, GaborPyramidSettings, GaborSettings
from limner.vision.figure import FigureSettings, find_figure
from limner.vision.painterly.settings import PainterlySettings
from limner.vision.painterly.style import painted, painterly_strokes
from limner.vision.portrait import PortraitSettings, look_at, portrait_strokes
from limner.vision.raster import Image
from limner.vision.regions import RegionSettings, regions_and_weights
from limner.vision.scale import ScaleSettings, Working, apply, scaled, to_working_scale
from limner.vision.skeleton import skeletonize
from limner.vision.spline_style import SplinesSettings, spline_strokes
from limner.vision.tonal.ink import InkSettings, wanted_ink
from limner.vision.tonal.scribble import ScribbleSettings, scribble
from limner.vision.tonal.stipple import OneLineSettings, StippleSettings, stipple
from limner.vision.tone import ToneSettings, hatch
from limner.vision.trace import TraceSettings, trace
from limner.vision.trim import TrimSettings, trim


@dataclass(frozen=True)
class LineSettings(SettingsGroup):
    """Everything between a photo and its strokes; a style's group bears its name, with _ for -."""

    scale: ScaleSettings = group(ScaleSettings)
    figure: FigureSettings = group(FigureSettings)
    portrait: PortraitSettings = group(PortraitSettings)
    canny: CannySettings = group(CannySettings)
    gabor: GaborSettings = group(GaborSettings)
    gabor_pyramid: GaborPyramidSettings = group(GaborPyramidSettings)
    splines: SplinesSettings = group(SplinesSettings)
    ink: InkSettings = group(InkSettings)
    stipple: StippleSettings = group(StippleSettings)
    one_line: OneLineSettings = group(OneLineSettings)
    cartoon: CartoonSettings = group(CartoonSettings)
    scribble: ScribbleSettings = group(ScribbleSettings)
    painterly: PainterlySettings = group(PainterlySettings)
    trim: TrimSettings = group(TrimSettings)
    trace: TraceSettings = group(TraceSettings)
    regions: RegionSettings = group(RegionSettings)
    complete: str = setting(
        NONE,
        "Features whose missing stretches are drawn through the landmarks, joined by commas: jaw, brow, eye, nose,"
        " mouth; all, or none; nothing in stipple, one-line and scribble",
    )
    completion: CompletionSettings = group(CompletionSettings)
    tone: ToneSettings = group(ToneSettings)

    def __post_init__(self) -> None:
        super().__post_init__()
        names_of(self.complete)

    def of_style(self, style: str) -> Any:
        """The group of a style."""
        return getattr(self, style.replace("-", "_"))

    def with_points(self, style: str, points: int) -> Self:
        """The same with another number of points for a style of ``MEASURED``."""
        return self.replace(**{style.replace("-", "_"): self.of_style(style).replace(points=points)})


def _splines(photo: Photo, face: Face, settings: LineSettings, stages: Stages) -> Strokes:
    return stages("splines", spline_strokes, photo, face, settings.splines, settings.regions)


def _portrait(photo: Photo, face: Face, settings: LineSettings, stages: Stages) -> Strokes:
    working = stages("scale", to_working_scale, photo, face, settings.scale)
    figure = stages("figure", find_figure, working.photo, working.face, settings.figure)
    seen = stages("seen", look_at, working.photo, settings.portrait.flow)
    strokes = stages("portrait", portrait_strokes, seen, working.face, figure, settings.portrait, settings.regions)
    return _in_photo(strokes, working, photo)


def _wanted(photo: Photo, face: Face, settings: LineSettings, stages: Stages) -> tuple[Working, Image]:
    """The surroundings of the head, and how much ink each place of them is to get."""
    working = stages("scale", to_working_scale, photo, face, settings.scale)
    figure = stages("figure", find_figure, working.photo, working.face, settings.figure)
    seen = stages("seen", look_at, working.photo, settings.portrait.flow)
    return working, stages("ink", wanted_ink, working.photo, working.face, figure, seen, settings.ink)


def _dots(style: str, photo: Photo, face: Face, settings: LineSettings, stages: Stages) -> Strokes:
    working, ink = _wanted(photo, face, settings, stages)
    strokes = stages(style, stipple, ink, working.face, settings.of_style(style), settings.regions)
    return _in_photo(strokes, working, photo)


def _cartoon(photo: Photo, face: Face, settings: LineSettings, stages: Stages) -> Strokes:
    working = stages("scale", to_working_scale, photo, face, settings.scale)
    figure = stages("figure", find_figure, working.photo, working.face, settings.figure)
    made = stages("abstracted", abstracted, working.photo, working.face, settings.cartoon)
    edges = stages("edges", cartoon_edges, made, figure, settings.cartoon)
    traced = edges_to_strokes(edges, working.face, settings, stages)
    # The features are drawn by who knows them; what frames them by the picture's own edges.
    look = stages("seen", look_at, working.photo, settings.portrait.flow)
    known = stages("portrait", portrait_strokes, look, working.face, figure, settings.portrait, settings.regions)
    lines = stages("joined", with_features, traced, known)
    seen = (working.photo, working.face, figure)
    strokes = stages("cartoon", cartoon_strokes, made, lines, seen, settings.cartoon, settings.regions)
    return _in_photo(strokes, working, photo)


def _scribble(photo: Photo, face: Face, settings: LineSettings, stages: Stages) -> Strokes:
    working, ink = _wanted(photo, face, settings, stages)
    seen = stages("seen", look_at, working.photo, settings.portrait.flow)
    strokes = stages("scribble", scribble, ink, seen, working.face, settings.scribble, settings.regions)
    return _in_photo(strokes, working, photo)


def _painterly(photo: Photo, face: Face, settings: LineSettings, stages: Stages) -> Strokes:
    working = stages("scale", to_working_scale, photo, face, settings.scale)
    figure = stages("figure", find_figure, working.photo, working.face, settings.figure)
    seen = (working.photo, working.face, figure)
    strokes = stages("painterly", painterly_strokes, *seen, settings.painterly, settings.regions)
    return _in_photo(strokes, working, photo)


def _painting(photo: Photo, face: Face, settings: LineSettings) -> NDArray[np.uint8]:
    # A small face is painted larger, or its eyes would be dabs.
    grow = min(PAINTED_UNIT_PX / face.outer_eye_px, LARGEST_PICTURE_PX / max(photo.size_px))
    if grow > 1:
        photo, face = scaled(photo, face, grow)
    return painted(photo, face, settings.painterly, find_figure(photo, face, settings.figure).figure).canvas


OWN_WAYS: dict[str, Callable[[Photo, Face, LineSettings, Stages], Strokes]] = {
    "cartoon": _cartoon,
    "painterly": _painterly,
    "portrait": _portrait,
    "splines": _splines,
}
"""Styles that are more than an extractor."""

MEASURED: dict[str, Callable[[Photo, Face, LineSettings, Stages], Strokes]] = {
    "stipple": partial(_dots, "stipple"),
    "one-line": partial(_dots, "one-line"),
    "scribble": _scribble,
}
"""Styles made to measure; of ``one-line`` the dots, which are joined on the page."""

PICTURES: dict[str, Callable[[Photo, Face, LineSettings], NDArray[np.uint8]]] = {
    "cartoon": lambda photo, face, settings: abstracted(photo, face, settings.cartoon).rgb(),
    "painterly": _painting,
}
"""Styles that have a picture in colours, too."""

LARGEST_PICTURE_PX = 1600
"""Longer side of such a picture at most."""

PAINTED_UNIT_PX = 160.0
"""Distance of the outer eye corners in a painting at least, where that is not too large."""

STYLES = (*EXTRACTORS, *OWN_WAYS, *MEASURED)
"""Named ways from a photo and a face to strokes."""


def draw_lines(photo: Photo, face: Face, style: str, settings: LineSettings, stages: Stages | None = None) -> Strokes:
    """Strokes of a photo, the heaviest first.

    Args:
        photo: any size.
        face: a frontal face in it.
        style: one of ``STYLES``.
        settings: of every stage.
        stages: what remembers the stages of earlier drawings; not given: all is done anew.

    Returns:
        Strokes in the pixels of the photo; none where nothing is seen.

    Raises:
        BadInput: no such style, a profile, a face of a few pixels, or one outside the photo.
    """
    if style not in STYLES:
        raise BadInput(f"style: '{style}' does not exist; choose from {', '.join(STYLES)}")
    stages = stages or Stages()
    if style in MEASURED:
        return MEASURED[style](photo, face, settings, stages)
    way = OWN_WAYS.get(style, partial(_extracted, style))
    strokes = way(photo, face, settings, stages)
    strokes = stages("complete", complete, strokes, face, settings.complete, settings.completion, settings.regions)
    return strokes if settings.tone.level == NONE else _shaded(strokes, photo, face, settings, stages)


def without_effect(style: str, settings: LineSettings) -> tuple[str, ...]:
    """A line for each setting that was changed and does nothing in a style: dots and streamlines are tone already."""
    if style not in MEASURED:
        return ()
    changed = {"--tone": settings.tone.level != NONE, "--complete": settings.complete != NONE}
    return tuple(f"{name} does nothing in the style '{style}', which is all tone" for name in changed if changed[name])


def draw_picture(photo: Photo, face: Face, style: str, settings: LineSettings) -> NDArray[np.uint8]:
    """The picture in colours (H, W, 3) of a style that has one.

    Args:
        photo: any size; the picture of a large one is smaller, and of a small one may be larger.
        face: in it.
        style: one of ``PICTURES``.
        settings: of the style.

    Raises:
        BadInput: the style has none.
    """
    if style not in PICTURES:
        raise BadInput(f"style: '{style}' has no picture in colours; choose from {', '.join(PICTURES)}")
    scale = min(1.0, LARGEST_PICTURE_PX / max(photo.size_px))
    if scale < 1:
        photo, face = scaled(photo, face, scale)
    return PICTURES[style](photo, face, settings)


def _shaded(strokes: Strokes, photo: Photo, face: Face, settings: LineSettings, stages: Stages) -> Strokes:
    """The strokes and hatching after them."""
    working = stages("scale", to_working_scale, photo, face, settings.scale)
    figure = stages("figure", find_figure, working.photo, working.face, settings.figure)
    seen = stages("lines", _in_working, strokes, working)
    hatching = _in_photo(
        stages("tone", hatch, working.photo, working.face, figure, seen, settings.tone), working, photo
    )
    return Strokes(
        strokes.lines_px + hatching.lines_px,
        strokes.region + hatching.region,
        np.concatenate([strokes.weight, hatching.weight]),
        photo.size_px,
        strokes.pens,
        np.concatenate([strokes.layer, np.zeros(len(hatching.lines_px), np.int64)]),
    )


def _extracted(style: str, photo: Photo, face: Face, settings: LineSettings, stages: Stages) -> Strokes:
    working = stages("scale", to_working_scale, photo, face, settings.scale)
    chosen = settings.of_style(style)
    if style in IN_TWO:
        look, lines_in = IN_TWO[style]
        sight = stages("sight", look, working.photo, working.face, chosen.seeing())
        edges = stages("edges", lines_in, sight, chosen)
    else:
        edges = stages("edges", EXTRACTORS[style], working.photo, working.face, chosen)
    return _in_photo(edges_to_strokes(edges, working.face, settings, stages), working, photo)


def _in_photo(strokes: Strokes, working: Working, photo: Photo) -> Strokes:
    """Strokes of the working scale in the pixels of the photo."""
    lines = tuple(apply(working.photo_from_working, line) for line in strokes.lines_px)
    return dataclasses.replace(strokes, lines_px=lines, size_px=photo.size_px)


def _in_working(strokes: Strokes, working: Working) -> Strokes:
    """Strokes of the photo in the pixels of the working scale."""
    working_from_photo = np.asarray(cv2.invertAffineTransform(working.photo_from_working), np.float64)
    lines = tuple(apply(working_from_photo, line) for line in strokes.lines_px)
    return dataclasses.replace(strokes, lines_px=lines, size_px=working.photo.size_px)


def edges_to_strokes(edges: EdgeMap, face: Face, settings: LineSettings, stages: Stages | None = None) -> Strokes:
    """Trim an edge map, thin it, trace it and say what each line belongs to; the heaviest stroke comes first.

    Args:
        edges: of a photo at the working scale.
        face: in that photo.
        settings: those of trim, trace and regions are used.
        stages: as for ``draw_lines``.

    Returns:
        Strokes in the pixels of the edge map.
    """
    stages = stages or Stages()
    trimmed = stages("trim", trim, edges, face, settings.trim)
    return stages("trace", _traced, trimmed, face, settings.trace, settings.regions)


def _traced(edges: EdgeMap, face: Face, settings: TraceSettings, importance: RegionSettings) -> Strokes:
    lines = trace(skeletonize(edges.mask), settings, edges.mask)
    regions, weights = regions_and_weights(lines, edges, face, importance)
    order = np.argsort(-weights, kind="stable")
    height, width = edges.mask.shape
    return Strokes(tuple(lines[i] for i in order), tuple(regions[i] for i in order), weights[order], (width, height))
