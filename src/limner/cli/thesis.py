"""``limner evaluate thesis``: the thesis followed chapter by chapter on anybody's photos, as one page."""

from __future__ import annotations

import json
from pathlib import Path

import click

from limner import storage
from limner.cli import options
from limner.cli.progress import bars
from limner.errors import BadInput
from limner.evaluate.thesis.page import to_html
from limner.evaluate.thesis.report import Sources, sections
from limner.evaluate.thesis.words import LEAD, TITLE
from limner.pipeline import Settings, find_faces
from limner.vision.landmarks import choose
from limner.vision.photo import load_photo

MOST_PHOTOS = 6


@click.command(short_help="The whole thesis on your photos, as one page.")
@click.argument("more", metavar="[PHOTO]...", nargs=-1)
@click.option("--photos", multiple=True, metavar="PHOTO", help="A portrait; may be repeated, or simply go on after it.")
@click.option("--imm", metavar="DIR", help="Folder of the IMM set (images/, landmarks.npz) for tables 3.1, 3.2, 3.4.")
@click.option("--data", metavar="DIR", help="Folder of photos with all 68 landmarks, for table 3.3.")
@click.option(
    "--model",
    "models",
    multiple=True,
    metavar="FILE",
    help="Another face model (.npz or .mat) to measure beside the shipped one; may be repeated.",
)
@click.option("--out", "-o", required=True, metavar="DIR", help="Folder for index.html, which needs no other file.")
@options.settings_options
@options.json_option
@click.pass_context
def thesis(
    ctx: click.Context,
    more: tuple[str, ...],
    photos: tuple[str, ...],
    imm: str | None,
    data: str | None,
    models: tuple[str, ...],
    out: str,
    save_settings: Path | None,
    as_json: bool,
) -> None:
    """Follow the thesis chapter by chapter on a few portraits, as one page.

    Its figures 3.1 to 3.14 and 4.2 to 4.5, tables 3.1 to 3.4 with ours beside its numbers, drawing times, what differs
    and why. Needs limner[robot] for the simulated arm; takes some minutes.
    """
    settings = options.chosen_settings(ctx, Settings, save_settings)
    named = (*photos, *more)
    if not 1 <= len(named) <= MOST_PHOTOS:
        raise BadInput(f"evaluate thesis: {len(named)} photos; give 1 to {MOST_PHOTOS} portraits")
    pictures = [load_photo(path) for path in named]
    faces = [choose(find_faces(photo, settings), 1, photo, settings.detect) for photo in pictures]
    page = storage.make_folder(out) / "index.html"
    with bars() as watch:
        made = sections(Sources(pictures, faces, imm or "", data or "", models), settings, watch)
    storage.write_whole(page, to_html(TITLE, LEAD, made))
    click.echo(json.dumps({"out": [str(page)]}) if as_json else str(page), err=not as_json)
