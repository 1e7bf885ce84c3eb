"""A command's options go in one by one; they come out gathered in one object, for commands that have many."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable
from typing import Any

import click

from limner.errors import BadInput


def gathered(*kinds: type) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Give a command an object of each dataclass, made of the options that its fields name, in their place.

    An option that several of them name is in each; one that none names is given as it is.
    """
    names = [[field.name for field in dataclasses.fields(kind)] for kind in kinds]

    def give(command: Callable[..., None]) -> Callable[..., None]:
        @functools.wraps(command)
        def run(ctx: click.Context, **values: Any) -> None:
            made = [kind(**{name: values[name] for name in own}) for kind, own in zip(kinds, names, strict=True)]
            others = {name: value for name, value in values.items() if not any(name in own for own in names)}
            command(ctx, *made, **others)

        return run

    return give


def refuse(wanted: Any, options: dict[str, str], why: str) -> None:
    """Say which option does not go with what is asked for.

    Args:
        wanted: the options' values, as its attributes.
        options: option -> attribute; none may be given.
        why: follows the option's name.

    Raises:
        BadInput: one of them is given.
    """
    for option, name in options.items():
        if getattr(wanted, name):
            raise BadInput(f"{option} {why}")
