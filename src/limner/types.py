"""The types that the stages hand on, from the photo to the joints; all frozen, arrays read-only, shapes checked once.

Frames: *photo* is pixels, x right, y down, (0, 0) the centre of the top-left pixel;
*page* is millimetres, origin at the lower left, y up; *paper* is the page with z up from the sheet.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from limner.errors import BadInput

Floats = NDArray[np.float64]

LANDMARK_COUNTS = (68, 39)
"""Points of a frontal face (iBUG-68) and of a profile (MultiPIE-39)."""

REGIONS = ("eye", "brow", "nose", "mouth", "jaw", "ear", "hair", "face", "body", "background")
"""What a stroke belongs to; ``face`` is skin between the features."""


def frozen_array(value: ArrayLike, dtype: Any, shape: tuple[int | None, ...], name: str) -> NDArray[Any]:
    """Copy ``value`` into a read-only array, or say what shape was expected.

    Args:
        value: anything numpy can read.
        dtype: of the result.
        shape: expected shape; ``None`` stands for any length.
        name: of the field, for the message.

    Raises:
        BadInput: the shape is another one, or a float is not finite.
    """
    try:
        if isinstance(value, np.ndarray) and value.dtype.kind not in "biufO":
            raise TypeError(f"values of type {value.dtype}")
        with np.errstate(over="raise", invalid="raise"):
            array = np.array(value, dtype=dtype)
    except (TypeError, ValueError, OverflowError, FloatingPointError) as error:
        raise BadInput(f"{name}: expected numbers of shape {_shape(shape)}, got something else ({error})") from error
    if array.ndim != len(shape) or any(want not in (None, got) for want, got in zip(shape, array.shape, strict=True)):
        raise BadInput(f"{name}: expected shape {_shape(shape)}, got {_shape(array.shape)}")
    if array.dtype.kind == "f" and not np.isfinite(array).all():
        raise BadInput(f"{name}: expected finite numbers, got NaN or infinity")
    array.setflags(write=False)
    return array


def _shape(shape: Sequence[int | None]) -> str:
    return "(" + ", ".join("n" if n is None else str(n) for n in shape) + ("," if len(shape) == 1 else "") + ")"


class Value:
    """Equality by content for the types below (their fields hold arrays)."""

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        fields = dataclasses.fields(self)  # type: ignore[arg-type]
        return all(same(getattr(self, f.name), getattr(other, f.name)) for f in fields)

    __hash__ = None  # type: ignore[assignment]

    def _freeze(self, name: str, value: object) -> None:
        object.__setattr__(self, name, value)


def same(a: Any, b: Any) -> bool:
    """Whether two values have one content: values of this file, arrays, tuples, anything with ==."""
    if a is b:
        return True
    if isinstance(a, np.ndarray) or isinstance(b, np.ndarray):
        return type(a) is type(b) and bool(np.array_equal(a, b))
    if isinstance(a, tuple) and isinstance(b, tuple):
        return len(a) == len(b) and all(map(same, a, b))
    return bool(a == b)


@dataclass(frozen=True, eq=False)
class Photo(Value):
    """A picture, already upright.

    Attributes:
        rgb: (H, W, 3) uint8, sRGB.
    """

    rgb: NDArray[np.uint8]

    def __post_init__(self) -> None:
        self._freeze("rgb", frozen_array(self.rgb, np.uint8, (None, None, 3), "Photo.rgb"))
        if 0 in self.rgb.shape:
            raise BadInput(f"Photo.rgb: expected at least one pixel, got {self.rgb.shape[1]} x {self.rgb.shape[0]}")

    @property
    def size_px(self) -> tuple[int, int]:
        """Width and height."""
        return self.rgb.shape[1], self.rgb.shape[0]


@dataclass(frozen=True, eq=False)
class Face(Value):
    """A face found in a photo.

    Attributes:
        points_px: (68, 2) landmarks in iBUG-68 order, or (39, 2) in MultiPIE-39 order for a profile; photo frame.
        box_px: (4,) x0, y0, x1, y1 around the face.
        score: the detector's own, higher is better.
        yaw_deg: turn of the head; positive = the nose points to image right.
        detector: the name of what found it.
    """

    points_px: Floats
    box_px: Floats
    score: float = 0.0
    yaw_deg: float = 0.0
    detector: str = "file"

    def __post_init__(self) -> None:
        self._freeze("points_px", frozen_array(self.points_px, np.float64, (None, 2), "Face.points_px"))
        self._freeze("box_px", frozen_array(self.box_px, np.float64, (4,), "Face.box_px"))
        if len(self.points_px) not in LANDMARK_COUNTS:
            raise BadInput(f"Face.points_px: expected 68 or 39 landmarks, got {len(self.points_px)}")
        for name in ("score", "yaw_deg"):
            self._freeze(name, float(frozen_array(getattr(self, name), np.float64, (), f"Face.{name}")))
        if not isinstance(self.detector, str):
            raise BadInput(f"Face.detector: expected a name, got {self.detector!r}")
        if self.box_px[2] <= self.box_px[0] or self.box_px[3] <= self.box_px[1]:
            raise BadInput(f"Face.box_px: expected x0 < x1 and y0 < y1, got {self.box_px.tolist()}")

    @property
    def frontal(self) -> bool:
        """Whether all 68 landmarks are there, as the drawing needs."""
        return len(self.points_px) == 68

    @property
    def outer_eye_px(self) -> float:
        """Distance of the outer eye corners, the unit in which lengths on a face are given.

        Raises:
            BadInput: the face is a profile, or both corners are one point.
        """
        if not self.frontal:
            raise BadInput("face: a profile of 39 landmarks has one eye; expected a frontal face with 68")
        distance = float(np.hypot(*(self.points_px[45] - self.points_px[36])))
        if distance < 1e-6:
            raise BadInput("face: both outer eye corners (landmarks 36 and 45) are one point; expected two places")
        return distance


@dataclass(frozen=True, eq=False)
class EdgeMap(Value):
    """Pixels that may be line.

    Attributes:
        mask: (H, W) bool.
        strength: (H, W) in [0, 1], how sure.
        angle_rad: (H, W) in [0, pi), the direction of the line (the tangent), from x towards y (down).
    """

    mask: NDArray[np.bool_]
    strength: Floats
    angle_rad: Floats

    def __post_init__(self) -> None:
        self._freeze("mask", frozen_array(self.mask, np.bool_, (None, None), "EdgeMap.mask"))
        height, width = self.mask.shape
        for name in ("strength", "angle_rad"):
            array = frozen_array(getattr(self, name), np.float64, (height, width), f"EdgeMap.{name}")
            self._freeze(name, array)
        if self.strength.size and not (self.strength.min() >= 0 and self.strength.max() <= 1):
            raise BadInput("EdgeMap.strength: expected values in [0, 1]")
        if self.angle_rad.size and not (self.angle_rad.min() >= 0 and self.angle_rad.max() < np.pi):
            raise BadInput("EdgeMap.angle_rad: expected values in [0, pi)")


def _lines(lines: Sequence[ArrayLike], name: str) -> tuple[Floats, ...]:
    frozen = tuple(frozen_array(line, np.float64, (None, 2), f"{name}[{i}]") for i, line in enumerate(lines))
    for i, line in enumerate(frozen):
        if len(line) < 1:
            raise BadInput(f"{name}[{i}]: expected at least one point, got none")
    return frozen


def _regions(regions: Sequence[str], n: int, name: str) -> tuple[str, ...]:
    regions = tuple(regions)
    if len(regions) != n:
        raise BadInput(f"{name}: expected one for each of {n} lines, got {len(regions)}")
    for region in regions:
        if region not in REGIONS:
            raise BadInput(f"{name}: expected one of {', '.join(REGIONS)}, got '{region}'")
    return regions


_PEN_NAME = re.compile(r"[\w][\w .-]{0,39}", re.ASCII)


@dataclass(frozen=True)
class Pen:
    """What draws: the width of its line [mm], its colour (sRGB, 0 to 255) and what people call it."""

    width_mm: float = 0.5
    rgb: tuple[int, int, int] = (0, 0, 0)
    name: str = "black"

    def __post_init__(self) -> None:
        object.__setattr__(self, "width_mm", float(self.width_mm))
        rgb = tuple(int(value) for value in self.rgb)
        object.__setattr__(self, "rgb", rgb)
        if not 0.01 <= self.width_mm <= 50:
            raise BadInput(f"pen: a line width of {self.width_mm:g} mm, expected 0.01 to 50 mm")
        if len(rgb) != 3 or not all(0 <= value <= 255 for value in rgb):
            raise BadInput(f"pen: a colour of {rgb}, expected red, green and blue from 0 to 255")
        if not _PEN_NAME.fullmatch(self.name):
            raise BadInput(f"pen: the name '{self.name}', expected up to 40 letters, digits, spaces, dots, - and _")

    @property
    def hex(self) -> str:
        """The colour as #rrggbb."""
        return "#" + bytes(self.rgb).hex()


