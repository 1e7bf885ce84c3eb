"""The types that the stages hand on, from the photo to the joints; all frozen, arrays read-only, shapes checked once.

Frames: *photo* is pixels, x right, y down, (0, 0) the centre of the top-left pixel;
*page* is millimetres, origin at the lower left, y up; *paper* is the page with z up from the sheet.
"""

from limner.types.drawing import Drawing
from limner.types.edges import EdgeMap
from limner.types.face import LANDMARK_COUNTS, Face
from limner.types.lines import REGIONS
from limner.types.page import Page, Pen
from limner.types.photo import Photo
from limner.types.strokes import Strokes
from limner.types.trajectory import JointTrajectory, PenPath
from limner.types.values import Floats, Value, frozen_array, same

__all__ = [
    "LANDMARK_COUNTS",
    "REGIONS",
    "Drawing",
    "EdgeMap",
    "Face",
    "Floats",
    "JointTrajectory",
    "Page",
    "Pen",
    "PenPath",
    "Photo",
    "Strokes",
    "Value",
    "frozen_array",
    "same",
]
