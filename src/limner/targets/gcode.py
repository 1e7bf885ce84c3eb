"""A drawing goes in; G-code for a plotter whose pen is moved by a servo or by the Z axis comes out."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from limner.errors import BadInput
from limner.settings import SettingsGroup, setting
from limner.types import Drawing, Floats, Page, Pen

MODES = "G21 G90 G17 G94"
"""Millimetres, absolute, the XY plane, feed per minute: said first, whatever the machine was at."""

FARTHEST_MM = 1e5
"""A point farther off is refused."""


@dataclass(frozen=True)
class GcodeSettings(SettingsGroup):
    """How G-code moves the pen."""

    pen: str = setting("servo", "What lifts the pen: servo = M3 S..., z = the Z axis", choices=("servo", "z"))
    servo_up: int = setting(300, "S of the raised servo", low=0, high=65_535)
    servo_down: int = setting(700, "S of the lowered servo", low=0, high=65_535)
    servo_s: float = setting(0.2, "Wait for the servo", unit="s", low=0, high=10)
    z_up_mm: float = setting(5.0, "Z of the raised pen", unit="mm", low=-1000, high=1000)
    z_down_mm: float = setting(0.0, "Z of the lowered pen", unit="mm", low=-1000, high=1000)
    z_mm_min: float = setting(600.0, "Feed at which Z lowers the pen", unit="mm/min", low=1, high=1e5)
    draw_mm_min: float = setting(2400.0, "Feed with the pen down", unit="mm/min", low=1, high=1e6)
    pen_change: str = setting("M0", "Lines where the next pen is put in, the one before raised; M0 waits for a key")
    header: str = setting("", "Lines after the modes; {width}, {height} of the page [mm] and {strokes} are filled in")
    footer: str = setting("M2", "Lines at the end, the pen raised and back at the origin; filled in alike")

    def __post_init__(self) -> None:
        super().__post_init__()
        low, high = (self.servo_up, self.servo_down) if self.pen == "servo" else (self.z_down_mm, self.z_up_mm)
        if self.pen == "servo" and low == high:
            raise BadInput(f"settings: gcode.servo_up = gcode.servo_down = {low}; expected two different values")
        if self.pen == "z" and low >= high:
            raise BadInput(f"settings: gcode.z_up_mm = {high:g} is not above gcode.z_down_mm = {low:g}")


class Words:
    """The words that move the pen, each line without its end."""

    def __init__(self, settings: GcodeSettings) -> None:
        self.settings = settings

    def up(self) -> list[str]:
        """Raise the pen; a Z pen at the speed of travel."""
        if self.settings.pen == "z":
            return [f"G0 Z{number(self.settings.z_up_mm)}"]
        return [f"M3 S{self.settings.servo_up}", f"G4 P{number(self.settings.servo_s)}"]

    def down(self) -> list[str]:
        """Lower the pen; a Z pen at its feed."""
        if self.settings.pen == "z":
            return [f"G1 Z{number(self.settings.z_down_mm)} F{number(self.settings.z_mm_min)}"]
        return [f"M3 S{self.settings.servo_down}", f"G4 P{number(self.settings.servo_s)}"]

    def travel(self, to_mm: Sequence[float]) -> str:
        """Go there with the pen up."""
        return f"G0 X{number(to_mm[0])} Y{number(to_mm[1])}"

    def draw(self, to_mm: Sequence[float], first: bool) -> str:
        """Draw to there; the first move after the pen went down says its feed."""
        feed = f" F{number(self.settings.draw_mm_min)}" if first else ""
        return f"G1 X{number(to_mm[0])} Y{number(to_mm[1])}{feed}"


def to_gcode(drawing: Drawing, settings: GcodeSettings | None = None) -> bytes:
    """The drawing as a G-code file.

    The origin is the page's lower left corner, where the pen is expected to be, raised, and where it ends. The pen
    travels (G0) only raised; it stays down where a stroke starts at the point at which the one before ended. Three
    decimals. Comments tell page, pen and each stroke's region; ``read_gcode`` reads them.

    Args:
        drawing: strokes in the page frame.
        settings: what lifts the pen, feeds, lines to put before and after.

    Raises:
        BadInput: a point is absurdly far off, or header or footer have a field that does not exist.
    """
    settings = settings or GcodeSettings()
    return ("\n".join(_lines(drawing, settings)) + "\n").encode()


def _lines(drawing: Drawing, settings: GcodeSettings) -> Iterator[str]:
    words, page = Words(settings), drawing.page
    yield f"(limner: page {_page(page)}, margin {page.margin_mm:.9g}, pen {drawing.pen.width_mm:.9g})"
    yield f"({_lift(settings)})"
    yield MODES
    yield from _template(settings.header, drawing, "header")
    yield from words.up()
    yield from () if drawing.pens == (Pen(drawing.pen.width_mm),) else _pen(drawing, 0)
    yield from _strokes(drawing, settings, _Tip(words))
    yield words.travel([0.0, 0.0])
    yield from _template(settings.footer, drawing, "footer")


def _strokes(drawing: Drawing, settings: GcodeSettings, tip: _Tip) -> Iterator[str]:
    changes = drawing.changes().tolist()
    for k, line in enumerate(drawing.lines_mm):
        points = rounded(line).tolist()
        if changes[k]:
            yield from tip.up()
            yield from [*_pen(drawing, k), *_template(settings.pen_change, drawing, "pen_change")]
        if points[0] != tip.place:
            yield from tip.up()
        yield f"(stroke {k + 1}: {drawing.region[k]})"
        yield from tip.draw(points)
    yield from tip.up()


class _Tip:
    """The pen's tip.

    Attributes:
        place: x, y where it is on the paper [mm]; None: it is raised.
    """

    def __init__(self, words: Words) -> None:
        self._words = words
        self.place: list[float] | None = None

    def up(self) -> Iterator[str]:
        """Raise it, if it is down."""
        if self.place is not None:
            self.place = None
            yield from self._words.up()

    def draw(self, points: list[list[float]]) -> Iterator[str]:
        """Draw a line; it goes on where the tip is, if that is down."""
        begins = self.place is None
        if begins:
            yield self._words.travel(points[0])
            yield from self._words.down()
        for k, to in enumerate(points[1:]):
            yield self._words.draw(to, begins and k == 0)
        self.place = points[-1]
        # A dot leaves the feed unsaid, so that what goes on from it says it.
        if begins and len(points) == 1:
            yield from self.up()


def _pen(drawing: Drawing, k: int) -> list[str]:
    """Which pen draws from the k-th line on."""
    pen = drawing.pens[int(drawing.layer[k])] if len(drawing.layer) else drawing.pen
    return [f"(pen {pen.name}: {pen.hex}, {pen.width_mm:.9g} mm)"]


def _page(page: Page) -> str:
    return f"{page.width_mm:.9g} x {page.height_mm:.9g} mm"


def _lift(settings: GcodeSettings) -> str:
    if settings.pen == "z":
        return f"pen up Z{number(settings.z_up_mm)}, down Z{number(settings.z_down_mm)}"
    return f"pen up S{settings.servo_up}, down S{settings.servo_down}"


def _template(text: str, drawing: Drawing, name: str) -> list[str]:
    page = drawing.page
    try:
        filled = text.replace("\\n", "\n").format(
            width=number(page.width_mm), height=number(page.height_mm), strokes=len(drawing.lines_mm)
        )
    except (KeyError, ValueError, IndexError) as error:
        raise BadInput(
            f"settings: gcode.{name}: no field {error}; choose {{width}}, {{height}}, {{strokes}}"
        ) from error
    return [line for line in filled.splitlines() if line.strip()]


def rounded(line: Floats) -> Floats:
    """A line as G-code can say it: in thousandths of a millimetre, without repeats.

    Raises:
        BadInput: a point is farther off than ``FARTHEST_MM``.
    """
    if np.abs(line).max() > FARTHEST_MM:
        raise BadInput(f"gcode: a point is more than {FARTHEST_MM / 1000:g} m off the page; place the drawing on it")
    microns = np.rint(line * 1000).astype(np.int64)
    new = np.concatenate([[True], (np.diff(microns, axis=0) != 0).any(axis=1)])
    points: Floats = microns[new] / 1000
    return points


def number(value: float) -> str:
    """Up to three decimals, as few as needed, never an exponent."""
    text = f"{value:.3f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text
