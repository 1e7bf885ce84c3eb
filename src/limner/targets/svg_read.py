"""An SVG file goes in, our own or anybody's; its outlines come out as a drawing, curves as short straight pieces."""

from __future__ import annotations

import io
import json
import math
import os
import re
from collections import Counter
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree

import numpy as np

from limner import geometry
from limner.errors import BadInput
from limner.storage import read_bytes
from limner.targets.flatten import flatten
from limner.targets.svg import ABOUT_NAMESPACE, INKSCAPE_NAMESPACE
from limner.targets.svg_guard import MAX_BYTES, check_svg
from limner.types import REGIONS, Drawing, Floats, Page, Pen

if TYPE_CHECKING:
    from svgelements import SVG, Path, Shape

TOLERANCE_MM = 0.05
"""No curve is farther than this from the straight pieces it becomes."""

MAX_POINTS = 2_000_000
"""A drawing of more points is refused."""

UNKNOWN_REGION = "face"
"""Region of strokes that do not say theirs."""

_MM_PER_PX = 25.4 / 96  # CSS
_MM = {"mm": 1.0, "cm": 10.0, "q": 0.25, "in": 25.4, "pt": 25.4 / 72, "pc": 25.4 / 6, "px": _MM_PER_PX, "": _MM_PER_PX}
# Each part can begin in one place only: of a megabyte of digits nothing is tried twice.
_LENGTH = re.compile(r"\+?((?:\d+(?:\.\d+)?|\.\d+)(?:e[+-]?\d{1,3})?)\s*(mm|cm|q|in|pt|pc|px|)", re.IGNORECASE)
_UNSEEN = ("symbol", "marker", "mask")
_LAYER = "data-limner-layer"
_NO_LAYER = (0, "")
_NUMBERED = re.compile(r"^\d+\s*-")
_UNNAMED = re.compile(r"[^\w .-]", re.ASCII)
_DIGITS = 6
_DEFAULT_PAGE_MM = (210.0, 297.0)


def read_svg(source: bytes | str | os.PathLike[str]) -> Drawing:
    """Read the lines of an SVG.

    Paths, lines, polylines, polygons, rectangles, circles and ellipses within groups, transforms and ``<use>``,
    in any unit, whatever their fill; text, pictures, and what is not displayed are left out. The region and weight
    of strokes that ``to_svg`` wrote are read; others get ``UNKNOWN_REGION`` and their length in mm. Each of Inkscape's
    layers that has strokes is a pen, of the colour and width of most of them; without layers all is drawn with one
    black pen. A file that says no size gets an A4 page, or a larger one if its lines need it.

    Args:
        source: a path, or the file's bytes.

    Returns:
        Drawing in the page frame, strokes in document order, layer by layer.

    Raises:
        BadInput: unreadable, no SVG, entities, too large, or a page outside the limits of ``Page``.
    """
    data, name = _read(source)
    check_svg(data, name)
    root = _parse(_tidied(_tree(data, name)), name)
    try:
        mm_per_px = _mm_per_px(root)
        strokes = list(_strokes(root, mm_per_px))
        width_mm, height_mm = _page_size(root, [line for line, _ in strokes])
        strokes.sort(key=lambda stroke: _layer(stroke[1])[0])
        layers = sorted({_layer(shape) for _, shape in strokes}) or [_NO_LAYER]
        numbers = [number for number, _ in layers]
        return Drawing(
            tuple(_rounded(line * [1, -1] + [0, height_mm]) for line, _ in strokes),
            tuple(_region(shape) for _, shape in strokes),
            np.array([_weight(shape, line) for line, shape in strokes]),
            Page(width_mm, height_mm, _margin(root, min(width_mm, height_mm))),
            tuple(
                _pen(layer, [shape for _, shape in strokes if _layer(shape) == layer], mm_per_px) for layer in layers
            ),
            np.array([numbers.index(_layer(shape)[0]) for _, shape in strokes], np.int64),
        )
    except BadInput as error:
        raise BadInput(f"{name}: {error}") from error


def read_about(source: bytes | str | os.PathLike[str]) -> dict[str, Any]:
    """What ``to_svg`` was told about the drawing; empty for an SVG of another make.

    Raises:
        BadInput: as ``read_svg``.
    """
    data, name = _read(source)
    check_svg(data, name)
    text = _tree(data, name).findtext(f".//{{{ABOUT_NAMESPACE}}}about", "{}")
    try:
        about = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise BadInput(f"{name}: what it says about itself is no JSON ({error})") from error
    return about if isinstance(about, dict) else {}


def _read(source: bytes | str | os.PathLike[str]) -> tuple[bytes, str]:
    if isinstance(source, bytes):
        return source, "svg"
    return read_bytes(os.fspath(source), MAX_BYTES), os.fspath(source)


def _tree(data: bytes, name: str) -> ElementTree.Element:
    try:
        return ElementTree.fromstring(data)
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        raise BadInput(f"{name}: is no SVG ({error})") from error


def _tidied(root: ElementTree.Element) -> bytes:
    """Without paths that have no data, and what is only drawn when referred to moved into ``<defs>``; layers numbered.

    The library stumbles over the first, draws the second, and hands attributes on from a group to what is in it.
    """
    layers = (group for group in root.iter() if group.get(f"{{{INKSCAPE_NAMESPACE}}}groupmode") == "layer")
    for number, group in enumerate(layers, 1):
        group.set(_LAYER, f"{number} {group.get(f'{{{INKSCAPE_NAMESPACE}}}label', '')}")
    for parent in list(root.iter()):
        for k, child in enumerate(list(parent)):
            space, _, tag = str(child.tag).rpartition("}")
            if tag in _UNSEEN and not parent.tag.endswith("defs"):
                parent[k] = ElementTree.Element(f"{space}}}defs" if space else "defs")
                parent[k].append(child)
            elif tag == "path" and "d" not in child.attrib:
                child.set("d", "")
    return ElementTree.tostring(root)


