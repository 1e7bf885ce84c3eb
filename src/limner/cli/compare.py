"""``limner compare``: a photo in, one sheet out with the photo, its landmarks and the drawing of every style."""

from __future__ import annotations

import json
from pathlib import Path

import click
import numpy as np
from numpy.typing import NDArray

from limner import pipeline, storage
from limner.cli import options
from limner.pipeline import STYLES, Portrait, Settings
from limner.targets import image
from limner.targets.overlay import overlay
from limner.targets.sheet import Tile, to_png, to_sheet
from limner.types import Face, Photo
from limner.vision.landmarks import choose
from limner.vision.photo import load_photo

TILE_PX = 960
"""Width of the close-up; a sheet shows it half as wide."""


@click.command(short_help="Draw a photo in every style, side by side on one sheet.")
@options.photo_options
@click.option("--out", "-o", metavar="FILE", help="Where to, a .png. Default: the photo's name with -styles.png.")
@options.drawing_options
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
    picture = load_photo(photo)
    part = pipeline.Part.of(picture, crop)
    face = choose(pipeline.find_faces(picture, settings, crop=crop), number or 1, part.photo, settings.detect)
    portraits = [pipeline.draw(picture, settings.replace(style=style), crop=crop, face=face) for style in STYLES]
    storage.write_whole(out, to_png(to_sheet(tiles(part.photo, portraits, part))))
    if as_json:
        click.echo(json.dumps({"out": [out], "styles": [portrait.report() for portrait in portraits]}))
    else:
        for portrait in portraits:
            click.echo(f"{portrait.settings.style}: {counts(portrait)}", err=True)
        click.echo(out, err=True)


def tiles(photo: Photo, portraits: list[Portrait], part: pipeline.Part) -> list[Tile]:
    """The photo, its landmarks, and each portrait with what it costs."""
    width, height = photo.size_px
    face = part.from_whole(portraits[0].face)
    landmarks = Tile(close_up(photo, face), "landmarks", f"{face.detector}, score {face.score:.2f}")
    drawn = [Tile(np.asarray(image.to_rgb(p.drawing)), p.settings.style, counts(p)) for p in portraits]
    return [Tile(photo.rgb, "photo", f"{width} x {height} px"), landmarks, *drawn]


def close_up(photo: Photo, face: Face) -> NDArray[np.uint8]:
    """The face with its landmarks, enlarged to the width of a tile."""
    x0, y0, x1, y1 = face.box_px
    around = np.array([[x0, y0], [x1, y1]]) + 0.25 * max(x1 - x0, y1 - y0) * np.array([[-1, -1], [1, 1]])
    (left, top), (right, bottom) = np.clip(np.rint(around), 0, photo.size_px).astype(int).tolist()
    near = pipeline.Part.of(photo, (left, top, right - left, bottom - top))
    return overlay(near.photo, [near.from_whole(face)], TILE_PX / (right - left))


def counts(portrait: Portrait) -> str:
    """Strokes, points and ink, in a few words."""
    report = portrait.report()
    return f"{report['strokes']} strokes, {report['points']} points, {report['ink_mm'] / 1000:.2f} m ink"
