"""``limner face``: a photo in, its faces and their landmarks out."""

from __future__ import annotations

import json
from pathlib import Path

import click

from limner import pipeline, storage
from limner.cli import options
from limner.cli.refinements import describe_refinement, refinement_sheet
from limner.pipeline import Settings
from limner.targets.overlay import overlay as draw_overlay
from limner.targets.sheet import to_png
from limner.types import Face
from limner.vision.landmarks import choose
from limner.vision.photo import load_photo
from limner.vision.refine import names_of


@click.command(short_help="Find the faces in a photo and their landmarks.")
@options.photo_options
@click.option("--out", "-o", metavar="FILE", help="Write the landmarks to a JSON file, which --landmarks reads.")
@click.option("--overlay", metavar="FILE", help="Write the photo with its landmarks drawn over it, as PNG.")
@options.flag("refine", "--refine", metavar="NAMES")
@click.option("--refine-compare", metavar="FILE", help="Write a sheet of the face after each correction, as PNG.")
@options.settings_options
@options.json_option
@click.pass_context
def face(
    ctx: click.Context,
    photo: str,
    crop: tuple[int, int, int, int] | None,
    number: int | None,
    out: str | None,
    overlay: str | None,
    refine_compare: str | None,
    save_settings: Path | None,
    as_json: bool,
) -> None:
    """Find the faces in PHOTO and their landmarks, largest first; with --face N that one alone.

    --refine-compare shows what each correction of the landmarks makes of the face, to choose from (thesis 3.3.6).

    PHOTO is a JPEG, PNG, WebP or HEIC file, or - for standard input.
    """
    settings = options.chosen_settings(ctx, Settings, save_settings)
    options.check_suffix(out, ".json")
    options.check_suffix(overlay, ".png")
    options.check_suffix(refine_compare, ".png")
    names_of(pipeline.refinements(settings))
    picture = load_photo(photo)
    part = pipeline.Part.of(picture, crop)
    faces = pipeline.find_faces(picture, settings, crop=crop)
    chosen = choose(faces, number or 1, part.photo, settings.detect)
    found = faces if number is None else (chosen,)
    shown = tuple(pipeline.refine_face(picture, item, settings) for item in found)
    fields = {"faces": [storage.to_fields(item) for item in shown]}
    if out:
        storage.write_whole(out, (json.dumps(fields) + "\n").encode())
    if overlay:
        storage.write_whole(overlay, to_png(draw_overlay(picture, shown)))
    if refine_compare:
        storage.write_whole(refine_compare, to_png(refinement_sheet(picture, chosen, settings)))
    if as_json:
        click.echo(json.dumps(fields))
    else:
        for i, item in enumerate(shown, 1):
            click.echo(describe(number or i, item), err=True)
            click.echo(describe_refinement(found[i - 1], item, settings), err=True)
        for path in filter(None, (out, overlay, refine_compare)):
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
