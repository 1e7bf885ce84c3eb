"""A photo and a face go in; the strokes of a line portrait come out (thesis 3.1, 3.5, 4.3).

How a style plugs in. Its settings are a group of ``LineSettings`` that bears its name, with _ for -. It is either

- an extractor (in ``edges.EXTRACTORS``): photo at the working scale, face, its settings -> edge map, which is trimmed,
  thinned and traced as everybody's; one whose thresholds are cheap to change is in ``edges.IN_TWO``, too; or
- a way of its own (in ``OWN_WAYS``): a ``Sitter`` -> strokes of the photo, the heaviest first; or
- made to measure (in ``MEASURED``): a way of its own whose group has ``points``, by which the drawing is made for its
  budget instead of being chosen from.

Of the first two what is missing of a feature may then be completed, and the drawing be shaded by hatching.

What costs time goes through ``stages(name, function, *inputs)``, each with no more than the settings it needs: then a
changed setting costs only what follows it.
"""

from limner.vision.lines.draw import draw_lines, without_effect
from limner.vision.lines.pictures import PICTURES, draw_picture
from limner.vision.lines.settings import LineSettings
from limner.vision.lines.sitter import Sitter
from limner.vision.lines.styles import MEASURED, OWN_WAYS, STYLES
from limner.vision.lines.traced import edges_to_strokes

__all__ = [
    "MEASURED",
    "OWN_WAYS",
    "PICTURES",
    "STYLES",
    "LineSettings",
    "Sitter",
    "draw_lines",
    "draw_picture",
    "edges_to_strokes",
    "without_effect",
]
