"""Options that several commands share; flags take default, unit, limits and help from the settings they set."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from limner import storage, units
from limner.errors import BadInput
from limner.pipeline import Settings
from limner.settings import About, SettingsGroup, read_toml, write_toml

Command = TypeVar("Command", bound=Callable[..., Any])
Tree = TypeVar("Tree", bound=SettingsGroup)

ABOUT = {path: (about, default) for path, about, default in Settings.walk()}
"""Every setting of a drawing: what it means and its default."""

# Under these names a command keeps the settings that its options give, in their order, the file they go over, and the
# model of the detector, which is known only when all are read.
_ASSIGNED = "limner.assigned"
_FILE = "limner.settings"
_MODEL = "limner.model"


if TYPE_CHECKING:
    _Rectangle = click.ParamType[tuple[int, int, int, int]]
else:
    # Before click 8.4 it cannot be subscripted.
    _Rectangle = click.ParamType


class Crop(_Rectangle):
    """A rectangle ``x,y,w,h`` in photo pixels."""

    name = "x,y,w,h"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Text to four whole numbers."""
        try:
            x, y, width, height = (int(part) for part in str(value).split(","))
        except ValueError:
            self.fail(f"'{value}' is not x,y,w,h: four whole numbers of pixels, such as 120,40,400,500", param, ctx)
        return x, y, width, height


def flag(path: str, *names: str, parse: Callable[[str], Any] = str, metavar: str = "TEXT") -> Callable[[Any], Any]:
    """An option that assigns its value, after ``parse``, to the setting at ``path``."""
    about, default = ABOUT[path]

    def assign(ctx: click.Context, param: click.Parameter, value: str | None) -> None:
        if value is not None:
            _assign(ctx, path, str(parse(value)))

    return click.option(*names, expose_value=False, callback=assign, metavar=metavar, help=_help(about, default))


def switch(path: str, *names: str) -> Callable[[Any], Any]:
    """An option without a value that turns on the setting at ``path``."""

    def assign(ctx: click.Context, param: click.Parameter, value: bool) -> None:
        if value:
            _assign(ctx, path, "true")

    return click.option(*names, is_flag=True, expose_value=False, callback=assign, help=_help(ABOUT[path][0], ""))


def _assign(ctx: click.Context, path: str, text: str) -> None:
    ctx.meta.setdefault(_ASSIGNED, []).append((path, text))


def _help(about: About, default: Any) -> str:
    unit = f" [{about.unit}]" if about.unit else ""
    choices = f" ({', '.join(about.choices)})" if about.choices else ""
    shown = "" if default in (None, "") else f" Default: {default}."
    return f"{about.help[:1].upper()}{about.help[1:]}{unit}{choices}.{shown}"


def together(options: Sequence[Callable[[Command], Command]]) -> Callable[[Command], Command]:
    """Several options as one decorator, in the order of ``--help``."""

    def add(command: Command) -> Command:
        for option in reversed(options):
            command = option(command)
        return command

    return add


def _assign_many(ctx: click.Context, param: click.Parameter, value: tuple[str, ...]) -> None:
    for assignment in value:
        name, equals, text = assignment.partition("=")
        if not equals:
            raise click.BadParameter(f"'{assignment}' is not NAME=VALUE", ctx, param)
        _assign(ctx, name.strip(), text.strip())


def _keep_file(ctx: click.Context, param: click.Parameter, value: Path | None) -> None:
    ctx.meta[_FILE] = value


def _keep_model(ctx: click.Context, param: click.Parameter, value: str | None) -> None:
    ctx.meta[_MODEL] = value


def _one_photo(ctx: click.Context, param: click.Parameter, value: str) -> str:
    if Path(value).is_dir():
        raise BadInput(f"{value}: is a folder, expected a photo; `limner batch` draws all that are in a folder")
    return value


def _face_from_file(ctx: click.Context, param: click.Parameter, value: str | None) -> None:
    if value is not None:
        _assign(ctx, "detect.detector", "file")
        _assign(ctx, "detect.file", value)


