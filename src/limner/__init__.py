"""limner: from a photo of a face to a portrait in pen strokes.

    import limner

    limner.draw("me.jpg", points=600).save("me.svg")

Each stage by itself, one type per arrow::

    photo = limner.load_photo("me.jpg")
    face = limner.find_faces(photo)[0]
    strokes = limner.draw_lines(photo, face, "gabor", limner.Settings())
    drawing = limner.compose(strokes, limner.Page(), limner.Settings().compose)

Names are loaded when they are first used, so that ``import limner`` is quick.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from limner.drawing.clean import clean as clean
    from limner.drawing.compose import compose as compose, page_from_photo as page_from_photo
    from limner.drawing.measure import measure as measure
    from limner.drawing.order import order as order
    from limner.drawing.select import select as select
    from limner.errors import (
        BadInput as BadInput,
        CannotDraw as CannotDraw,
        DeviceFailed as DeviceFailed,
        LimnerError as LimnerError,
        MissingExtra as MissingExtra,
        NoFace as NoFace,
        NothingToDraw as NothingToDraw,
    )
    from limner.motion.cost import Costs as Costs, costs as costs
    from limner.motion.machine import Machine as Machine, load_machine as load_machine
    from limner.motion.pen import plan as plan
    from limner.pipeline import (
        Portrait as Portrait,
        Session as Session,
        Settings as Settings,
        draw as draw,
        find_faces as find_faces,
        refine_face as refine_face,
    )
    from limner.settings import read_toml as read_toml, write_toml as write_toml
    from limner.storage import load as load, save as save
    from limner.targets.files import read_drawing as read_drawing
    from limner.targets.gcode import GcodeSettings as GcodeSettings, to_gcode as to_gcode
    from limner.targets.gcode_read import read_gcode as read_gcode
    from limner.targets.hpgl import to_hpgl as to_hpgl
    from limner.targets.hpgl_read import read_hpgl as read_hpgl
    from limner.targets.image import to_png as to_png, to_rgb as to_rgb
    from limner.targets.svg import to_svg as to_svg
    from limner.targets.svg_read import read_svg as read_svg
    from limner.types import (
        Drawing as Drawing,
        EdgeMap as EdgeMap,
        Face as Face,
        JointTrajectory as JointTrajectory,
        Page as Page,
        Pen as Pen,
        PenPath as PenPath,
        Photo as Photo,
        Strokes as Strokes,
    )
    from limner.units import parse_length_mm as parse_length_mm, parse_page as parse_page, parse_time_s as parse_time_s
    from limner.vision.completion import complete as complete
    from limner.vision.edges import (
        canny_edges as canny_edges,
        gabor_edges as gabor_edges,
        gabor_pyramid_edges as gabor_pyramid_edges,
    )
    from limner.vision.lines import (
        PICTURES as PICTURES,
        STYLES as STYLES,
        draw_lines as draw_lines,
        draw_picture as draw_picture,
        edges_to_strokes as edges_to_strokes,
    )
    from limner.vision.photo import crop_photo as crop_photo, load_photo as load_photo
    from limner.vision.scale import to_working_scale as to_working_scale
    from limner.vision.skeleton import skeletonize as skeletonize
    from limner.vision.trace import trace as trace
    from limner.vision.trim import trim as trim

_HOMES = {
    "limner.drawing.clean": "clean",
    "limner.drawing.compose": "compose page_from_photo",
    "limner.drawing.measure": "measure",
    "limner.drawing.order": "order",
    "limner.drawing.select": "select",
    "limner.errors": "BadInput CannotDraw DeviceFailed LimnerError MissingExtra NoFace NothingToDraw",
    "limner.motion.cost": "Costs costs",
    "limner.motion.machine": "Machine load_machine",
    "limner.motion.pen": "plan",
    "limner.pipeline": "Portrait Session Settings draw find_faces refine_face",
    "limner.settings": "read_toml write_toml",
    "limner.storage": "load save",
    "limner.targets.files": "read_drawing",
    "limner.targets.gcode": "GcodeSettings to_gcode",
    "limner.targets.gcode_read": "read_gcode",
    "limner.targets.hpgl": "to_hpgl",
    "limner.targets.hpgl_read": "read_hpgl",
    "limner.targets.image": "to_png to_rgb",
    "limner.targets.svg": "to_svg",
    "limner.targets.svg_read": "read_svg",
    "limner.types": "Drawing EdgeMap Face JointTrajectory Page Pen PenPath Photo Strokes",
    "limner.units": "parse_length_mm parse_page parse_time_s",
    "limner.vision.completion": "complete",
    "limner.vision.edges": "canny_edges gabor_edges gabor_pyramid_edges",
    "limner.vision.lines": "PICTURES STYLES draw_lines draw_picture edges_to_strokes",
    "limner.vision.photo": "crop_photo load_photo",
    "limner.vision.scale": "to_working_scale",
    "limner.vision.skeleton": "skeletonize",
    "limner.vision.trace": "trace",
    "limner.vision.trim": "trim",
}
_HOME = {name: module for module, names in _HOMES.items() for name in names.split()}

__all__ = ["__version__", *sorted(_HOME)]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'limner' has no attribute '{name}'")
    value = getattr(importlib.import_module(_HOME[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
