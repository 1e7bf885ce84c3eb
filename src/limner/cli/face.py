"""``limner face``: a photo in, its faces and their landmarks out."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import click

from limner import pipeline, storage
from limner.cli import options
from limner.cli.gathered import gathered
from limner.cli.refinements import describe_refinement, refinement_sheet
from limner.pipeline import Settings
from limner.targets.overlay import overlay as draw_overlay
from limner.targets.sheet import to_png
from limner.types import Face
from limner.vision.landmarks import choose
from limner.vision.photo import load_photo
from limner.vision.refine import names_of


@dataclass(frozen=True)
class FaceWish:
    """Which photo is looked at, and what is written of its faces.

    Attributes:
        photo: file, or ``-``.
        crop: x, y, width, height [px] of the part that is looked at; None: all.
        number: the only face that is wanted, 1 = the largest; None: all.
        out: file for the landmarks, or None.
        overlay: file for the photo with the landmarks over it, or None.
        refine_compare: file for the face after each correction, or None.
        as_json: whether the landmarks are printed as JSON.
    """

    photo: str
    crop: tuple[int, int, int, int] | None
    number: int | None
    out: str | None
    overlay: str | None
    refine_compare: str | None
    as_json: bool


@click.command(short_help="Find the faces in a photo and their landmarks.")
@options.photo_options
@click.option("--out", "-o", metavar="FILE", help="Write the landmarks to a JSON file, which --landmarks reads.")
@click.option("--overlay", metavar="FILE", help="Write the photo with its landmarks drawn over it, as PNG.")
@options.flag("refine", "--refine", metavar="NAMES")
@click.option("--refine-compare", metavar="FILE", help="Write a sheet of the face after each correction, as PNG.")
@options.settings_options
@options.json_option
@click.pass_context
@gathered(FaceWish)
def face(ctx: click.Context, wish: FaceWish, save_settings: Path | None) -> None:
    """Find the faces in PHOTO and their landmarks, largest first; with --face N that one alone.

    --refine-compare shows what each correction of the landmarks makes of the face, to choose from (thesis 3.3.6).

    PHOTO is a JPEG, PNG, WebP or HEIC file, or - for standard input.
    """
    settings = options.chosen_settings(ctx, Settings, save_settings)
    options.check_suffix(wish.out, ".json")
    options.check_suffix(wish.overlay, ".png")
    options.check_suffix(wish.refine_compare, ".png")
    names_of(pipeline.refinements(settings))
    picture = load_photo(wish.photo)
    part = pipeline.Part.of(picture, wish.crop)
    faces = pipeline.find_faces(picture, settings, crop=wish.crop)
    chosen = choose(faces, wish.number or 1, part.photo, settings.detect)
    found = faces if wish.number is None else (chosen,)
    shown = tuple(pipeline.refine_face(picture, item, settings) for item in found)
    fields = json.dumps({"faces": [storage.to_fields(item) for item in shown]})
    if wish.out:
        storage.write_whole(wish.out, (fields + "\n").encode())
    if wish.overlay:
        storage.write_whole(wish.overlay, to_png(draw_overlay(picture, shown)))
    if wish.refine_compare:
        storage.write_whole(wish.refine_compare, to_png(refinement_sheet(picture, chosen, settings)))
    if wish.as_json:
        click.echo(fields)
        return
    for i, (before, after) in enumerate(zip(found, shown, strict=True), wish.number or 1):
        click.echo(describe(i, after), err=True)
        click.echo(describe_refinement(before, after, settings), err=True)
    for path in filter(None, (wish.out, wish.overlay, wish.refine_compare)):
        click.echo(path, err=True)


def describe(number: int, face: Face) -> str:
    """One line about a face."""
    x0, y0, x1, y1 = face.box_px
    where = f"{x1 - x0:.0f} x {y1 - y0:.0f} px at ({x0:.0f}, {y0:.0f})"
    parts = [
        f"face {number}: {len(face.points_px)} landmarks within {where}",
        f"turned {face.yaw_deg:+.0f} deg",
        f"score {face.score:.2f} ({face.detector})",
    ]
    if not face.frontal:
        parts.append("a profile: a drawing needs the 68 landmarks of a frontal face")
    return ", ".join(parts)
