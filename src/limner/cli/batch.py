"""``limner batch``: many photos in; a drawing of each, a manifest and a contact sheet out."""

from __future__ import annotations

import contextlib
import json
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import click

from limner import storage
from limner.batch import manifest, remote
from limner.batch.cluster import cluster_engine
from limner.batch.engine import Engine, local_engine
from limner.batch.everything import Total, Watch, draw_batch
from limner.batch.listing import STDIN, check_words, photos_of
from limner.batch.run import Order
from limner.batch.summary import Summary
from limner.batch.work import TRAJECTORY, Recipe
from limner.cli import options
from limner.cli.gathered import gathered
from limner.cli.progress import bars
from limner.cli.words import many
from limner.errors import BadInput
from limner.motion.arm.robots import ROBOTS, load_robot
from limner.pipeline import FORMATS, Settings, without_effect
from limner.vision.landmarks.fmp.threads import cores

ALSO = (*(suffix[1:] for suffix in FORMATS if suffix != ".svg"), TRAJECTORY)


@dataclass(frozen=True)
class BatchWish:
    """What is drawn, where, and what is written of it; the help of the options says more.

    Attributes:
        photos: files, folders, patterns, lists, URLs, or ``-``.
        out: folder for the drawings, the manifest and the sheet.
        also: formats beside SVG.
        robot: whose trajectory; None: Dumbo's.
        workers: processes; None: one for each core.
        scheduler: address of a Dask cluster, or None.
        send: whether photos and drawings go over the network.
        store: URL for the drawings, or None.
        sidecars: whether faces are taken from files beside the photos.
        parquet: whether the manifest is written as Parquet, too.
        sheet: photos on the contact sheet.
        as_json: whether the report is printed as JSON.
    """

    photos: tuple[str, ...]
    out: str
    also: tuple[str, ...]
    robot: str | None
    workers: int | None
    scheduler: str | None
    send: bool
    store: str | None
    sidecars: bool
    parquet: bool
    sheet: int
    as_json: bool


@click.command(short_help="Draw many photos, on this machine or on a cluster.")
@click.argument("photos", nargs=-1, metavar="PHOTOS...")
@click.option("--out", "-o", required=True, metavar="DIR", help="Folder for drawings, manifest and contact sheet.")
@click.option("--also", multiple=True, type=click.Choice(ALSO), help="Beside SVG; may be repeated.")
@click.option(
    "--robot", metavar="NAME", help=f"Whose trajectory: {', '.join(ROBOTS)}, or a URDF of your own. Default: dumbo."
)
@click.option("--workers", type=click.IntRange(1, 1024), metavar="N", help="Processes. Default: one for each core.")
@click.option("--scheduler", metavar="ADDRESS", help="Draw on a Dask cluster instead, such as tcp://host:8786.")
@click.option(
    "--send",
    is_flag=True,
    help="With --scheduler: photos are sent along and drawings come back, for workers that do not see these folders.",
)
@click.option("--store", metavar="URL", help="Put the drawings there instead, such as s3://bucket/drawings.")
@click.option("--sidecars", is_flag=True, help="Take faces from files beside the photos (.pts, .json, .csv), if any.")
@click.option("--parquet", is_flag=True, help="Write the manifest as Parquet too.")
@click.option(
    "--sheet",
    type=click.IntRange(0, 5000),
    default=300,
    metavar="N",
    help="Photos on the contact sheet, the first; 0 = no sheet. Default: 300.",
)
@options.flag("style", "--style", "-s", metavar="STYLE")
@options.flag("tone.level", "--tone", metavar="LEVEL")
@options.flag("detect.detector", "--detector", metavar="NAME")
@options.drawing_options
@options.settings_options
@options.json_option
@click.pass_context
@gathered(BatchWish)
def batch(ctx: click.Context, wish: BatchWish, save_settings: Path | None) -> None:
    """Draw every photo of PHOTOS: files, folders, patterns ('*.jpg'), lists (.txt, .csv), URLs, or - for stdin.

    A photo that cannot be drawn is a row of the manifest with its error. The same command again draws only what is
    missing or was changed; photos of one content are drawn once. Names of drawings end in the beginning of a hash,
    so that no two meet. Ctrl-C keeps what is done.
    """
    settings = options.chosen_settings(ctx, Settings, save_settings)
    for note in without_effect(settings.style, settings):
        click.echo(f"note: {note}", err=True)
    check_words(wish.photos)
    _check(wish)
    folder = storage.make_folder(wish.out).absolute()
    place = wish.store.rstrip("/") if wish.store else str(folder)
    recipe = Recipe(settings, ("svg", *dict.fromkeys(wish.also)), wish.robot or "dumbo", None if wish.send else place)
    order = Order(recipe, folder, place, wish.send, wish.sidecars, wish.sheet)
    summary = Summary(wish.sheet)
    names = photos_of(wish.photos, sys.stdin.buffer, folder)
    try:
        with _engine(wish.scheduler, wish.workers) as engine, _watched(wish.photos, folder) as watch:
            made = draw_batch(names, engine, order, summary, watch, wish.parquet)
    except KeyboardInterrupt:
        click.echo(f"{_short(summary)}; the same command goes on from here", err=True)
        raise
    except BadInput as error:
        if not summary.photos:
            raise
        raise BadInput(f"{error}; {summary.photos} photos are done, the same command goes on from there") from error
    if wish.as_json:
        report = summary.report() | {"out": [*map(str, made)], "drawings": place, "settings": settings.to_dict()}
        click.echo(json.dumps(report))
    else:
        click.echo("\n".join([_short(summary), *_told(summary), *map(str, made)]), err=True)


