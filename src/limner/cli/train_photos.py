"""``limner train shape | best | likeness``: annotated photos in, models of shape, refinement and likeness out."""

from __future__ import annotations

import json
from pathlib import Path

import click

from limner.cli import options
from limner.cli.progress import bars
from limner.evaluate.detections import detections, errors_of
from limner.evaluate.likeness import read_people
from limner.evaluate.likeness_training import train_likeness
from limner.vision.landmarks.fmp.dataset import Sample, read_folder
from limner.vision.likeness.model import save_likeness
from limner.vision.refine.descent import save_descent
from limner.vision.refine.descent_training import DescentTrainSettings, train_best
from limner.vision.refine.shape import save_shape, train_shape

_DATA_HELP = "Annotated photos: a folder, or the very landmarks*.npz in it; may be repeated."


@click.command(short_help="Train the principal components of face shapes (thesis 3.3.6).")
@click.option("--data", multiple=True, required=True, metavar="DIR", help=_DATA_HELP)
@click.option("--out", "-o", required=True, metavar="FILE", help="Where to, an .npz.")
@options.json_option
def shape(data: tuple[str, ...], out: str, as_json: bool) -> None:
    """Train the principal components of face shapes (thesis 3.3.6), for the correction `shape`.

    Faces without all 68 landmarks are left out; each is also learnt in the mirror.
    """
    options.check_suffix(out, ".npz")
    faces = [sample.points_px for sample in _read(data) if sample.known.all()]
    model = train_shape(faces)
    save_shape(model, out)
    count = model.components_for(0.99)
    if as_json:
        click.echo(json.dumps({"out": [out], "faces": len(faces), "components_for_99_percent": count}))
    else:
        click.echo(f"trained on {len(faces)} faces; {count} components hold 99 % of the variance\n{out}", err=True)


@click.command(short_help="Train the correction `best`, a learnt cascade.")
@click.option("--data", multiple=True, required=True, metavar="DIR", help=_DATA_HELP)
@click.option(
    "--detector",
    "detectors",
    multiple=True,
    metavar="FILE",
    help="A face model (.npz or .mat, '' for the shipped one) whose errors on the photos it shall learn to correct.",
)
@click.option("--out", "-o", required=True, metavar="FILE", help="Where to, an .npz.")
@options.settings_options
@options.json_option
@click.pass_context
def best(
    ctx: click.Context,
    data: tuple[str, ...],
    detectors: tuple[str, ...],
    out: str,
    save_settings: Path | None,
    as_json: bool,
) -> None:
    """Train the cascade of the correction `best` (supervised descent) on annotated photos.

    Of photos annotated by a machine (landmarks*_machine.npz) the machine's constant offsets are taken out.
    """
    settings = options.chosen_settings(ctx, DescentTrainSettings, save_settings)
    options.check_suffix(out, ".npz")
    samples = _read(data)
    hand = [sample for sample in samples if not sample.machine]
    with bars() as watch:
        habits = [error for model in detectors for error in errors_of(hand, detections(hand, model, watch))]
        save_descent(train_best(samples, settings, watch, habits), out)
    if as_json:
        click.echo(json.dumps({"out": [out], "faces": len(samples), "habits": len(habits)}))
    else:
        click.echo(f"trained on {len(samples)} faces and {len(habits)} detections\n{out}", err=True)


@click.command(short_help="Train what scores how much of a person is in a drawing.")
@click.option("--data", required=True, metavar="DIR", help="People in two photos each, as `limner evaluate likeness`.")
@click.option("--gallery", multiple=True, metavar="DIR", help="Annotated photos of other people; may be repeated.")
@click.option("--out", "-o", required=True, metavar="FILE", help="Where to, an .npz.")
@options.json_option
def likeness(data: str, gallery: tuple[str, ...], out: str, as_json: bool) -> None:
    """Train what scores how much of a person is in a drawing: linear discriminants of photos and drawings of people.

    Everybody is drawn in four ways. No photo is kept in the model, only some numbers of each face.
    """
    options.check_suffix(out, ".npz")
    people, others = read_people(data), _read(gallery)
    with bars() as watch:
        save_likeness(train_likeness(people, others, watch), out)
    if as_json:
        click.echo(json.dumps({"out": [out], "people": len(people), "gallery": len(people) + len(others)}))
    else:
        click.echo(f"trained on {len(people)} people; {len(people) + len(others)} in the gallery\n{out}", err=True)


def _read(data: tuple[str, ...]) -> list[Sample]:
    return [sample for folder in data for sample in read_folder(folder)[0]]
