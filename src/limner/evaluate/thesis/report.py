"""Photos, faces and annotated sets in; the sections of the page that follows the thesis out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from limner.evaluate.corrections import estimates, measure, read_truths
from limner.evaluate.detections import detections, detector_name
from limner.evaluate.figures import figures
from limner.evaluate.tables import Grid, estimate_table, tables
from limner.evaluate.thesis import arm_figures
from limner.evaluate.thesis.page import Section
from limner.evaluate.thesis.trees import trees
from limner.evaluate.thesis.words import CHAPTERS, DIFFERENCES, FIGURES
from limner.motion.arm.robots import load_robot
from limner.pipeline import Session, Settings, refine_face
from limner.targets.image import to_rgb
from limner.targets.sheet import Tile, to_sheet
from limner.types import Face, Photo
from limner.vision.landmarks.fmp.dataset import read_folder
from limner.vision.landmarks.fmp.detector import model_of
from limner.vision.scale import to_working_scale

Rgb = NDArray[np.uint8]
Watch = Callable[[str, int, int, str], None]

_FEWEST_SHAPES = 12


@dataclass(frozen=True)
class Sources:
    """What the page is made from.

    Attributes:
        photos: a few, each with a frontal face.
        faces: those faces, as detected.
        imm: folder of the IMM set, or empty.
        shapes: folder of photos with all 68 landmarks, for table 3.3, or empty.
        models: files of other face models to measure beside the shipped one.
    """

    photos: Sequence[Photo]
    faces: Sequence[Face]
    imm: str = ""
    shapes: str = ""
    models: tuple[str, ...] = ()


def sections(sources: Sources, settings: Settings, watch: Watch) -> list[Section]:
    """The thesis's sections, figures and tables in order, ours in them.

    Raises:
        BadInput: a folder or a model cannot be read, or a face cannot be drawn.
        CannotDraw: the arm cannot draw one of the portraits.
        MissingExtra: a package of the extra ``robot`` is not installed.
    """
    watch("figures", 0, 3, "chapter 3")
    pictures: dict[str, Rgb] = figures(sources.photos, sources.faces, settings)
    pictures["3.4"] = to_sheet_of_trees(sources.models)
    watch("figures", 1, 3, "chapter 4")
    drawn, times = _chapter_4(sources, settings)
    watch("figures", 3, 3, "")
    pictures |= drawn
    grids = measured_tables(sources, settings, watch)
    return [
        *_chapter("3.1", ("3.1", "3.2", "3.3"), pictures, grids),
        *_chapter("3.2", ("3.4", "3.5"), pictures, grids),
        *_chapter("3.3", ("3.6", "3.7", "3.8", "3.9", "3.10", "3.11"), pictures, grids),
        *_tables(grids),
        *_chapter("3.5", ("3.12", "3.13", "3.14"), pictures, grids),
        *_chapter("4", ("4.2", "4.3", "4.4", "4.5"), pictures, grids),
        Section("4.4", "Drawing times", "An hour for 2500 points, 20 minutes for 600.", grids=(times,)),
        _beyond(sources, settings),
        Section("6", "What differs, and why", ours=" ".join(DIFFERENCES), chapter=True),
    ]


def to_sheet_of_trees(models: Sequence[str]) -> Rgb:
    """Figure 3.4: the trees of the shipped model and of others."""
    shown = [trees(model_of(name)) for name in ("", *models)]
    return shown[0] if len(shown) == 1 else to_sheet([Tile(one, "") for one in shown], columns=1, tile_px=1440)


def measured_tables(sources: Sources, settings: Settings, watch: Watch) -> dict[str, list[Grid]]:
    """Tables 3.1 to 3.4 by number, of every model; empty where the data were not given."""
    found: dict[str, list[Grid]] = {number: [] for number in ("3.1", "3.2", "3.3", "3.4")}
    if sources.imm:
        truths = read_truths(sources.imm)
        for model in ("", *sources.models):
            faces = detections([truth.sample for truth in truths], model, watch)
            measured = measure(truths, faces, settings.refinement, {})
            name = f"IMM, {detector_name(model)} ({len(measured)} of {len(truths)} found)"
            for grid in tables(name, measured) if measured else ():
                number = next((key for key in found if f"Table {key}" in grid.title), "3.4")
                found[number].append(grid)
    if sources.shapes:
        samples = [sample for sample in read_folder(sources.shapes)[0] if sample.known.all()]
        if len({sample.person for sample in samples}) > _FEWEST_SHAPES:
            errors, components = estimates(samples)
            found["3.3"].append(estimate_table("the annotated photos given", samples, errors, components))
    return found


def _tables(grids: dict[str, list[Grid]]) -> list[Section]:
    titles = {
        "3.1": "Brows, before and after correction",
        "3.2": "Eye corners",
        "3.3": "Estimates by principal components",
        "3.4": "The jaw",
    }
    missing = "Not measured: the annotated photos were not given (--imm; --data for table 3.3)."
    return [
        Section(f"Table {number}", title, ours="" if grids[number] else missing, grids=tuple(grids[number]))
        for number, title in titles.items()
    ]


def _chapter(
    number: str, shown: Sequence[str], pictures: dict[str, Rgb], grids: dict[str, list[Grid]]
) -> list[Section]:
    said = CHAPTERS[number]
    made = [Section(number, said.title, said.theirs, said.ours, chapter=True)]
    for name in shown:
        words = FIGURES[name]
        figure = ((pictures[name], f"Figure {name}. {words.title}."),)
        made.append(Section(f"Figure {name}", words.title, words.theirs, words.ours, figure))
    return made


def _chapter_4(sources: Sources, settings: Settings) -> tuple[dict[str, Rgb], Grid]:
    robot = load_robot("dumbo")
    photo = sources.photos[0]
    face = refine_face(photo, sources.faces[0], settings)
    view = to_working_scale(photo, face, settings.scale)
    points, timed = arm_figures.thinned_points(view, settings, robot)
    arm, start, more = arm_figures.drawn_by_the_arm(photo, face, settings, robot)
    pictures = {"4.2": start, "4.3": arm_figures.orders(view, settings), "4.4": points, "4.5": arm}
    return pictures, arm_figures.time_table([*timed, *more])


def _beyond(sources: Sources, settings: Settings) -> Section:
    """What limner draws of each photo by default."""
    tiles = []
    for photo, face in zip(sources.photos, sources.faces, strict=True):
        portrait = Session(photo).draw(settings, face=refine_face(photo, face, settings), points=600)
        note = f"{len(portrait.drawing.lines_mm)} strokes, likeness {portrait.likeness:.2f}"
        tiles.append(Tile(to_rgb(portrait.drawing, 6.0), f"{portrait.drawing.points} points", note))
    sheet = to_sheet(tiles, columns=min(3, len(tiles)), tile_px=520)
    words = "The same photos in the default style, with at most 600 points: what the thesis's future work asked for."
    return Section("5", "Where it led", ours=words, figures=((sheet, "The default style."),), chapter=True)
