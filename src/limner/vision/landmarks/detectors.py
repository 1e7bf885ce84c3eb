"""A photo and the name of a detector go in, faces with their landmarks come out, and the one asked for."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from limner.errors import BadInput, NoFace
from limner.settings import SettingsGroup, group, setting
from limner.types import Face, Photo
from limner.vision.landmarks import annotation, mediapipe
from limner.vision.landmarks.fmp import detector as fmp


@dataclass(frozen=True)
class DetectSettings(SettingsGroup):
    """What finds the faces and their landmarks."""

    detector: str = setting(
        "fmp",
        "What finds the landmarks: fmp = flexible mixture of parts, mediapipe = the face mesh of MediaPipe, whose file"
        " you get yourself, file = nothing, they are read from a file",
        choices=("fmp", "mediapipe", "file"),
    )
    file: str = setting("", "For the detector 'file': landmarks as .json (of `limner face`), .pts or .csv")
    fmp: fmp.FmpSettings = group(fmp.FmpSettings)
    mediapipe: mediapipe.MediapipeSettings = group(mediapipe.MediapipeSettings)


class Detector(NamedTuple):
    """A way to find faces.

    Attributes:
        detect: photo and settings -> faces, largest first.
        looked_for: photo and settings -> what it looks for, in words that follow "looked for".
    """

    detect: Callable[[Photo, DetectSettings], tuple[Face, ...]]
    looked_for: Callable[[Photo, DetectSettings], str]


DETECTORS: dict[str, Detector] = {
    "fmp": Detector(
        lambda photo, settings: fmp.detect(photo, settings.fmp),
        lambda photo, settings: fmp.looked_for(photo, settings.fmp),
    ),
    "mediapipe": Detector(
        lambda photo, settings: mediapipe.detect(
            photo, settings.mediapipe, lambda photo: fmp.detect(photo, settings.fmp)
        ),
        lambda photo, settings: mediapipe.looked_for(photo, settings.mediapipe),
    ),
    "file": Detector(
        lambda photo, settings: annotation.read_faces(settings.file),
        lambda photo, settings: f"faces in the file {settings.file}",
    ),
}
"""Every detector by its name, which stands in the faces it finds."""


def detect(photo: Photo, settings: DetectSettings) -> tuple[Face, ...]:
    """All faces in the photo, largest first; none is no error.

    Raises:
        BadInput: the detector's model or file cannot be used.
    """
    return DETECTORS[settings.detector].detect(photo, settings)


def choose(faces: Sequence[Face], number: int, photo: Photo, settings: DetectSettings) -> Face:
    """The face that is to be drawn.

    Args:
        faces: what ``detect`` found in the photo with the settings.
        number: 1 for the largest, 2 for the next...
        photo: where they were looked for.
        settings: how they were looked for.

    Raises:
        NoFace: there are not so many; the message says what was looked for and what helps.
        BadInput: the number is below 1.
    """
    if number < 1:
        raise BadInput(f"face {number}: expected 1 for the largest face, 2 for the next...")
    if not faces:
        looked_for = DETECTORS[settings.detector].looked_for(photo, settings)
        raise NoFace(
            f"no face found; looked for {looked_for};"
            " a crop around the face by hand (--crop x,y,w,h), the photo upright, more light and a look at the camera"
            " help"
        )
    if number > len(faces):
        known = "1 face was" if len(faces) == 1 else f"{len(faces)} faces were"
        raise NoFace(f"no face {number}: {known} found, counted from the largest; choose --face 1 to {len(faces)}")
    return faces[number - 1]
