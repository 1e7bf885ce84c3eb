"""Photos, an engine and an order go in; a folder of drawings with manifest and contact sheet comes out."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path

from limner import storage
from limner.batch import lock, manifest, sheet
from limner.batch.engine import Engine
from limner.batch.run import Order, draw_all
from limner.batch.state import State
from limner.batch.summary import Summary
from limner.errors import BadInput

Watch = Callable[[Summary], None]
"""Told after each row."""


@dataclass
class Total:
    """How many photos there are, counted beside the work."""

    count: int = 0
    known: bool = False
    _thread: threading.Thread | None = field(default=None, repr=False)

    def begin(self, photos: Iterable[str]) -> None:
        """Count them in a thread that ends with the process."""

        def run() -> None:
            try:
                for _ in photos:
                    self.count += 1
                self.known = True
            except BadInput:
                return  # said by who draws them

        self._thread = threading.Thread(target=run, daemon=True, name="limner-count")
        self._thread.start()


def draw_batch(
    photos: Iterable[str], engine: Engine, order: Order, summary: Summary, watch: Watch, parquet: bool = False
) -> list[Path]:
    """Draw every photo that is not drawn yet, and write what is known of all.

    One run at a time may write to a folder. Whatever ends a run early, the next one goes on from there.

    Args:
        photos: paths and URLs.
        engine: what does the work.
        order: what is wanted.
        summary: counts as the run goes on, so that it tells what was done when the run is broken off.
        watch: told of progress.
        parquet: write the manifest as Parquet too.

    Returns:
        The manifest, as Parquet too if asked for, and the contact sheet if it has room for any.

    Raises:
        BadInput: another run writes there, a list cannot be read, nothing is in it, or there is no writing.
    """
    folder = order.folder
    with lock.held(folder), State.opened(folder) as state:
        with manifest.Manifest.written(folder / manifest.CSV) as rows:
            for told in draw_all(photos, engine, order, state):
                rows.add(told.row)
                summary.add(told)
                watch(summary)
        if not summary.photos:
            raise BadInput("batch: no photos there; expected files such as .jpg, .png, .webp or .heic")
        made = [folder / manifest.CSV]
        if parquet:
            made.append(manifest.to_parquet(folder))
        if summary.room:
            made.append(folder / sheet.NAME)
            storage.write_whole(made[-1], sheet.to_html(summary, folder, order.store))
    return made
