"""``limner evaluate likeness``: people in two photos each in, how surely drawings of every style find them, out."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import click
from rich.console import Console
from rich.table import Table

from limner import storage
from limner.cli import options
from limner.cli.progress import bars
from limner.errors import BadInput
from limner.evaluate.likeness import ALL, Figure, Found, evaluate_likeness, read_people, to_dict
from limner.pipeline import Settings
from limner.vision.lines import STYLES

POINTS = (150, 300, 600, 1200)


@click.command(short_help="Measure how well drawings are recognised.")
@click.argument("folder", metavar="FOLDER")
@click.option("--styles", metavar="NAMES", help=f"Joined by commas, of {', '.join(STYLES)}. Default: all.")
@click.option(
    "--points",
    default=",".join(map(str, POINTS)),
    metavar="N,N",
    help=f"Budgets [points]. Default: {','.join(map(str, POINTS))}.",
)
@click.option("--people", type=click.IntRange(10), metavar="N", help="Only so many people, chosen by the seed.")
@click.option("--seed", type=click.IntRange(0), default=0, metavar="N", help="Of folds and choices. Default: 0.")
@click.option("--table", metavar="FILE", help="Also write the rows as .csv.")
@options.settings_options
@options.json_option
@click.pass_context
def likeness(
    ctx: click.Context,
    folder: str,
    styles: str | None,
    points: str,
    people: int | None,
    seed: int,
    table: str | None,
    save_settings: Path | None,
    as_json: bool,
) -> None:
    """Measure how well drawings are recognised: one photo of each person is drawn, another one is to be found.

    FOLDER has images/ and smiling/ with landmarks.npz and landmarks_smiling_machine.npz, as the London set, and
    perhaps info.csv (face_id, face_eth). The neutral photo is drawn with the given landmarks, in every style and
    budget, and matched with the smiling photos of everybody: rank-1 and rank-5 are how often the right one is the
    nearest or among the nearest five, MRR is the mean of 1 / rank. What tells people apart is learnt from the others,
    in five folds. Intervals hold 95 % of a bootstrap over people.
    """
    settings = options.chosen_settings(ctx, Settings, save_settings)
    chosen, budgets = _styles(styles), _budgets(points)
    options.check_suffix(table, ".csv")
    everybody = read_people(folder, people, seed)
    with bars() as watch:
        rows = evaluate_likeness(everybody, chosen, budgets, settings, watch, seed)
    if table is not None:
        storage.write_whole(table, to_csv(rows).encode())
    if as_json:
        click.echo(json.dumps({"people": len(everybody), "rows": [to_dict(row) for row in rows]}))
    else:
        Console(highlight=False).print(likeness_table(rows))


def likeness_table(rows: Sequence[Found]) -> Table:
    """A row for each style, budget and group."""
    title = f"Drawings of {rows[0].people} people, found among another photo of each"
    table = Table("style", "points", "drawn", "people", "", "rank-1 %", "rank-5 %", "MRR", title=title)
    table.title_justify = "left"
    for column in table.columns[5:]:
        column.justify = "right"
    for row in rows:
        first = row.group == ALL
        table.add_row(
            row.style if first else "",
            str(row.points or "") if first else "",
            f"{row.drawn_points:.0f}" if row.points and first else "",
            str(row.people),
            row.group,
            _cell(row.rank_1, 0),
            _cell(row.rank_5, 0),
            _cell(row.mrr, 2),
        )
    return table


def _cell(figure: Figure, digits: int) -> str:
    return f"{figure.value:.{digits}f} ({figure.low:.{digits}f}..{figure.high:.{digits}f})"


def to_csv(rows: Sequence[Found]) -> str:
    """The rows as comma-separated values, intervals as two columns."""
    heads = [
        *("style", "points", "group", "people", "drawn_points", "rank_1", "rank_1_low", "rank_1_high"),
        *("rank_5", "rank_5_low", "rank_5_high", "mrr", "mrr_low", "mrr_high"),
    ]
    lines = [",".join(heads)]
    for row in rows:
        figures = [row.drawn_points, *row.rank_1, *row.rank_5, *row.mrr]
        lines.append(",".join([row.style, str(row.points), row.group, str(row.people), *(f"{x:.6g}" for x in figures)]))
    return "\n".join(lines) + "\n"


def _styles(names: str | None) -> list[str]:
    chosen = [name.strip() for name in names.split(",")] if names else list(STYLES)
    for name in chosen:
        if name not in STYLES:
            raise BadInput(f"--styles: '{name}' does not exist; choose from {', '.join(STYLES)}")
    return chosen


def _budgets(text: str) -> list[int]:
    try:
        budgets = [int(part) for part in text.split(",")]
    except ValueError as error:
        raise BadInput(f"--points {text}: expected whole numbers joined by commas, such as 300,600") from error
    if min(budgets) < 2:
        raise BadInput(f"--points {text}: expected budgets of 2 points or more")
    return budgets
