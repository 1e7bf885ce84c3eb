"""A photo, a face and settings go in; what most styles begin with comes out, each made when first asked for."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from limner.stages import Stages
from limner.types import Face, Photo, Strokes
from limner.vision.figure import Figure, find_figure
from limner.vision.lines.settings import LineSettings
from limner.vision.portrait import Seen, look_at, portrait_strokes
from limner.vision.raster import Image
from limner.vision.scale import Working, apply, to_working_scale
from limner.vision.tonal.ink import wanted_ink


@dataclass(frozen=True, eq=False)
class Sitter:
    """Who is drawn, and what is seen of the person at the working scale.

    Attributes:
        photo: any size.
        face: a frontal face in it.
        settings: of every stage.
        stages: remembers the stages of earlier drawings.
    """

    photo: Photo
    face: Face
    settings: LineSettings
    stages: Stages

    @cached_property
    def working(self) -> Working:
        """The surroundings of the head at the working scale."""
        return self.stages("scale", to_working_scale, self.photo, self.face, self.settings.scale)

    @cached_property
    def figure(self) -> Figure:
        """What of the surroundings is the person."""
        return self.stages("figure", find_figure, self.working.photo, self.working.face, self.settings.figure)

    @cached_property
    def seen(self) -> Seen:
        """The lines that the surroundings show, and how they run."""
        return self.stages("seen", look_at, self.working.photo, self.settings.portrait.flow)

    @cached_property
    def ink(self) -> Image:
        """How much ink each place of the surroundings is to get."""
        working, figure, seen = self.working, self.figure, self.seen
        return self.stages("ink", wanted_ink, working.photo, working.face, figure, seen, self.settings.ink)

    @cached_property
    def portrait(self) -> Strokes:
        """The strokes of the style ``portrait``, in the pixels of the working scale."""
        face, own, importance = self.working.face, self.settings.portrait, self.settings.regions
        figure, seen = self.figure, self.seen
        return self.stages("portrait", portrait_strokes, seen, face, figure, own, importance)

    def in_photo(self, strokes: Strokes) -> Strokes:
        """Strokes of the working scale in the pixels of the photo."""
        return _moved(strokes, self.working.photo_from_working, self.photo)

    def in_working(self, strokes: Strokes) -> Strokes:
        """Strokes of the photo in the pixels of the working scale."""
        return self.stages("lines", _in_working, strokes, self.working)


def _in_working(strokes: Strokes, working: Working) -> Strokes:
    return _moved(strokes, cv2.invertAffineTransform(working.photo_from_working), working.photo)


def _moved(strokes: Strokes, there_from_here: NDArray[Any], photo: Photo) -> Strokes:
    """Strokes in the pixels of a photo, by an affine map (2, 3)."""
    lines = tuple(apply(np.asarray(there_from_here, np.float64), line) for line in strokes.lines_px)
    return dataclasses.replace(strokes, lines_px=lines, size_px=photo.size_px)
