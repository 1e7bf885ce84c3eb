"""``limner evaluate gallery``: photos of faces in, one sheet of them beside their drawings out."""

from __future__ import annotations

import json
from pathlib import Path

import click

from limner import storage
from limner.cli import options
from limner.evaluate.gallery import columns, gallery as draw_gallery
from limner.pipeline import Settings
from limner.targets.image import encode_png, encode_webp
from limner.targets.sheet import Tile, to_sheet


@click.command(short_help="Draw photos in some styles, all on one sheet.")
@click.argument("photos", nargs=-1, required=True, metavar="PHOTO...")
@click.option(
    "--out",
    "-o",
    default="gallery.png",
    metavar="FILE",
    help="Where to, a .png or a .webp, which is smaller. Default: gallery.png.",
)
@click.option(
    "--styles",
    default="canny,gabor,portrait",
    metavar="NAMES",
    help="Joined by commas. Default: canny,gabor,portrait.",
)
@click.option("--pictures", is_flag=True, help="Show the picture in colours of a style that has one, too.")
@click.option("--across", type=click.IntRange(1, 20), default=2, metavar="N", help="Photos side by side. Default: 2.")
@click.option(
    "--width", type=click.IntRange(40, 2000), default=180, metavar="PX", help="Of a picture [px]. Default: 180."
)
@options.drawing_options
@options.settings_options
@options.json_option
@click.pass_context
def gallery(
    ctx: click.Context,
    photos: tuple[str, ...],
    out: str,
    styles: str,
    pictures: bool,
    across: int,
    width: int,
    save_settings: Path | None,
    as_json: bool,
) -> None:
    """Draw every PHOTO in some styles, each beside its photo on one sheet, to be judged by eye.

    The largest face of each photo is drawn, without a budget unless one is given.
    """
    settings = options.chosen_settings(ctx, Settings, save_settings)
    options.check_suffix(out, ".png", ".webp")
    names = [name.strip() for name in styles.split(",")]
    tiles: list[Tile] = []
    for path, row in zip(photos, draw_gallery(photos, names, settings, pictures=pictures), strict=True):
        tiles += row
        click.echo(f"{path}: {row[-1].title}: {row[-1].note}", err=True)
    sheet = to_sheet(tiles, columns=across * columns(names, pictures=pictures), tile_px=width)
    storage.write_whole(out, encode_webp(sheet) if out.lower().endswith(".webp") else encode_png(sheet))
    if as_json:
        click.echo(json.dumps({"out": [out], "photos": len(photos), "styles": names}))
    else:
        click.echo(out, err=True)
