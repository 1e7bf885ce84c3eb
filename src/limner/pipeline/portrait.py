"""What became of a photo goes in; its files, its report and its likeness come out."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from limner import __version__, storage
from limner.drawing.measure import measure
from limner.drawing.order import order
from limner.motion.cost import seconds as planned_seconds
from limner.motion.machine import load_machine
from limner.pipeline.settings import Settings
from limner.targets import svg
from limner.targets.files import check_format, to_bytes
from limner.types import Drawing, Face, Floats, Photo, Strokes
from limner.vision.likeness.candidates import Candidate
from limner.vision.likeness.model import shipped_likeness
from limner.vision.lines import draw_picture
from limner.vision.quality import photo_notes


@dataclass(frozen=True)
class Portrait:
    """What became of a photo, stage by stage.

    Attributes:
        photo: as loaded, upright.
        faces: all that were found, largest first.
        face: the one that was drawn, its landmarks refined.
        strokes: all that were seen [px].
        drawing: what is drawn of them, on the page [mm], in drawing order.
        page_from_photo: (2, 3) from pixels of the photo to SVG millimetres (y down).
        settings: in force.
        seconds: spent in each stage; next to none where its result was kept from the drawing before.
        candidates: of style ``auto``, what was drawn and judged; the settings name the style that was kept.
    """

    photo: Photo
    faces: tuple[Face, ...]
    face: Face
    strokes: Strokes
    drawing: Drawing
    page_from_photo: Floats
    settings: Settings
    seconds: dict[str, float]
    candidates: tuple[Candidate, ...] = ()

    @property
    def pen_px(self) -> float:
        """Width of the pen's line in the photo."""
        return self.drawing.pen.width_mm / float(self.page_from_photo[0, 0])

    def ink_px(self) -> tuple[Floats, ...]:
        """The lines of the drawing, in the pixels of the photo."""
        scale, height = self.page_from_photo[0, 0], self.drawing.page.height_mm
        return tuple(
            ([0, height] + line * [1, -1] - self.page_from_photo[:, 2]) / scale for line in self.drawing.lines_mm
        )

    @cached_property
    def likeness(self) -> float:
        """How much of the person is in the drawing, 0 to 1; computed when first asked for."""
        return shipped_likeness().likeness(self.photo, self.face, self.ink_px(), self.pen_px)

    @cached_property
    def photo_notes(self) -> tuple[str, ...]:
        """What is wrong with the photo and what helps, one line each; computed when first asked for."""
        return photo_notes(self.photo, self.face)

    def picture(self) -> NDArray[np.uint8]:
        """The photo as the style pictures it in colours: (H, W, 3) sRGB.

        Raises:
            BadInput: the style has no picture.
        """
        return draw_picture(self.photo, self.face, self.settings.style, self.settings)

    def svg(self) -> bytes:
        """The drawing as SVG, settings and version inside."""
        return svg.to_svg(self.drawing, self.about(), how=self.settings.svg)

    def about(self) -> dict[str, Any]:
        """How it was made, as its file says."""
        return {"limner": __version__, "settings": self.settings.to_dict()}

    def save(self, path: str | Path) -> None:
        """Write the drawing as the file's suffix says, one of ``FORMATS``.

        Raises:
            BadInput: another suffix, or the file cannot be written.
        """
        suffix = check_format(path)
        whole = self.svg() if suffix == ".svg" else to_bytes(self.drawing, suffix, self.about(), self.settings.gcode)
        storage.write_whole(path, whole)

    def report(self) -> dict[str, Any]:
        """What ``limner draw --json`` prints."""
        return {
            "faces": len(self.faces),
            "face": storage.to_fields(self.face),
            "style": self.settings.style,
            **dataclasses.asdict(measure(self.drawing)),
            "likeness": self.likeness,
            "photo_notes": list(self.photo_notes),
            "draw_s": planned_seconds(self.drawing, load_machine(self.settings.machine)),
            **self._price(),
            "candidates": [dataclasses.asdict(item) | {"worth": item.worth} for item in self.candidates],
            "page_from_photo": self.page_from_photo.tolist(),
            "seconds": self.seconds | {"total": sum(self.seconds.values())},
            "settings": self.settings.to_dict(),
        }

    def _price(self) -> dict[str, float]:
        """What an order for an audience costs: the travel that would do."""
        if self.settings.order.by != "audience":
            return {}
        shortest = order(self.drawing, self.settings.order.replace(by="travel"))
        return {"shortest_travel_mm": measure(shortest).travel_mm}
