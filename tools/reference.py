"""The command line and the settings in; docs/reference/commands.md and settings.md out (--check: are they so?)."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import click

from limner.cli import COMMANDS, limner
from limner.pipeline import Settings
from limner.settings import About

FOLDER = Path("docs/reference")
_WIDTH = 88


def commands() -> str:
    """Every command's help, as ``--help`` prints it."""
    lines = ["# Commands", "", "What `limner COMMAND --help` prints (`make reference` writes this page).", ""]
    for name in COMMANDS:
        context = click.Context(limner, info_name="limner")
        command = limner.get_command(context, name)
        assert command is not None
        for words, text in _helps(command, ["limner", name]):
            lines += [f"{'##' if len(words) == 2 else '###'} {' '.join(words)}", "", "```text", text, "```", ""]
    return "\n".join(lines)


def _helps(command: click.Command, words: list[str]) -> Iterator[tuple[list[str], str]]:
    context = click.Context(command, info_name=" ".join(words), terminal_width=_WIDTH, max_content_width=_WIDTH)
    yield words, command.get_help(context).rstrip()
    if isinstance(command, click.Group):
        for name in command.list_commands(context):
            inner = command.get_command(context, name)
            if inner is not None:
                yield from _helps(inner, [*words, name])


def settings() -> str:
    """Every setting by its name: default, limits, help."""
    lines = [
        "# Settings",
        "",
        "`--set NAME=VALUE` changes one, `--settings FILE.toml` reads many, `--save-settings FILE.toml` writes",
    ]
    lines += [
        "all that are in force (`make reference` writes this page).",
        "",
        "| name | default | | |",
        "|---|---|---|---|",
    ]
    for path, about, default in Settings.walk():
        shown = "" if default is None else f"`{default}`" if default != "" else "(empty)"
        lines.append(f"| `{path}` | {shown} | {_limits(about)} | {_cell(about.help)} |")
    return "\n".join([*lines, ""])


def _limits(about: About) -> str:
    parts = [about.unit] if about.unit else []
    if about.choices:
        parts.append(", ".join(about.choices))
    elif about.low is not None or about.high is not None:
        low, high = ("" if limit is None else f"{limit:g}" for limit in (about.low, about.high))
        parts.append(f"{low} to {high}")
    return _cell("; ".join(parts))


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("<", "&lt;")


def main() -> int:
    """Write both pages, or tell which is not as it should be."""
    stale = 0
    for name, text in (("commands.md", commands()), ("settings.md", settings())):
        file = FOLDER / name
        if "--check" not in sys.argv:
            file.write_text(text)
        elif not file.exists() or file.read_text() != text:
            print(f"{file} is not up to date; run: make reference", file=sys.stderr)
            stale = 1
    return stale


if __name__ == "__main__":
    sys.exit(main())
