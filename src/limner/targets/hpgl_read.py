"""HP-GL goes in, ours or another's; what the pen draws by it comes out as a drawing."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass, field

import numpy as np

from limner import geometry
from limner.errors import BadInput
from limner.storage import read_bytes
from limner.targets.hpgl import UNITS_PER_MM
from limner.targets.paper import FARTHEST_MM, page_for
from limner.types import Drawing, Floats, Page, Pen

MAX_POINTS = 2_000_000

# A label runs to its terminator (ETX), a comment is quoted, any other word to the next word or semicolon.
_WORD = re.compile(r'LB[^\x03]*(?:\x03|$)|CO\s*"[^"]*(?:"|$)|([A-Z]{2})([^A-Z;]*);?|;|\s+', re.IGNORECASE)
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)")
_REFUSED = {"SC": "scaling", "RO": "rotation", "IP": "another frame", "PE": "encoded lines", "AA": "arcs", "AR": "arcs"}


def read_hpgl(source: bytes | str | os.PathLike[str], page: Page | None = None) -> Drawing:
    """Replay HP-GL: each path of the lowered pen is a stroke; labels and words that only set the scene are left out.

    Args:
        source: a path, or the file's bytes.
        page: the sheet; by default the smallest of the usual ones that holds the drawing.

    Raises:
        BadInput: unreadable, no HP-GL, or words that would draw but are not understood.
    """
    name = "hpgl" if isinstance(source, bytes) else os.fspath(source)
    data = source if isinstance(source, bytes) else read_bytes(os.fspath(source))
    text, replay, at = data.decode("latin-1"), _Replay(), 0
    while at < len(text):
        match = _WORD.match(text, at)
        if match is None or (match[0][:2].upper() in ("LB", "CO") and match[0][-1] not in '\x03"'):
            raise BadInput(f"{name}: {text[at : at + 20]!r} at byte {at} is no HP-GL")
        try:
            replay.word((match[1] or "").upper(), match[2] or "")
        except BadInput as error:
            raise BadInput(f"{name}: byte {at}: {error}") from error
        at = match.end()
    return replay.drawing(page)


def _whole(number: str) -> int:
    digits = number.partition(".")[0] or "0"
    if len(digits) > 6:
        raise BadInput(f"SP {number:.20} is no pen")
    return int(digits) if digits.strip("+-") else 0


@dataclass
class _Replay:
    place: tuple[float, float] = (0.0, 0.0)
    down: bool = False
    relative: bool = False
    lines: list[list[tuple[float, float]]] = field(default_factory=list)
    pen: int = 1
    pens: list[int] = field(default_factory=list)
    points: int = 0

    def word(self, name: str, values: str) -> None:
        """Do what a word says."""
        if name in _REFUSED and values.strip():
            raise BadInput(f"{name} ({_REFUSED[name]}) is not understood; expected lines in plotter units")
        if name in ("IN", "DF", "SP"):
            self.down = False
            self.pen = _whole((_NUMBER.findall(values) or ["1"])[0]) if name == "SP" else 1
            self.relative = self.relative and name == "SP"
        elif name in ("PA", "PR"):
            self.relative = name == "PR"
        elif name in ("PU", "PD"):
            self._lift(name == "PD")
        if name in ("PA", "PR", "PU", "PD"):
            self._go(name, [float(number) for number in _NUMBER.findall(values)])

    def _lift(self, down: bool) -> None:
        if down and not self.down:
            self.lines.append([self.place])
            self.pens.append(self.pen)
            self.points += 1
        self.down = down

    def _go(self, name: str, numbers: list[float]) -> None:
        if len(numbers) % 2:
            raise BadInput(f"{name} has {len(numbers)} numbers; expected pairs")
        self.points += len(numbers) // 2
        if self.points > MAX_POINTS:
            raise BadInput(f"more than {MAX_POINTS} points; simplify the drawing")
        for x, y in zip(numbers[::2], numbers[1::2], strict=True):
            self.place = (self.place[0] + x, self.place[1] + y) if self.relative else (x, y)
            if not max(map(abs, self.place)) <= FARTHEST_MM * UNITS_PER_MM:
                raise BadInput(f"{name} goes farther than {FARTHEST_MM:g} mm; is this for a plotter?")
            if self.down:
                self.lines[-1].append(self.place)

    def drawing(self, page: Page | None) -> Drawing:
        """What was drawn."""
        lines: list[Floats] = [geometry.without_repeats(np.array(line) / UNITS_PER_MM) for line in self.lines]
        weights = np.array([geometry.length(line) for line in lines])
        by_pen = np.argsort(self.pens, kind="stable").tolist()
        used, layer = np.unique(self.pens, return_inverse=True)
        colours = tuple(Pen(name=f"pen {number}") for number in used.tolist()) if len(used) > 1 else (Pen(),)
        return Drawing(
            tuple(lines[i] for i in by_pen),
            ("face",) * len(lines),
            weights[by_pen],
            page or page_for(lines),
            colours,
            layer[by_pen],
        )
