"""G-code goes in, ours or another's; what the pen draws by it comes out as a drawing."""

from __future__ import annotations

import math
import os
import re
from dataclasses import dataclass, field

import numpy as np

from limner import geometry
from limner.errors import BadInput
from limner.storage import read_bytes
from limner.targets.gcode import GcodeSettings
from limner.targets.paper import FARTHEST_MM, page_for
from limner.types import REGIONS, Drawing, Floats, Page, Pen

MAX_POINTS = 2_000_000

ARC_MM = 0.05
"""No arc is farther than this from the straight pieces it becomes."""

_LONGEST_LINE = 2000

_COMMENT = re.compile(r"\(([^)]*)\)|;(.*)$")
_WORD = re.compile(r"([A-Z])\s*([-+]?(?:\d+\.?\d*|\.\d+))")
_REAL = r"([-+]?(?:\d{1,20}(?:\.\d*)?|\.\d+)(?:e[-+]?\d{1,2})?)"
_PAGE = re.compile(rf"limner: page {_REAL} x {_REAL} mm, margin {_REAL}, pen {_REAL}")
_LIFT = re.compile(rf"pen up ([SZ]){_REAL}, down [SZ]{_REAL}")
_PEN = re.compile(rf"pen ([\w .-]{{1,99}}): #([0-9a-f]{{6}}), {_REAL} mm")
_STROKE = re.compile(r"stroke \d+: (\w+)")
_IGNORED = {4.0, 17.0, 40.0, 49.0, 54.0, 80.0, 94.0, 64.0, 61.0}
_REFUSED = {18.0: "the XZ plane", 19.0: "the YZ plane", 93.0: "inverse time feed"}


def read_gcode(source: bytes | str | os.PathLike[str], settings: GcodeSettings | None = None) -> Drawing:
    """Replay G-code: each path of the lowered pen is a stroke.

    Straight moves and arcs by centre (G0 to G3), inches and millimetres, absolute and relative, G92. What raises the
    pen is taken from our own comment, else from the settings: S or Z nearer to the lowered value than to the raised.

    Args:
        source: a path, or the file's bytes.
        settings: of a file that does not say what lifts the pen.

    Returns:
        Drawing; the page from our comment, else the smallest of the usual ones that holds it.

    Raises:
        BadInput: unreadable, or words that are not understood; with the number of the line.
    """
    data = source if isinstance(source, bytes) else read_bytes(os.fspath(source))
    name = "gcode" if isinstance(source, bytes) else os.fspath(source)
    replay = _Replay(settings or GcodeSettings())
    for k, line in enumerate(data.decode("utf-8", "replace").splitlines(), 1):
        try:
            replay.line(line)
        except BadInput as error:
            raise BadInput(f"{name}: line {k}: {error}") from error
    return replay.drawing()