def _pens(pens: object, name: str) -> tuple[Pen, ...]:
    found = tuple(pen for pen in pens if isinstance(pen, Pen)) if isinstance(pens, Sequence) else ()
    if not isinstance(pens, Sequence) or not found or len(found) < len(pens):
        raise BadInput(f"{name}: expected a tuple of at least one pen")
    return found


def _layers(layer: ArrayLike, n: int, pens: int, name: str) -> NDArray[np.int64]:
    given = frozen_array(np.zeros(n) if np.size(layer) == 0 else layer, np.int64, (n,), name)
    if n and not (given.min() >= 0 and given.max() < pens):
        raise BadInput(f"{name}: expected indices of {pens} pens, got {given.min()} to {given.max()}")
    return given


def _first_layer() -> NDArray[np.int64]:
    return np.zeros(0, np.int64)


@dataclass(frozen=True, eq=False)
class Strokes(Value):
    """Ordered polylines in the photo.

    Attributes:
        lines_px: tuple of (n, 2), photo frame; closed when first = last.
        region: of each line, one of ``REGIONS``.
        weight: (lines,) how much the drawing would miss it, >= 0.
        size_px: width and height of the photo.
        pens: what colours there are; their widths are settled where the strokes are placed on a page.
        layer: (lines,) index of each line's pen; none given: the first.
    """

    lines_px: tuple[Floats, ...]
    region: tuple[str, ...]
    weight: Floats
    size_px: tuple[int, int]
    pens: tuple[Pen, ...] = (Pen(),)
    layer: NDArray[np.int64] = field(default_factory=_first_layer)

    def __post_init__(self) -> None:
        self._freeze("lines_px", _lines(self.lines_px, "Strokes.lines_px"))
        self._freeze("region", _regions(self.region, len(self.lines_px), "Strokes.region"))
        self._freeze("weight", frozen_array(self.weight, np.float64, (len(self.lines_px),), "Strokes.weight"))
        width, height = self.size_px
        self._freeze("size_px", (int(width), int(height)))
        self._freeze("pens", _pens(self.pens, "Strokes.pens"))
        self._freeze("layer", _layers(self.layer, len(self.lines_px), len(self.pens), "Strokes.layer"))