def _parse(data: bytes, name: str) -> SVG:
    from svgelements import SVG

    try:
        root = SVG.parse(io.BytesIO(data), ppi=96)
    except Exception as error:  # the library raises whatever odd attributes lead it to
        raise BadInput(f"{name}: cannot be understood as SVG ({' '.join(str(error).split())[:120]})") from error
    if not isinstance(root, SVG):
        raise BadInput(f"{name}: is no SVG; it does not say xmlns='http://www.w3.org/2000/svg'")
    return root


def _strokes(root: SVG, mm_per_px: float) -> Iterator[tuple[Floats, Shape]]:
    """Each subpath [mm, y down] with the shape that it belongs to."""
    from svgelements import Shape

    points = 0
    for shape in root.elements(lambda element: isinstance(element, Shape)):
        if not _visible(shape):
            continue
        for subpath in flatten(_path(shape), TOLERANCE_MM / mm_per_px):
            line = geometry.without_repeats(_rounded(subpath * mm_per_px))
            points += len(line)
            if points > MAX_POINTS:
                raise BadInput(f"more than {MAX_POINTS} points; simplify it")
            yield line, shape


def _path(shape: Shape) -> Path:
    from svgelements import Path

    try:
        return Path(shape)
    except Exception as error:  # likewise for lengths in units that mean nothing
        kind = type(shape).__name__.lower()
        raise BadInput(
            f"a {kind} cannot be understood ({' '.join(str(error).split())[:120]}); give its lengths in mm"
        ) from error


def _visible(shape: Shape) -> bool:
    inked = shape.stroke.value is not None or shape.fill.value is not None
    return inked and shape.values.get("visibility") not in ("hidden", "collapse")


def _rounded(line: Floats) -> Floats:
    """Free of the last digits that unit conversions leave, so that what was written comes back."""
    rounded: Floats = np.round(line, _DIGITS)
    return rounded


def _mm_per_px(root: SVG) -> float:
    """Nearly ``_MM_PER_PX``: what the library rounded in the conversion of the page's width is put right."""
    width_mm = _length_mm(root.values.get("width"))
    return width_mm / root.width if width_mm and root.width else _MM_PER_PX


def _page_size(root: SVG, lines: list[Floats]) -> tuple[float, float]:
    if root.viewbox is None and not {"width", "height"} <= set(root.values):
        reach = np.concatenate([[_DEFAULT_PAGE_MM], *lines]).max(axis=0)
        return float(reach[0]), float(reach[1])
    width_mm, height_mm = (_length_mm(root.values.get(side)) for side in ("width", "height"))
    return (
        round(float(root.width) * _MM_PER_PX, _DIGITS) if width_mm is None else width_mm,
        round(float(root.height) * _MM_PER_PX, _DIGITS) if height_mm is None else height_mm,
    )


def _length_mm(text: Any) -> float | None:
    """Of an absolute length; none for percentages, other units, and what is no length."""
    match = _LENGTH.fullmatch(str(text).strip())
    return round(float(match[1]) * _MM[match[2].lower()], _DIGITS) if match else None


def _margin(root: SVG, side_mm: float) -> float:
    margin = _number(root.values.get("data-margin-mm"), 0.0)
    return margin if margin < side_mm / 2 else 0.0


def _layer(shape: Shape) -> tuple[int, str]:
    """Number and label of the layer that a shape is in."""
    number, _, label = str(shape.values.get(_LAYER, "0 ")).partition(" ")
    return (int(number), label) if number.isdecimal() else _NO_LAYER


def _pen(layer: tuple[int, str], shapes: list[Shape], mm_per_px: float) -> Pen:
    """The width of most strokes, black; of a layer the colour of most, too, and the layer's name."""
    width_mm = _width_mm(shapes, mm_per_px)
    if layer == _NO_LAYER:
        return Pen(width_mm)
    colours = [shape.stroke if shape.stroke.value is not None else shape.fill for shape in shapes]
    rgb = Counter((int(c.red), int(c.green), int(c.blue)) for c in colours).most_common(1)[0][0]
    name = " ".join(_UNNAMED.sub(" ", _NUMBERED.sub("", layer[1])).split())[:40].strip(" .-")
    return Pen(width_mm, rgb, name or f"pen {layer[0]}")


def _width_mm(shapes: list[Shape], mm_per_px: float) -> float:
    widths = [
        round(_number(shape.stroke_width, 0.0) * mm_per_px, _DIGITS)
        for shape in shapes
        if shape.stroke.value is not None
    ]
    widths = [width for width in widths if 0.01 <= width <= 50]
    return Counter(widths).most_common(1)[0][0] if widths else Pen().width_mm


def _region(shape: Shape) -> str:
    region = shape.values.get("data-region")
    return region if region in REGIONS else UNKNOWN_REGION


def _weight(shape: Shape, line: Floats) -> float:
    return _number(shape.values.get("data-weight"), geometry.length(line))


def _number(value: Any, default: float) -> float:
    """A finite number that is not negative, else the default."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        return default
    return number if math.isfinite(number) and number >= 0 else default
