"""From a photo to a portrait: the settings of every stage, the faces, the session that draws, what it made."""

from limner.pipeline.faces import Part, find_faces, refine_face, refinements
from limner.pipeline.portrait import Portrait
from limner.pipeline.session import Session, draw
from limner.pipeline.settings import PageSettings, Settings, changed
from limner.targets.files import FORMATS, check_format
from limner.vision.lines import PICTURES, without_effect

__all__ = [
    "FORMATS",
    "PICTURES",
    "PageSettings",
    "Part",
    "Portrait",
    "Session",
    "Settings",
    "changed",
    "check_format",
    "draw",
    "find_faces",
    "refine_face",
    "refinements",
    "without_effect",
]
