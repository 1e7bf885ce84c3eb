"""A photo goes in as vpype's command ``limner``; the portrait's strokes come out as lines of a vpype layer."""

from __future__ import annotations

import click
import numpy as np
import vpype
import vpype_cli

from limner import pipeline
from limner.errors import LimnerError
from limner.pipeline import Settings
from limner.types import Drawing

_PX_PER_MM = 96 / 25.4  # vpype's unit is the CSS pixel


@click.command()
@click.argument("photo", type=vpype_cli.PathType(exists=True, dir_okay=False))
@click.option("--points", "-n", type=vpype_cli.IntegerType(), help="At most so many points.")
@click.option("--style", "-s", type=vpype_cli.TextType(), help="From photo to strokes: see `limner draw --help`.")
@click.option("--page", type=vpype_cli.TextType(), help="Paper: a4, a5, 120x160mm, a5:landscape, ... Default: a5.")
@click.option(
    "--set", "assignments", multiple=True, metavar="NAME=VALUE", help="Any other setting of limner; may be repeated."
)
@vpype_cli.generator
@vpype_cli.pass_state
def limner(
    state: vpype_cli.State,
    photo: str,
    points: int | None,
    style: str | None,
    page: str | None,
    assignments: tuple[str, ...],
) -> vpype.LineCollection:
    r"""Draw the person in PHOTO as ordered pen strokes.

    \b
    vpype limner me.jpg linemerge write out.svg
    """
    given = {"select.points": points, "style": style, "page.size": page}
    try:
        settings = Settings()
        for name, value in given.items():
            settings = settings if value is None else settings.assign(name, str(value))
        for name, _, text in (assignment.partition("=") for assignment in assignments):
            settings = settings.assign(name.strip(), text.strip())
        drawing = pipeline.draw(photo, settings).drawing
    except LimnerError as error:
        raise click.ClickException(f"limner: {error}") from error
    state.document.extend_page_size((drawing.page.width_mm * _PX_PER_MM, drawing.page.height_mm * _PX_PER_MM))
    return to_lines(drawing)


def to_lines(drawing: Drawing) -> vpype.LineCollection:
    """The strokes in vpype's frame: complex numbers of CSS pixels, y down; a dot is a line of no length."""
    lines = vpype.LineCollection()
    for line in drawing.lines_mm:
        points = line if len(line) > 1 else np.repeat(line, 2, axis=0)
        lines.append((points[:, 0] + 1j * (drawing.page.height_mm - points[:, 1])) * _PX_PER_MM)
    return lines
