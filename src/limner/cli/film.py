"""``limner film``: a film or a camera in, a cartoon of it out."""

from __future__ import annotations

import itertools
import json
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TypeVar

import click

from limner import storage, units
from limner.cli import options
from limner.errors import BadInput
from limner.pipeline import Settings
from limner.targets.movie import encode_mp4
from limner.vision.cartoon.film import CAMERA, cartoon_frames, frames

T = TypeVar("T")

CAMERA_S = 10.0


@click.command(short_help="Make a cartoon of a film or of what a camera sees.")
@click.argument("source", metavar="FILM|camera:N")
@click.option("--out", "-o", metavar="FILE", help="Where to, an .mp4. Default: the film's name with -cartoon.mp4.")
@click.option("--length", metavar="TIME", help=f"How much of it: 90s, 2min. Default: all; of a camera {CAMERA_S:g} s.")
@click.option("--width", type=click.IntRange(16, 4096), metavar="PX", help="Width of the pictures. Default: as given.")
@options.settings_options
@options.json_option
@click.pass_context
def film(
    ctx: click.Context,
    source: str,
    out: str | None,
    length: str | None,
    width: int | None,
    save_settings: Path | None,
    as_json: bool,
) -> None:
    """Make a cartoon of FILM, or of what a camera sees (camera:0): flat colours, few tones, dark edges.

    As `limner draw --style cartoon --picture`, picture by picture and steady in time; faces are not looked for.
    """
    settings = options.chosen_settings(ctx, Settings, save_settings)
    live = source.startswith(CAMERA)
    out = out or f"{source.replace(':', '') if live else options.stem(source)}-cartoon.mp4"
    options.check_suffix(out, ".mp4")
    seconds = units.parse_time_s(length, "--length") if length else CAMERA_S if live else None
    rate, pictures = frames(source, width)
    if seconds is not None:
        pictures = itertools.islice(pictures, max(1, round(seconds * rate)))
    first = next(pictures, None)
    if first is None:
        raise BadInput(f"{source}: has no picture; choose another film")
    told = _Counted(cartoon_frames(itertools.chain([first], pictures), settings.cartoon.abstraction))
    begin = time.perf_counter()
    storage.write_whole(out, encode_mp4(told, rate, hold_s=0))
    spent = time.perf_counter() - begin
    if as_json:
        click.echo(json.dumps({"out": [out], "frames": told.count, "fps": rate, "seconds": spent}))
    else:
        click.echo(f"{told.count} frames, {told.count / max(spent, 1e-9):.0f} a second\n{out}", err=True)


class _Counted(Iterator[T]):
    """What an iterator gives, counted."""

    def __init__(self, given: Iterator[T]) -> None:
        self._given, self.count = given, 0

    def __next__(self) -> T:
        item = next(self._given)
        self.count += 1
        return item