@dataclass
class _Replay:
    """A plotter on paper: modes, where the pen is, what it has drawn."""

    settings: GcodeSettings
    place: list[float] = field(default_factory=lambda: [0.0, 0.0, math.inf])
    offset: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    scale: float = 1.0
    relative: bool = False
    motion: float = 0.0
    down: bool = False
    region: str = "face"
    page: Page | None = None
    width_mm: float = Pen().width_mm
    pens: list[Pen] = field(default_factory=list)
    layers: list[int] = field(default_factory=list)
    lines: list[list[list[float]]] = field(default_factory=list)
    regions: list[str] = field(default_factory=list)
    points: int = 0

    def line(self, text: str) -> None:
        """Do what a line says."""
        if len(text) > _LONGEST_LINE:
            raise BadInput(f"is longer than {_LONGEST_LINE} characters; this is no G-code")
        for comment in _COMMENT.finditer(text):
            self._comment(comment[1] or comment[2] or "")
        code = _COMMENT.sub("", text).split("*")[0].strip().upper().lstrip("/").strip("% \t")
        if code.startswith("$"):
            return
        words = _WORD.findall(code)
        left = _WORD.sub("", code).strip()
        if left:
            raise BadInput(f"'{left[:40]}' is no G-code")
        values = [(letter, float(number)) for letter, number in words]
        if not all(math.isfinite(value) for _, value in values):
            raise BadInput("a number is not finite")
        self._act(values)

    def _comment(self, text: str) -> None:
        if match := _PAGE.search(text):
            width, height, margin, pen = map(float, match.groups())
            self.page, self.width_mm = Page(width, height, margin), pen
        elif match := _PEN.search(text):
            red, green, blue = bytes.fromhex(match[2])
            self.pens.append(Pen(float(match[3]), (red, green, blue), match[1]))
        elif match := _LIFT.search(text):
            up, down = float(match[2]), float(match[3])
            levels = ("z_up_mm", "z_down_mm") if match[1] == "Z" else ("servo_up", "servo_down")
            values = dict(zip(levels, (up, down) if match[1] == "Z" else (int(up), int(down)), strict=True))
            self.settings = self.settings.replace(pen="z" if match[1] == "Z" else "servo", **values)
        elif match := _STROKE.search(text):
            self.region = match[1] if match[1] in REGIONS else "face"
            if self.down:
                self._begin()

    def _act(self, words: list[tuple[str, float]]) -> None:
        axes = {letter: value for letter, value in words if letter in "XYZIJR"}
        codes = [value for letter, value in words if letter == "G"]
        for code in codes:
            self._mode(code)
        for value in (value for letter, value in words if letter == "M"):
            if value == 5:
                self._lift(False)
        speeds = [value for letter, value in words if letter == "S"]
        if speeds and self.settings.pen == "servo" and 4.0 not in codes:
            up, down = self.settings.servo_up, self.settings.servo_down
            self._lift(abs(speeds[-1] - down) < abs(speeds[-1] - up))
        if 92.0 in codes:
            self._shift(axes)
        elif axes and 4.0 not in codes:
            self._move(axes)

    def _mode(self, code: float) -> None:
        if code in (0.0, 1.0, 2.0, 3.0):
            self.motion = code
        elif code in (20.0, 21.0):
            self.scale = 25.4 if code == 20 else 1.0
        elif code in (90.0, 91.0):
            self.relative = code == 91
        elif code in _REFUSED:
            raise BadInput(f"G{code:g} ({_REFUSED[code]}) is not understood")
        elif code not in _IGNORED | {92.0}:
            raise BadInput(f"G{code:g} is not understood")

    def _target(self, axes: dict[str, float]) -> list[float]:
        target = list(self.place)
        for k, letter in enumerate("XYZ"):
            if letter in axes:
                value = axes[letter] * self.scale
                base = self.place[k] if math.isfinite(self.place[k]) else 0.0
                target[k] = base + value if self.relative else value + self.offset[k]
        if max(map(abs, target[:2])) > FARTHEST_MM:
            raise BadInput(f"the pen goes farther than {FARTHEST_MM:g} mm; is this for a plotter?")
        return target

    def _shift(self, axes: dict[str, float]) -> None:
        for k, letter in enumerate("XYZ"):
            if letter in axes:
                base = self.place[k] if math.isfinite(self.place[k]) else 0.0
                self.offset[k] = base - axes[letter] * self.scale

    def _move(self, axes: dict[str, float]) -> None:
        target = self._target(axes)
        way = self._arc(axes, target) if self.motion > 1 else [target[:2]]
        if target[:2] != self.place[:2] and self.down:
            self.points += len(way)
            if self.points > MAX_POINTS:
                raise BadInput(f"more than {MAX_POINTS} points; simplify the drawing")
            self.lines[-1].extend(way)
        self.place = target
        if self.settings.pen == "z":
            z = target[2] - self.offset[2]
            self._lift(z < (self.settings.z_up_mm + self.settings.z_down_mm) / 2)

    def _arc(self, axes: dict[str, float], target: list[float]) -> list[list[float]]:
        if not {"I", "J"} & set(axes):
            raise BadInput("an arc without a centre (I, J) is not understood")
        centre = np.array(
            [self.place[0] + axes.get("I", 0) * self.scale, self.place[1] + axes.get("J", 0) * self.scale]
        )
        start, end = np.array(self.place[:2]) - centre, np.array(target[:2]) - centre
        radius = float(np.hypot(*start))
        begin = math.atan2(start[1], start[0])
        turn = (math.atan2(end[1], end[0]) - begin) % (2 * math.pi) or 2 * math.pi
        turn = turn if self.motion == 3 else (turn - 2 * math.pi or -2 * math.pi)
        if radius > FARTHEST_MM:
            raise BadInput(f"an arc of {radius:g} mm is absurdly large")
        pieces = max(1, math.ceil(abs(turn) * math.sqrt(radius / (8 * ARC_MM))))
        angles = begin + turn * np.arange(1, pieces) / pieces
        inner = centre + radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        return [*inner.tolist(), target[:2]]

    def _lift(self, down: bool) -> None:
        if down and not self.down:
            self._begin()
        self.down = down

    def _begin(self) -> None:
        self.lines.append([self.place[:2]])
        self.regions.append(self.region)
        self.layers.append(max(len(self.pens) - 1, 0))
        self.points += 1

    def drawing(self) -> Drawing:
        """What was drawn."""
        lines: list[Floats] = [np.round(np.array(line), 6) for line in self.lines]
        weights = np.array([geometry.length(line) for line in lines])
        pens = tuple(self.pens) or (Pen(self.width_mm),)
        page = self.page or page_for(lines)
        return Drawing(tuple(lines), tuple(self.regions), weights, page, pens, np.array(self.layers, np.int64))
