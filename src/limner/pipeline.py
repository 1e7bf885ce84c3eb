"""A photo and settings go in, a portrait comes out: every stage in one readable function, every result kept."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from limner import __version__, storage, units
from limner.drawing.clean import CleanSettings, clean
from limner.drawing.compose import ComposeSettings, compose, fill_page, grown, page_from_photo
from limner.drawing.measure import measure
from limner.drawing.order import OrderSettings, order
from limner.drawing.select import CostModel, SelectSettings, select
from limner.drawing.thread import ThreadSettings, thread
from limner.drawing.within import Clock, made_within_time, within_time
from limner.errors import NothingToDraw
from limner.motion.arm.plan import ArmSettings
from limner.motion.cost import seconds as planned_seconds
from limner.motion.machine import load_machine
from limner.settings import SettingsGroup, group, setting
from limner.simulation.settings import SimulationSettings
from limner.stages import Stages
from limner.targets import svg
from limner.targets.ebb import EbbSettings
from limner.targets.files import FORMATS as FORMATS, check_format as check_format, to_bytes
from limner.targets.gcode import GcodeSettings
from limner.targets.rosbridge import RosbridgeSettings
from limner.targets.svg import SvgSettings
from limner.targets.urscript import UrSettings
from limner.types import Drawing, Face, Floats, Page, Pen, Photo, Strokes
from limner.vision.landmarks import DetectSettings, choose, detect
from limner.vision.likeness.candidates import AUTO, AUTO_STYLES, Candidate, best, candidate
from limner.vision.likeness.model import shipped_likeness
from limner.vision.lines import MEASURED, PICTURES as PICTURES, STYLES, LineSettings, draw_lines, draw_picture
from limner.vision.photo import Box, Source, crop_photo, load_photo
from limner.vision.quality import photo_notes
from limner.vision.refine import BEST, NONE, REFINEMENTS, RefineSettings, refine

_MOST_POINTS = 20_000
"""Of a drawing that is made to measure for a time."""


@dataclass(frozen=True)
class PageSettings(SettingsGroup):
    """The sheet and the pen."""

    size: str = setting("a5", "Paper: a4, a5, letter, 120x160mm, a5:landscape, ...")
    margin_mm: float = setting(10.0, "White on each side of the sheet", unit="mm", low=0)
    pen_mm: float = setting(0.5, "Width of the pen's line", unit="mm", low=0.01, high=50)

    def page(self) -> Page:
        """The sheet."""
        return units.parse_page(self.size, self.margin_mm)


@dataclass(frozen=True)
class Settings(LineSettings):
    """Everything that decides how a portrait looks, stage by stage."""

    style: str = setting(
        "portrait",
        f"From photo to strokes; {AUTO} = the best of {', '.join(AUTO_STYLES)} by likeness",
        choices=(*STYLES, AUTO),
    )
    detect: DetectSettings = group(DetectSettings)
    refine: str = setting(
        AUTO,
        f"Corrections of the landmarks, one after the other, joined by commas: {', '.join(REFINEMENTS)}; or none;"
        " auto = best, and none for landmarks from a file",
    )
    refinement: RefineSettings = group(RefineSettings)
    page: PageSettings = group(PageSettings)
    compose: ComposeSettings = group(ComposeSettings)
    clean: CleanSettings = group(CleanSettings)
    machine: str = setting("axidraw", "What draws, where minutes are given: a machine's name or its TOML file")
    select: SelectSettings = group(SelectSettings)
    thread: ThreadSettings = group(ThreadSettings)
    order: OrderSettings = group(OrderSettings)
    svg: SvgSettings = group(SvgSettings)
    gcode: GcodeSettings = group(GcodeSettings)
    ebb: EbbSettings = group(EbbSettings)
    arm: ArmSettings = group(ArmSettings)
    ur: UrSettings = group(UrSettings)
    rosbridge: RosbridgeSettings = group(RosbridgeSettings)
    simulation: SimulationSettings = group(SimulationSettings)


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


@dataclass(frozen=True)
class Part:
    """The part of a photo that is looked at.

    Attributes:
        photo: that part.
        offset_px: (2,) where its upper left pixel is in the whole photo.
    """

    photo: Photo
    offset_px: Floats

    @classmethod
    def of(cls, photo: Photo, crop: Box | None) -> Part:
        """The crop x, y, width, height [px] of a photo; all of it for None."""
        if crop is None:
            return cls(photo, np.zeros(2))
        return cls(crop_photo(photo, crop), np.array(crop[:2], dtype=np.float64))

    def from_whole(self, face: Face, sign: int = -1) -> Face:
        """A face of the whole photo, in the part."""
        by = sign * self.offset_px
        return dataclasses.replace(face, points_px=face.points_px + by, box_px=face.box_px + np.tile(by, 2))

    def to_whole(self, strokes: Strokes, photo: Photo) -> Strokes:
        """Strokes of the part, in the whole photo."""
        lines = tuple(line + self.offset_px for line in strokes.lines_px)
        return dataclasses.replace(strokes, lines_px=lines, size_px=photo.size_px)


def find_faces(photo: Photo, settings: Settings | None = None, *, crop: Box | None = None) -> tuple[Face, ...]:
    """All faces in a photo, largest first; none is no error.

    Args:
        photo: where to look.
        settings: those of ``detect`` are used.
        crop: x, y, width, height [px]: look only there; the faces are in the frame of the photo all the same.

    Raises:
        BadInput: the detector's model or file cannot be used, or the crop leaves the photo.
    """
    return _faces_in(photo, (settings or Settings()).detect, crop)


def _faces_in(photo: Photo, detection: DetectSettings, crop: Box | None) -> tuple[Face, ...]:
    part = Part.of(photo, crop)
    faces = detect(part.photo, detection)
    # A file holds faces of the whole photo, whatever part of it is looked at.
    return faces if detection.detector == "file" else tuple(part.from_whole(face, 1) for face in faces)


def refinements(settings: Settings) -> str:
    """The names of the corrections that the settings ask for."""
    if settings.refine != AUTO:
        return settings.refine
    # What stands in a file was placed by hand, or is refined already.
    return NONE if settings.detect.detector == "file" else BEST


def refine_face(photo: Photo, face: Face, settings: Settings | None = None) -> Face:
    """The face with better landmarks.

    Args:
        photo: the whole photo.
        face: found in it.
        settings: those of ``refine`` and ``refinement`` are used.

    Raises:
        BadInput: no such correction, a face of a few pixels, or one outside the photo.
    """
    settings = settings or Settings()
    return refine(photo, face, refinements(settings), settings.refinement)


class Session:
    """A photo, drawn as often as one likes: a changed setting costs only what follows it.

    It keeps the photo and the last result of each stage. Files that settings name (landmarks, models) count as the
    same while their names are. One drawing at a time.
    """

    def __init__(self, source: Source | Photo, keep: int = 1, before: Callable[[], None] = lambda: None) -> None:
        """Take a photo; it is read for the first drawing.

        Args:
            source: a photo, or anything ``load_photo`` reads.
            keep: how many results of each stage are held, the latest.
            before: called before each stage; what it raises ends the drawing there.
        """
        self._source = source
        self._stages = Stages(keep, before)

    def draw(
        self,
        settings: Settings | None = None,
        *,
        crop: Box | None = None,
        number: int = 1,
        face: Face | None = None,
        **changes: Any,
    ) -> Portrait:
        """Draw the person: arguments, result and errors are those of ``limner.draw``."""
        settings = changed(settings or Settings(), changes)
        if settings.style == AUTO:
            return self._draw_best(settings, crop, number, face)
        stages = self._stages
        photo = stages("photo", _loaded, self._source)
        part = stages("crop", Part.of, photo, crop)
        faces = (face,) if face else stages("face", _faces_in, photo, settings.detect, crop)
        chosen = choose(faces, number, part.photo, settings.detect)
        if not face:
            chosen = stages("refine", refine, photo, chosen, refinements(settings), settings.refinement)
        page, pen = settings.page.page(), Pen(settings.page.pen_mm)
        if settings.style in MEASURED:
            drawing, strokes = self._made_to_measure(part, photo, part.from_whole(chosen), settings)
            affine = page_from_photo(strokes, page, settings.compose, pen)
            return Portrait(photo, faces, chosen, strokes, drawing, affine, settings, stages.take_seconds())
        strokes = draw_lines(part.photo, part.from_whole(chosen), settings.style, settings, stages)
        strokes = part.to_whole(strokes, photo)
        placed = stages("compose", compose, strokes, page, settings.compose, pen)
        cleaned = stages("clean", clean, placed, settings.clean)
        if settings.select.minutes is None:
            selected = stages("select", select, cleaned, settings.select)
            drawing, growth = stages("order", _finished, selected, settings.compose, settings.order)
        else:
            budget = (settings.machine, settings.select, settings.compose, settings.order)
            drawing, growth = stages("order", _timed, cleaned, *budget)
        affine = grown(page_from_photo(strokes, page, settings.compose, pen), growth, page)
        return Portrait(photo, faces, chosen, strokes, drawing, affine, settings, stages.take_seconds())

    def _made_to_measure(self, part: Part, photo: Photo, face: Face, settings: Settings) -> tuple[Drawing, Strokes]:
        """A drawing of a style that is made for its budget, and what was seen for it; the face is the part's."""
        budget, style, stages = settings.select, settings.style, self._stages
        page, pen = settings.page.page(), Pen(settings.page.pen_mm)
        joined = style == "one-line"

        def make(points: int) -> tuple[Drawing, Strokes]:
            count = points // settings.thread.points_per_dot if joined else points
            sized = settings.with_points(style, max(1, count))
            strokes = part.to_whole(draw_lines(part.photo, face, style, sized, stages), photo)
            placed = stages("compose", compose, strokes, page, settings.compose, pen)
            if joined:
                placed = stages("thread", thread, placed, settings.thread)
            return stages("order", order, placed, settings.order), strokes

        usual = settings.of_style(style).points
        if budget.minutes is None:
            return make(budget.points or usual)
        # Few points tell what one costs as well as many do.
        most, few = budget.points or _MOST_POINTS, usual // 3
        return made_within_time(make, few, most, 60 * budget.minutes, _clock(settings.machine))

    def _draw_best(self, settings: Settings, crop: Box | None, number: int, face: Face | None) -> Portrait:
        """Draw in each of ``AUTO_STYLES`` within the budget, and keep the best; a style that draws nothing is out."""
        portraits, nothing = [], None
        for style in AUTO_STYLES:
            try:
                portraits.append(self.draw(settings.replace(style=style), crop=crop, number=number, face=face))
            except NothingToDraw as error:
                nothing = error
        if not portraits:
            raise nothing or NothingToDraw("no style drew anything")
        seen = [candidate(p.settings.style, p.likeness, p.ink_px(), p.drawing.region, p.face) for p in portraits]
        names = dict.fromkeys(name for portrait in portraits for name in portrait.seconds)
        seconds = {name: sum(portrait.seconds.get(name, 0.0) for portrait in portraits) for name in names}
        return dataclasses.replace(portraits[best(seen)], seconds=seconds, candidates=tuple(seen))


