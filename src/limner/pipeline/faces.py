"""A photo, or a part of it, goes in; its faces come out, their landmarks refined, in the frame of the whole photo."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from limner.pipeline.settings import Settings
from limner.settings import NONE
from limner.types import Face, Floats, Photo, Strokes
from limner.vision.landmarks import DetectSettings, detect
from limner.vision.likeness.candidates import AUTO
from limner.vision.photo import Box, crop_photo
from limner.vision.refine import BEST, refine


@dataclass(frozen=True)
class Part:
    """The part of a photo that is looked at.

    Attributes:
        photo: that part.
        offset_px: (2,) where its upper left pixel is in the whole photo.
    """

    photo: Photo
    offset_px: Floats

    @classmethod
    def of(cls, photo: Photo, crop: Box | None) -> Part:
        """The crop x, y, width, height [px] of a photo; all of it for None."""
        if crop is None:
            return cls(photo, np.zeros(2))
        return cls(crop_photo(photo, crop), np.array(crop[:2], dtype=np.float64))

    def from_whole(self, face: Face, sign: int = -1) -> Face:
        """A face of the whole photo, in the part."""
        by = sign * self.offset_px
        return dataclasses.replace(face, points_px=face.points_px + by, box_px=face.box_px + np.tile(by, 2))

    def to_whole(self, strokes: Strokes, photo: Photo) -> Strokes:
        """Strokes of the part, in the whole photo."""
        lines = tuple(line + self.offset_px for line in strokes.lines_px)
        return dataclasses.replace(strokes, lines_px=lines, size_px=photo.size_px)


def find_faces(photo: Photo, settings: Settings | None = None, *, crop: Box | None = None) -> tuple[Face, ...]:
    """All faces in a photo, largest first; none is no error.

    Args:
        photo: where to look.
        settings: those of ``detect`` are used.
        crop: x, y, width, height [px]: look only there; the faces are in the frame of the photo all the same.

    Raises:
        BadInput: the detector's model or file cannot be used, or the crop leaves the photo.
    """
    return faces_in(photo, (settings or Settings()).detect, crop)


def faces_in(photo: Photo, detection: DetectSettings, crop: Box | None) -> tuple[Face, ...]:
    """All faces in the crop of a photo, or in all of it, largest first, in the frame of the whole photo."""
    part = Part.of(photo, crop)
    faces = detect(part.photo, detection)
    # A file holds faces of the whole photo, whatever part of it is looked at.
    return faces if detection.detector == "file" else tuple(part.from_whole(face, 1) for face in faces)


def refinements(settings: Settings) -> str:
    """The names of the corrections that the settings ask for."""
    if settings.refine != AUTO:
        return settings.refine
    # What stands in a file was placed by hand, or is refined already.
    return NONE if settings.detect.detector == "file" else BEST


def refine_face(photo: Photo, face: Face, settings: Settings | None = None) -> Face:
    """The face with better landmarks.

    Args:
        photo: the whole photo.
        face: found in it.
        settings: those of ``refine`` and ``refinement`` are used.

    Raises:
        BadInput: no such correction, a face of a few pixels, or one outside the photo.
    """
    settings = settings or Settings()
    return refine(photo, face, refinements(settings), settings.refinement)
