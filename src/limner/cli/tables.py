"""``limner evaluate tables`` and ``figures``: the thesis's tables and figures about landmarks, on anybody's photos."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Sequence
from pathlib import Path

import click
from rich.console import Console
from rich.table import Table

from limner import storage
from limner.cli import options
from limner.cli.progress import bars
from limner.evaluate.corrections import BestTraining, Truth, estimates, held_out, measure, read_truths
from limner.evaluate.detections import detections, detector_name, errors_of
from limner.evaluate.figures import figures as draw_figures
from limner.evaluate.tables import Grid, estimate_table, summary, tables as make_tables
from limner.pipeline import Settings, find_faces
from limner.targets.sheet import to_png
from limner.types import Face, Floats
from limner.vision.landmarks import choose
from limner.vision.landmarks.fmp.dataset import Sample, read_folder
from limner.vision.photo import load_photo
from limner.vision.refine.descent_training import DescentTrainSettings

Found = dict[str, list[Face | None]]


@click.command(short_help="The thesis's tables 3.1 to 3.4, ours beside theirs.")
@click.option("--data", multiple=True, required=True, metavar="DIR", help="Annotated photos; folders are one set.")
@click.option(
    "--detector",
    "detectors",
    multiple=True,
    default=("",),
    metavar="FILE",
    help="A face model that finds the landmarks, .npz or .mat; may be repeated. Default: the shipped one.",
)
@click.option("--cross-validate", is_flag=True, help="Measure `best` trained 5 times without the people measured.")
@click.option("--also", multiple=True, metavar="DIR", help="With --cross-validate: more photos to train `best` on.")
@click.option("--summary", "only_summary", is_flag=True, help="Only the summaries.")
@options.settings_options
@options.json_option
@click.pass_context
def tables(
    ctx: click.Context,
    data: tuple[str, ...],
    detectors: tuple[str, ...],
    cross_validate: bool,
    also: tuple[str, ...],
    only_summary: bool,
    save_settings: Path | None,
    as_json: bool,
) -> None:
    """The thesis's tables 3.1 to 3.4 from annotated photos, ours beside its figures, and a summary.

    Photos with all 68 landmarks are measured with shape models that never saw the person. Pixels are those of the
    photo, per cent those of the outer-eye distance.
    """
    settings = options.chosen_settings(ctx, Settings, save_settings)
    truths = [truth for folder in data for truth in read_truths(folder)]
    helpers = [sample for folder in also for sample in read_folder(folder)[0]]
    name = " + ".join(Path(folder).name for folder in data)
    whole = [truth.sample for truth in truths if truth.sample.known.all()]
    grids: list[Grid] = []
    with bars() as watch, tempfile.TemporaryDirectory() as folder:
        found = {model: detections([truth.sample for truth in truths], model, watch) for model in detectors}
        best = _best_training(truths, found) if cross_validate else None
        models = held_out(whole, helpers, Path(folder), best, watch) if len(whole) > 4 else {}
        for model, faces in found.items():
            measured = measure(truths, faces, settings.refinement, models)
            make = (lambda title, rows: [summary(title, rows)]) if only_summary else make_tables
            grids += make(f"{name}, {detector_name(model)} ({len(measured)} of {len(truths)} found)", measured)
    if len(whole) > 12 and not only_summary:
        grids.append(estimate_table(name, whole, *estimates(whole)))
    _show(grids, as_json)


def _best_training(truths: Sequence[Truth], found: Found) -> BestTraining:
    def habits(people: frozenset[str]) -> list[Floats]:
        errors = []
        for faces in found.values():
            kept = [(t.sample, f) for t, f in zip(truths, faces, strict=True) if t.sample.person not in people]
            samples: list[Sample] = [sample for sample, _ in kept]
            errors += errors_of(samples, [face for _, face in kept])
        return errors

    return BestTraining(DescentTrainSettings(), habits)


def _show(grids: list[Grid], as_json: bool) -> None:
    if as_json:
        click.echo(json.dumps({"tables": [grid.to_dict() for grid in grids]}))
        return
    console = Console(highlight=False)
    for grid in grids:
        table = Table(*grid.columns, title=grid.title, title_justify="left", caption=grid.note, caption_justify="left")
        for column in table.columns[1:]:
            column.justify = "right"
        for row in grid.rows:
            table.add_row(*row)
        console.print(table, "")


@click.command(short_help="The thesis's figures 3.1 to 3.14 of a photo.")
@click.argument("photos", metavar="PHOTO...", nargs=-1, required=True)
@click.option("--out", "-o", required=True, metavar="DIR", help="Folder for figure-3.1.png to figure-3.14.png.")
@options.settings_options
@options.json_option
@click.pass_context
def figures(ctx: click.Context, photos: tuple[str, ...], out: str, save_settings: Path | None, as_json: bool) -> None:
    """Draw the thesis's figures 3.1 to 3.14 (edges, landmarks, corrections, splines, trimming) from a few photos."""
    settings = options.chosen_settings(ctx, Settings, save_settings)
    pictures = [load_photo(path) for path in photos]
    faces = [choose(find_faces(photo, settings), 1, photo, settings.detect) for photo in pictures]
    folder = storage.make_folder(out)
    written = []
    for name, picture in draw_figures(pictures, faces, settings).items():
        written.append(str(folder / f"figure-{name}.png"))
        storage.write_whole(written[-1], to_png(picture))
    click.echo(json.dumps({"out": written}) if as_json else "\n".join(written), err=not as_json)