def draw(
    source: Source | Photo,
    settings: Settings | None = None,
    *,
    crop: Box | None = None,
    number: int = 1,
    face: Face | None = None,
    **changes: Any,
) -> Portrait:
    """Draw the person in a photo, once; a ``Session`` draws it again and again.

    Args:
        source: a photo, or anything ``load_photo`` reads.
        settings: of every stage.
        crop: x, y, width, height [px]: look and draw only there.
        number: which face, 1 = the largest.
        face: draw this one as it is, in the photo's pixels before the crop, instead of looking for one.
        changes: single settings by name, dots as double underscores: ``style="canny"``, ``points=600``,
            ``gabor__orientations=4``; ``points``, ``minutes`` and ``page`` are short for ``select.points``,
            ``select.minutes`` and ``page.size``.

    Raises:
        BadInput: the photo cannot be read, or a setting is outside its limits.
        NoFace: there is no such face.
        NothingToDraw: no line was found.
    """
    return Session(source).draw(settings, crop=crop, number=number, face=face, **changes)


def changed(settings: Settings, changes: dict[str, Any]) -> Settings:
    """Settings with some changed by name, as ``draw`` takes them."""
    short = {"points": "select.points", "minutes": "select.minutes", "page": "page.size"}
    for name, value in changes.items():
        settings = settings.assign(short.get(name, name.replace("__", ".")), str(value))
    return settings


def _finished(drawing: Drawing, placing: ComposeSettings, ordering: OrderSettings) -> tuple[Drawing, Floats]:
    """The drawing as it fills the page and is drawn, and the map of the page that enlarged it."""
    filling, growth = fill_page(drawing, placing)
    return order(filling, ordering), growth


def _timed(
    drawing: Drawing, machine: str, choosing: SelectSettings, placing: ComposeSettings, ordering: OrderSettings
) -> tuple[Drawing, Floats]:
    """So much of the drawing as the machine draws in the minutes it has, finished."""
    return within_time(drawing, choosing, _clock(machine), partial(_finished, placing=placing, ordering=ordering))


def _clock(machine: str) -> Clock:
    mover = load_machine(machine)
    cost = CostModel(**dataclasses.asdict(mover.cost_model()))
    return Clock(partial(planned_seconds, machine=mover), cost, mover.name)


def _loaded(source: Source | Photo) -> Photo:
    return source if isinstance(source, Photo) else load_photo(source)