@dataclass(frozen=True)
class Page:
    """A sheet of paper [mm], with the margin that stays white on each side."""

    width_mm: float = 148.0
    height_mm: float = 210.0
    margin_mm: float = 10.0

    def __post_init__(self) -> None:
        for name in ("width_mm", "height_mm", "margin_mm"):
            value = float(getattr(self, name))
            object.__setattr__(self, name, value)
            if not np.isfinite(value):
                raise BadInput(f"page: {name} is {value}, expected a finite length")
        if not (1 <= self.width_mm <= 10_000 and 1 <= self.height_mm <= 10_000):
            raise BadInput(f"page: {self.width_mm:g} x {self.height_mm:g} mm, expected sides between 1 and 10000 mm")
        if not 0 <= self.margin_mm < min(self.width_mm, self.height_mm) / 2:
            raise BadInput(
                f"page: a margin of {self.margin_mm:g} mm leaves nothing of {self.width_mm:g} x {self.height_mm:g} mm;"
                " choose a smaller one"
            )


@dataclass(frozen=True, eq=False)
class Drawing(Value):
    """Strokes on a page, in the order in which they are drawn.

    Attributes:
        lines_mm: tuple of (n, 2), page frame; closed when first = last.
        region: of each line, one of ``REGIONS``.
        weight: (lines,) how much the drawing would miss it, >= 0.
        page: the sheet.
        pens: what draws, in the order in which they are used.
        layer: (lines,) index of each line's pen, never less than the line's before: a pen is put in once; none given:
            the first.
    """

    lines_mm: tuple[Floats, ...]
    region: tuple[str, ...]
    weight: Floats
    page: Page = Page()
    pens: tuple[Pen, ...] = (Pen(),)
    layer: NDArray[np.int64] = field(default_factory=_first_layer)

    def __post_init__(self) -> None:
        self._freeze("lines_mm", _lines(self.lines_mm, "Drawing.lines_mm"))
        self._freeze("region", _regions(self.region, len(self.lines_mm), "Drawing.region"))
        self._freeze("weight", frozen_array(self.weight, np.float64, (len(self.lines_mm),), "Drawing.weight"))
        self._freeze("pens", _pens(self.pens, "Drawing.pens"))
        self._freeze("layer", _layers(self.layer, len(self.lines_mm), len(self.pens), "Drawing.layer"))
        if (np.diff(self.layer) < 0).any():
            raise BadInput("Drawing.layer: expected the lines of each pen together, in the order of the pens")

    @property
    def points(self) -> int:
        """Vertices the machine must go to."""
        return sum(len(line) for line in self.lines_mm)

    @property
    def pen(self) -> Pen:
        """The widest of the pens, the first of those."""
        return max(self.pens, key=lambda pen: pen.width_mm)

    def pick(self, which: Sequence[int]) -> Drawing:
        """The drawing of some of its lines, in this order, which must keep each pen's together."""
        return dataclasses.replace(
            self,
            lines_mm=tuple(self.lines_mm[i] for i in which),
            region=tuple(self.region[i] for i in which),
            weight=self.weight[list(which)],
            layer=self.layer[list(which)],
        )

    def by_pen(self) -> list[Drawing]:
        """The drawing of each pen that draws something, one after the other."""
        return [self.pick(np.flatnonzero(self.layer == k).tolist()) for k in np.unique(self.layer).tolist()]

    def changes(self) -> NDArray[np.bool_]:
        """(lines,) whether another pen is put in before the line."""
        changed: NDArray[np.bool_] = np.diff(self.layer, prepend=self.layer[:1]) > 0
        return changed


