"""A photo goes in as vpype's command ``limner``; its strokes come out as lines, a vpype layer for each pen."""

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
    r"""Draw the person in PHOTO as ordered pen strokes; the first pen's in the target layer, each other's in a new one.

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
    first, *others = drawing.by_pen() or [drawing]
    target = state.current_layer_id or 1
    for layer, part in enumerate(others, 1 + max([*state.document.ids(), target])):
        state.document.add(_inked(to_lines(part), part), layer, with_metadata=True)
    if others:
        # vpype takes the lines that are returned, but not what they look like.
        state.document.add(_inked(vpype.LineCollection(), first), target, with_metadata=True)
    return to_lines(first)


def _inked(lines: vpype.LineCollection, drawing: Drawing) -> vpype.LineCollection:
    """Lines with the colour, width and name of the pen that draws the first of a drawing."""
    pen = drawing.pens[int(drawing.layer[0])]
    lines.set_property(vpype.METADATA_FIELD_COLOR, vpype.Color(pen.hex))
    lines.set_property(vpype.METADATA_FIELD_PEN_WIDTH, pen.width_mm * _PX_PER_MM)
    lines.set_property(vpype.METADATA_FIELD_NAME, pen.name)
    return lines


def to_lines(drawing: Drawing) -> vpype.LineCollection:
    """The strokes in vpype's frame: complex numbers of CSS pixels, y down; a dot is a line of no length."""
    lines = vpype.LineCollection()
    for line in drawing.lines_mm:
        points = line if len(line) > 1 else np.repeat(line, 2, axis=0)
        lines.append((points[:, 0] + 1j * (drawing.page.height_mm - points[:, 1])) * _PX_PER_MM)
    return lines
