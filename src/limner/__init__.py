"""limner: from a photo of a face to a portrait in pen strokes.

>>> import limner
>>> limner.draw("me.jpg", points=600).save("me.svg")  # doctest: +SKIP
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

_HOME = {}
