"""The name of a command that does not exist goes in; what was meant comes out."""

from __future__ import annotations

import difflib
import os

import click


class Group(click.Group):
    """A group that names the nearest of its commands, or all, for one that it has not."""

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """As click does, with what was meant."""
        names = self.list_commands(ctx)
        if args and not args[0].startswith("-") and args[0] not in names:
            raise click.UsageError(f"no command '{args[0]}'; {_meant(args[0], names)}", ctx)
        return super().resolve_command(ctx, args)


def _meant(name: str, names: list[str]) -> str:
    close = difflib.get_close_matches(name, names, n=1)
    if close:
        return f"did you mean '{close[0]}'?"
    if "draw" in names and os.path.isfile(name):
        return f"a photo is drawn by: limner draw {name}"
    if "batch" in names and os.path.isdir(name):
        return f"a folder of photos is drawn by: limner batch {name} -o DIR"
    return f"choose from {', '.join(names)}"
