"""The command ``limner``: words from the shell in, files and one exit code out.

Commands load when they are called, so that ``limner --help`` needs neither numpy nor OpenCV.
"""

from __future__ import annotations

import importlib
import os
import sys
import traceback
from typing import NoReturn

import click

from limner.cli.groups import Group
from limner.errors import LimnerError

COMMANDS = {
    "draw": ("limner.cli.draw", "Draw the person in a photo as ordered pen strokes."),
    "face": ("limner.cli.face", "Find the faces in a photo and their landmarks."),
    "compare": ("limner.cli.compare", "Draw a photo in every style, side by side on one sheet."),
    "batch": ("limner.cli.batch", "Draw many photos, on this machine or on a cluster."),
    "film": ("limner.cli.film", "Make a cartoon of a film or of what a camera sees."),
    "plan": ("limner.cli.plan", "Tell how long a machine draws, and show it."),
    "simulate": ("limner.cli.simulate", "Let a simulated robot arm draw, with physics and faults."),
    "send": ("limner.cli.send", "Draw on a plotter or with an arm."),
    "studio": ("limner.cli.studio", "Open the studio: from a photo to the machine, in the browser."),
    "ros": ("limner.cli.ros", "Draw with an arm through ROS 1."),
    "train": ("limner.cli.train", "Train the models that limner ships."),
    "evaluate": ("limner.cli.evaluate", "Measure accuracy and speed."),
}
"""Name -> module that holds a command of that name, and its line in ``limner --help``."""


class LazyGroup(Group):
    """A group whose commands are imported when one is called."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Names, in the order of ``COMMANDS``."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """The command of that name, imported now."""
        if cmd_name not in COMMANDS:
            return None
        command = getattr(importlib.import_module(COMMANDS[cmd_name][0]), cmd_name)
        assert isinstance(command, click.Command)
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """The table of commands, from ``COMMANDS`` alone."""
        with formatter.section("Commands"):
            formatter.write_dl([(name, line) for name, (_, line) in COMMANDS.items()])


_HELP = """From a photo of a face to a portrait in pen strokes.

\b
  limner draw me.jpg                      writes me.svg
  limner draw me.jpg -n 600 -o me.png     with at most 600 points
  limner compare me.jpg                   every style on one sheet
"""


@click.group(
    cls=LazyGroup, help=_HELP, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100}
)
@click.version_option(package_name="limner", message="limner %(version)s")
@click.option("--debug", is_flag=True, help="Show the traceback of an error.")
def limner(debug: bool) -> None:
    """The command ``limner``."""


def main() -> NoReturn:
    """Run the command line and exit: 0 done, 2 bad input, 3 no face, 4 cannot be drawn, 5 a device, 130 interrupted."""
    debug = "--debug" in sys.argv
    # --debug may stand anywhere, since one adds it to a line that has just failed.
    arguments = [argument for argument in sys.argv[1:] if argument != "--debug"]
    try:
        code = limner.main(arguments, prog_name="limner", standalone_mode=False)
        sys.stdout.flush()
    except (click.exceptions.Abort, KeyboardInterrupt):
        code = _say("interrupted", 130)
    except click.ClickException as error:
        code = _mistake(error, arguments)
    except BrokenPipeError:
        # The reader of our output (`limner face --json | head`) has gone: nothing is left to say.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        code = 0
    except LimnerError as error:
        code = _say(str(error), error.exit_code, debug)
        for note in getattr(error, "__notes__", ()):
            click.echo(f"limner: {note}", err=True)
    except MemoryError:
        code = _say("not enough memory for this; try a smaller photo or --crop", 4, debug)
    except Exception as error:  # whatever else: a bug is one line too
        code = _say(
            f"a bug in limner: {type(error).__name__}: {error}; run it again with --debug and report it", 1, debug
        )
    sys.exit(code if isinstance(code, int) else 0)


def _say(message: str, code: int, debug: bool = False) -> int:
    if debug:
        traceback.print_exc()
    click.echo("limner: " + " ".join(message.split()), err=True)
    return code


def _mistake(error: click.ClickException, arguments: list[str]) -> int:
    message = error.format_message()
    if not isinstance(error, click.UsageError) or error.ctx is None:
        return _say(message, 2)
    if message == error.ctx.get_help():
        # A group alone; click, from 8.2 on, makes its help an error.
        click.echo(message, err=True)
        return 2
    # A name that begins with a dash has been read as options.
    for name in arguments:
        if name.startswith("-") and os.path.exists(name):
            return _say(f"{name} is read as options; write ./{name}", 2)
    return _say(f"{message.rstrip('.')}; see: {error.ctx.command_path} --help", 2)
