"""``limner train``: annotated photos in, a model out."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import click

from limner.cli import options
from limner.cli.progress import bars
from limner.vision.landmarks.fmp import scenes as fmp_scenes
from limner.vision.landmarks.fmp.dataset import Sample, read_folder
from limner.vision.landmarks.fmp.model import save_model
from limner.vision.landmarks.fmp.training import TrainSettings, train as train_fmp


@click.group(short_help="Train the models that limner ships.")
def train() -> None:
    """Train the models that limner ships."""


@train.command()
@click.option("--data", multiple=True, required=True, metavar="DIR", help="Annotated photos; may be repeated.")
@click.option("--scenes", multiple=True, metavar="DIR", help="Pictures without a face; may be repeated.")
@click.option("--out", "-o", required=True, metavar="FILE", help="Where to, an .npz.")
@click.option("--skip-bad", is_flag=True, help="Leave out, by name, faces that lack landmarks or a photo.")
@options.settings_options
@options.json_option
@click.pass_context
def fmp(
    ctx: click.Context,
    data: tuple[str, ...],
    scenes: tuple[str, ...],
    out: str,
    skip_bad: bool,
    save_settings: Path | None,
    as_json: bool,
) -> None:
    """Train a flexible mixture of parts (thesis 3.2.1, eq. 3.4 and 3.5) on annotated photos.

    Each --data folder holds landmarks.npz (names, size_wh, ibug68) and images/. Everything in the photos but the
    faces teaches the model what is none, as do --scenes, made-up textures, and scikit-image's pictures if installed.
    """
    settings = options.chosen_settings(ctx, TrainSettings, save_settings)
    options.check_suffix(out, ".npz")
    samples: list[Sample] = []
    for folder in data:
        read, left_out = read_folder(folder, skip=skip_bad)
        samples += read
        for line in left_out:
            click.echo(f"left out: {line}", err=True)
    pictures = fmp_scenes.of_samples(samples) + fmp_scenes.sample_pictures()
    pictures += fmp_scenes.textures(settings.textures, settings.seed)
    for folder in scenes:
        pictures += fmp_scenes.of_folder(folder)
    with bars() as watch:
        trained = train_fmp(samples, pictures, settings, watch)
    save_model(trained.model, out)
    rounds = [dataclasses.asdict(round_) for round_ in trained.rounds]
    if as_json:
        click.echo(json.dumps({"out": [out], "faces": len(samples), "scenes": len(pictures), "rounds": rounds}))
    else:
        click.echo(f"trained on {len(samples)} faces and {len(pictures)} scenes\n{out}", err=True)