def _check(wish: BatchWish) -> None:
    """Options that do not go together, or need what is not installed, before any work."""
    if wish.scheduler and wish.workers:
        raise BadInput("--workers is for this machine, and --scheduler has workers of its own; choose one")
    if wish.send and not wish.scheduler:
        raise BadInput("--send is for --scheduler; on this machine workers see the same files")
    if wish.robot and TRAJECTORY not in wish.also:
        raise BadInput(f"--robot is for --also {TRAJECTORY}; add that")
    if wish.store and not remote.is_url(wish.store):
        raise BadInput(f"--store {wish.store}: not an URL; for a folder name it with --out")
    if wish.parquet:
        manifest.check_parquet()
    if TRAJECTORY in wish.also:
        load_robot(wish.robot or "dumbo")


@contextlib.contextmanager
def _engine(scheduler: str | None, workers: int | None) -> Iterator[Engine]:
    with cluster_engine(scheduler) if scheduler else local_engine(workers or cores()) as engine:
        yield engine


@contextlib.contextmanager
def _watched(photos: tuple[str, ...], folder: Path) -> Iterator[Watch]:
    total = Total()
    # What comes on stdin cannot be counted beforehand.
    if STDIN not in photos:
        total.begin(photos_of(photos, sys.stdin.buffer, folder))
    with bars() as tell:

        def watch(summary: Summary) -> None:
            count = max(total.count, summary.photos + (not total.known))
            failed = f", {summary.failed} failed" if summary.failed else ""
            tell("photos", summary.photos, count, f"{summary.per_minute():.0f}/min{failed}")

        yield watch


def _short(summary: Summary) -> str:
    kept = f", {summary.kept} drawn already" if summary.kept else ""
    failed = f", {summary.failed} could not be" if summary.failed else ""
    rate = f" ({summary.per_minute():.0f} a minute)" if summary.drawn else ""
    return f"{many(summary.photos, 'photo')}: {summary.drawn} drawn{kept}{failed}, in {summary.seconds():.1f} s{rate}"


def _told(summary: Summary) -> list[str]:
    return [f"{count} x {kind}" for kind, count in summary.errors.most_common(5)]
