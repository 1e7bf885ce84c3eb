"""What a long task tells of its progress goes in; bars on stderr come out, if that is a terminal."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import (
    BarColumn,
    Progress,
    ProgressColumn,
    SpinnerColumn,
    TaskID,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

Watch = Callable[[str, int, int, str], None]
"""Told what is being done, how much of it is done, of how much, and a few words."""


@contextmanager
def busy(what: str) -> Iterator[None]:
    """Say what is being done, and for how long already, while the body runs; then it is gone again."""
    console = Console(stderr=True)
    columns = SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn()
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as progress:
        progress.add_task(what, total=None)
        yield


@contextmanager
def bars(clocks: bool = True) -> Iterator[Watch]:
    """One bar for each kind of work, in the order in which they begin.

    Args:
        clocks: count the work, tell the time behind and guess the time left; for work that does not say them itself.
    """
    console = Console(stderr=True)
    counts = [TextColumn("{task.completed:.0f}/{task.total:.0f}"), TimeElapsedColumn(), TimeRemainingColumn()]
    columns: list[ProgressColumn] = [TextColumn("{task.description:<14}"), BarColumn()]
    columns += [*(counts if clocks else []), TextColumn("{task.fields[note]}")]
    with Progress(*columns, console=console, disable=not console.is_terminal) as progress:
        tasks: dict[str, TaskID] = {}

        def watch(what: str, done: int, total: int, note: str) -> None:
            if what not in tasks:
                tasks[what] = progress.add_task(what, total=total, note=note)
            progress.update(tasks[what], completed=done, total=total, note=note)

        yield watch
