"""``limner train``: annotated photos in, a model out."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import click
from rich.console import Console
from rich.table import Table

from limner.cli import options
from limner.cli.groups import Group
from limner.cli.progress import bars
from limner.cli.train_photos import best, likeness, shape
from limner.vision.landmarks.fmp import scenes as fmp_scenes
from limner.vision.landmarks.fmp.dataset import Sample, read_folder
from limner.vision.landmarks.fmp.examples import Share
from limner.vision.landmarks.fmp.matlab import import_matlab
from limner.vision.landmarks.fmp.model import save_model
from limner.vision.landmarks.fmp.training import TrainSettings, train as train_fmp


@click.group(cls=Group, short_help="Train the models that limner ships.")
def train() -> None:
    """Train the models that limner ships."""


@train.command(short_help="Train the face model (thesis 3.2.1).")
@click.option("--data", multiple=True, required=True, metavar="DIR", help="Annotated photos; may be repeated.")
@click.option("--scenes", multiple=True, metavar="DIR", help="Pictures without a face; may be repeated.")
@click.option("--out", "-o", required=True, metavar="FILE", help="Where to, an .npz.")
@click.option("--skip-bad", is_flag=True, help="Leave out, by name, faces that lack landmarks or a photo.")
@click.option(
    "--scheduler",
    metavar="ADDRESS",
    help="Compute features and search scenes on a Dask cluster that sees the same folders, such as tcp://host:8786.",
)
@options.settings_options
@options.json_option
@click.pass_context
def fmp(
    ctx: click.Context,
    data: tuple[str, ...],
    scenes: tuple[str, ...],
    out: str,
    skip_bad: bool,
    scheduler: str | None,
    save_settings: Path | None,
    as_json: bool,
) -> None:
    """Train a flexible mixture of parts (thesis 3.2.1, eq. 3.4 and 3.5) on annotated photos.

    A --data folder holds landmarks.npz (names, size_wh, ibug68) and images/; a file in it such as
    landmarks_smiling_machine.npz, with the photos in smiling/, may be named instead. Everything in the photos but the
    faces teaches the model what is none, as do --scenes, made-up textures, and scikit-image's pictures if installed.

    Machine-made landmarks (landmarks*_machine.npz) are taken from the face mesh (mp468) and checked: those of which
    the mesh was not sure, of faces turned by more than 30 degrees, and of small ones are named and left out.

    What each round reached is kept beside FILE: the same command goes on where an interrupted one stopped.
    """
    settings = options.chosen_settings(ctx, TrainSettings, save_settings)
    options.check_suffix(out, ".npz")
    samples = annotated(data, skip_bad)
    pictures = fmp_scenes.of_samples(samples) + fmp_scenes.sample_pictures()
    pictures += fmp_scenes.textures(settings.textures, settings.seed)
    for folder in scenes:
        pictures += fmp_scenes.of_folder(folder)
    state = Path(f"{out}.unfinished")
    with shared(scheduler) as share, bars() as watch:
        trained = train_fmp(samples, pictures, settings, watch, state, share)
    save_model(trained.model, out)
    state.unlink(missing_ok=True)
    rounds, curve = ([item.to_dict() for item in items] for items in (trained.rounds, trained.curve))
    for line in trained.left_out:
        click.echo(f"left out: {line}", err=True)
    if as_json:
        report = {"out": [out], "faces": len(samples) - len(trained.left_out), "scenes": len(pictures)}
        click.echo(
            json.dumps(report | {"threshold": trained.model.threshold, "rounds": rounds, "learning_curve": curve})
        )
    else:
        for title, rows in (("round", rounds), ("learning curve", curve)):
            if rows:
                Console(stderr=True, highlight=False).print(table(title, rows))
        click.echo(out, err=True)


@train.command("import", short_help="Turn a model of Zhu & Ramanan into one of ours.")
@click.argument("file", metavar="FILE.mat")
@click.option("--out", "-o", required=True, metavar="FILE", help="Where to, an .npz.")
@options.json_option
def import_model(file: str, out: str, as_json: bool) -> None:
    """Turn a model of Zhu & Ramanan's release (MATLAB) into one that needs no scipy.

    The result goes wherever a face model does: limner draw --model, limner face --model.
    """
    options.check_suffix(out, ".npz")
    model = import_matlab(file)
    save_model(model, out)
    parts = [len(component.parents) for component in model.components]
    if as_json:
        click.echo(json.dumps({"out": [out], "name": model.name, "views": len(parts), "parts": parts}))
    else:
        filters = f"{len(model.filters)} filters of {len(parts)} views with {min(parts)} to {max(parts)} parts"
        click.echo(f"{out}: {filters}", err=True)


@contextlib.contextmanager
def shared(scheduler: str | None) -> Iterator[Share]:
    """What does the work: this process, or a cluster."""
    if scheduler is None:
        yield map
        return
    from limner.batch.cluster import cluster_engine
    from limner.batch.engine import in_order

    with cluster_engine(scheduler) as engine:
        yield partial(in_order, engine)


def annotated(folders: tuple[str, ...], skip_bad: bool) -> list[Sample]:
    """The faces of all folders; those left out are named."""
    samples: list[Sample] = []
    for folder in folders:
        read, left_out = read_folder(folder, skip=skip_bad)
        samples += read
        for line in left_out:
            click.echo(f"left out: {line}", err=True)
    return samples


def table(title: str, rows: list[dict[str, Any]]) -> Table:
    """Figures by name, a line for each row."""
    flat = [figures | figures.get("solution", {}) for figures in rows]
    names = [name for name, value in flat[0].items() if isinstance(value, int | float)]
    lines = Table(title, *names, title_justify="left")
    for k, figures in enumerate(flat, 1):
        lines.add_row(str(k), *(f"{figures[name]:.6g}" for name in names))
    return lines


train.add_command(shape)
train.add_command(best)
train.add_command(likeness)