photo_options: Callable[[Any], Any] = together(
    [
        click.argument("photo", metavar="PHOTO", callback=_one_photo),
        click.option("--crop", type=Crop(), help="Look only at this part of the photo [px, from the top left]."),
        click.option(
            "--face", "number", type=click.IntRange(1), metavar="N", help="The N-th largest face. Default: 1."
        ),
        click.option(
            "--landmarks",
            metavar="FILE",
            expose_value=False,
            callback=_face_from_file,
            help="Take the face from a file (JSON of `limner face`, .pts or .csv) instead of looking for it.",
        ),
        flag("detect.detector", "--detector", metavar="NAME"),
        click.option(
            "--model",
            metavar="FILE",
            expose_value=False,
            callback=_keep_model,
            help="File of the detector's model: .npz or .mat for fmp, face_landmark.tflite for mediapipe.",
        ),
    ]
)
"""Which photo, which part of it, which face in it, and what finds it."""

drawing_options: Callable[[Any], Any] = together(
    [
        flag("select.points", "--points", "-n", metavar="N"),
        flag("select.minutes", "--minutes", parse=units.parse_minutes, metavar="M"),
        flag("machine", "--machine", metavar="NAME"),
        switch("svg.curves", "--curves"),
        flag("order.by", "--order", metavar="ORDER"),
        flag("page.size", "--page", metavar="SIZE"),
        flag("page.margin_mm", "--margin", parse=units.parse_length_mm, metavar="LENGTH"),
        flag("page.pen_mm", "--pen", parse=units.parse_length_mm, metavar="LENGTH"),
    ]
)
"""The budget, the page and the pen."""

settings_options: Callable[[Any], Any] = together(
    [
        click.option(
            "--set",
            "assignments",
            multiple=True,
            metavar="NAME=VALUE",
            expose_value=False,
            callback=_assign_many,
            help="Any other setting by its name; --save-settings lists them. May be repeated.",
        ),
        click.option(
            "--settings",
            type=click.Path(path_type=Path),
            metavar="FILE",
            expose_value=False,
            callback=_keep_file,
            help="Read settings from a TOML file; the other options go over it.",
        ),
        click.option(
            "--save-settings",
            type=click.Path(path_type=Path),
            metavar="FILE",
            help="Write every setting in force, with its help, to a TOML file.",
        ),
    ]
)
"""The whole tree of settings, by file or by name."""

json_option = click.option("--json", "as_json", is_flag=True, help="Print one JSON object on stdout and nothing else.")


def chosen_settings(ctx: click.Context, tree: type[Tree], save_to: Path | None = None) -> Tree:
    """The settings that the command was given: the file, then the options; written to ``save_to`` when asked."""
    file = ctx.meta.get(_FILE)
    settings = _settings_in(tree, file) if file else tree()
    for path, text in ctx.meta.get(_ASSIGNED, []):
        settings = settings.assign(path, text)
    if ctx.meta.get(_MODEL) and isinstance(settings, Settings):
        settings = settings.assign(model_path(settings, ctx.meta[_MODEL]), ctx.meta[_MODEL])
    if save_to is not None:
        storage.write_whole(save_to, write_toml(settings).encode())
    return settings


def _settings_in(tree: type[Tree], file: Path) -> Tree:
    text = read_text(file)
    try:
        return read_toml(tree, text)
    except BadInput as error:
        raise BadInput(f"{file}: {error}") from error


def model_path(settings: Settings, file: str) -> str:
    """The name of the setting that holds the model of the detector that is chosen.

    Raises:
        BadInput: that detector has none, or another kind.
    """
    detector = settings.detect.detector
    if detector != "mediapipe" and file.lower().endswith(".tflite"):
        raise BadInput(f"--model {file}: not for the detector '{detector}'; add --detector mediapipe")
    path = f"detect.{detector}.model"
    if path not in ABOUT:
        raise BadInput(f"--model {file}: the detector '{detector}' has no model; choose --detector fmp or mediapipe")
    return path


def read_text(path: Path) -> str:
    """The text of a file.

    Raises:
        BadInput: it cannot be read, or is no text.
    """
    try:
        return storage.read_bytes(path).decode()
    except UnicodeDecodeError as error:
        raise BadInput(f"{path}: not a text in UTF-8 ({error.reason} at byte {error.start})") from error


def check_suffix(path: str | None, *suffixes: str) -> None:
    """Say at once, before any work, that a file cannot be written as what it is called."""
    if path is not None and Path(path).suffix.lower() not in suffixes:
        expected = " or ".join(suffixes)
        raise BadInput(f"{path}: cannot save as '{Path(path).suffix}'; expected a name that ends in {expected}")


def stem(photo: str) -> str:
    """What files made from a photo are called."""
    return (Path(photo).stem if photo != "-" else "") or "portrait"
