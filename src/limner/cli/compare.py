"""``limner compare``: a photo in, one sheet out with the photo, its landmarks and the drawing of every style."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import click

from limner import pipeline, storage
from limner.cli import options
from limner.cli.progress import bars
from limner.cli.words import many
from limner.errors import CannotDraw
from limner.pipeline import Portrait, Settings
from limner.targets.framing import frame_face, frame_photo
from limner.targets.image import to_rgb
from limner.targets.overlay import overlay
from limner.targets.sheet import Tile, to_png, to_sheet
from limner.vision.lines import STYLES

PX_PER_MM = 6.0
"""Resolution of the tiles; a sheet shows an A5 page about half as large."""


@click.command(short_help="Draw a photo in every style, side by side on one sheet.")
@click.option("--out", "-o", metavar="FILE", help="Where to, a .png. Default: the photo's name with -styles.png.")
@options.drawing_options
@options.photo_options
@options.settings_options
@options.json_option
@click.pass_context
def compare(
    ctx: click.Context,
    photo: str,
    crop: tuple[int, int, int, int] | None,
    number: int | None,
    out: str | None,
    save_settings: Path | None,
    as_json: bool,
) -> None:
    """Draw PHOTO in every style, side by side on one sheet, to choose from (thesis 3.1.2).

    PHOTO is a JPEG, PNG, WebP or HEIC file, or - for standard input.
    """
    settings = options.chosen_settings(ctx, Settings, save_settings)
    out = out or f"{options.stem(photo)}-styles.png"
    options.check_suffix(out, ".png")
    session = pipeline.Session(photo)
    portraits, left_out = every_style(
        lambda of: session.draw(settings.replace(style=of), crop=crop, number=number or 1)
    )
    storage.write_whole(out, to_png(to_sheet(tiles(portraits), columns=5)))
    if as_json:
        styles = [portrait.report() for portrait in portraits]
        click.echo(json.dumps({"out": [out], "styles": styles, "left_out": left_out}))
    else:
        for portrait in portraits:
            click.echo(f"{portrait.settings.style}: {counts(portrait)}", err=True)
        for style, error in left_out.items():
            click.echo(f"{style}: left out: {error}", err=True)
        click.echo(out, err=True)


def every_style(draw: Callable[[str], Portrait]) -> tuple[list[Portrait], dict[str, str]]:
    """The portrait of each style that can be drawn, and why the others cannot.

    Raises:
        CannotDraw: none can.
    """
    portraits: list[Portrait] = []
    left_out: dict[str, str] = {}
    with bars() as watch:
        for done, style in enumerate(STYLES, 1):
            watch("styles", done - 1, len(STYLES), style)
            try:
                portraits.append(draw(style))
            except CannotDraw as error:
                if done == len(STYLES) and not portraits:
                    raise
                left_out[style] = str(error)
            watch("styles", done, len(STYLES), style)
    return portraits, left_out


def tiles(portraits: list[Portrait]) -> list[Tile]:
    """The photo as the page frames it, its landmarks, and each portrait with what it costs."""
    first = portraits[0]
    photo = frame_photo(first.photo, first.page_from_photo, first.drawing.page, PX_PER_MM)
    face = frame_face(first.face, first.page_from_photo, PX_PER_MM)
    width, height = first.photo.size_px
    return [
        Tile(photo.rgb, "photo", f"{width} x {height} px"),
        Tile(overlay(photo, [face]), "landmarks", f"{face.detector}, score {face.score:.2f}"),
        *(Tile(to_rgb(p.drawing, PX_PER_MM), p.settings.style, counts(p)) for p in portraits),
    ]


def counts(portrait: Portrait) -> str:
    """Strokes, points, ink and likeness, in a few words."""
    report = portrait.report()
    ink = f"{report['ink_mm'] / 1000:.2f} m ink"
    drawn = f"{many(report['strokes'], 'stroke')}, {many(report['points'], 'point')}"
    return f"{drawn}, {ink}, likeness {report['likeness']:.2f}"