@dataclass(frozen=True, eq=False)
class PenPath(Value):
    """Where the pen is at which time.

    Attributes:
        t_s: (n,) not decreasing.
        position_mm: (n, 3) of the tip, paper frame.
        down: (n,) whether the move that ends here draws.
        stroke: (n,) index of the stroke, -1 in travel.
    """

    t_s: Floats
    position_mm: Floats
    down: NDArray[np.bool_]
    stroke: NDArray[np.int64]

    def __post_init__(self) -> None:
        self._freeze("t_s", frozen_array(self.t_s, np.float64, (None,), "PenPath.t_s"))
        n = len(self.t_s)
        self._freeze("position_mm", frozen_array(self.position_mm, np.float64, (n, 3), "PenPath.position_mm"))
        self._freeze("down", frozen_array(self.down, np.bool_, (n,), "PenPath.down"))
        self._freeze("stroke", frozen_array(self.stroke, np.int64, (n,), "PenPath.stroke"))
        _check_time(self.t_s, "PenPath.t_s")

    def at(self, t_s: ArrayLike) -> Floats:
        """Position of the tip [mm] at the given times, linear between samples, held before and after: (..., 3)."""
        return _interpolate(t_s, self.t_s, self.position_mm)


def _no_sheet() -> Floats:
    return np.zeros((0, 3))


@dataclass(frozen=True, eq=False)
class JointTrajectory(Value):
    """Where each joint is at which time.

    Attributes:
        names: of the joints (dof).
        t_s: (n,) not decreasing.
        q, qd, qdd: (n, dof) position, velocity, acceleration [rad or m, per s, per s^2].
        down: (n,) whether the move that ends here draws.
        stroke: (n,) index of the stroke, -1 in travel.
        press_mm: how far below the sheet the tip is led where it draws; a spring takes it up.
        sheet_m: (4, 3) corners of the sheet it was planned for, counter-clockwise from the lower left, in the robot's
            base frame [m]; (0, 3) where nobody says.
    """

    names: tuple[str, ...]
    t_s: Floats
    q: Floats
    qd: Floats
    qdd: Floats
    down: NDArray[np.bool_]
    stroke: NDArray[np.int64]
    press_mm: float = 0.0
    sheet_m: Floats = field(default_factory=_no_sheet)

    def __post_init__(self) -> None:
        self._freeze("names", tuple(str(name) for name in self.names))
        self._freeze("t_s", frozen_array(self.t_s, np.float64, (None,), "JointTrajectory.t_s"))
        n, dof = len(self.t_s), len(self.names)
        for name in ("q", "qd", "qdd"):
            array = frozen_array(getattr(self, name), np.float64, (n, dof), f"JointTrajectory.{name}")
            self._freeze(name, array)
        self._freeze("down", frozen_array(self.down, np.bool_, (n,), "JointTrajectory.down"))
        self._freeze("stroke", frozen_array(self.stroke, np.int64, (n,), "JointTrajectory.stroke"))
        _check_time(self.t_s, "JointTrajectory.t_s")
        self._freeze("press_mm", float(self.press_mm))
        if not 0 <= self.press_mm <= 100:
            raise BadInput(f"JointTrajectory.press_mm: {self.press_mm:g} mm, expected 0 to 100")
        corners = np.zeros((0, 3)) if np.size(self.sheet_m) == 0 else self.sheet_m
        given = frozen_array(corners, np.float64, (None, 3), "JointTrajectory.sheet_m")
        if len(given) not in (0, 4):
            raise BadInput(f"JointTrajectory.sheet_m: expected four corners or none, got {len(given)}")
        self._freeze("sheet_m", given)

    def at(self, t_s: ArrayLike) -> Floats:
        """Joint positions at the given times, linear between samples, held before and after: (..., dof)."""
        return _interpolate(t_s, self.t_s, self.q)


def _check_time(t_s: Floats, name: str) -> None:
    if len(t_s) < 1:
        raise BadInput(f"{name}: expected at least one sample, got none")
    if (np.diff(t_s) < 0).any():
        raise BadInput(f"{name}: expected times that never go back")


def _interpolate(t_s: ArrayLike, times_s: Floats, values: Floats) -> Floats:
    t = np.asarray(t_s, dtype=np.float64)
    columns = [np.interp(t, times_s, values[:, k]) for k in range(values.shape[1])]
    return np.stack(columns, axis=-1)
