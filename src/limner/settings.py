"""Settings: frozen dataclasses whose fields carry unit, range and one line of help; to and from TOML."""

from __future__ import annotations

import dataclasses
import difflib
import math
import tomllib
import types
import typing
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

from limner.errors import BadInput

Scalar = bool | int | float | str
AUTO = "auto"
"""Takes back a number: the setting is as if it were not set."""
NONE = "none"
"""Stands for no name, where names are asked for."""

Tree = typing.TypeVar("Tree", bound="SettingsGroup")


@dataclass(frozen=True)
class About:
    """What a setting means: shown by ``--help`` and the studio, enforced on every value.

    Attributes:
        help: one line, without a full stop.
        unit: of the value, empty for none.
        low, high: limits, both allowed.
        choices: the only values allowed.
    """

    help: str
    unit: str = ""
    low: float | None = None
    high: float | None = None
    choices: tuple[str, ...] = ()


def setting(
    default: Scalar | None,
    help: str,
    *,
    unit: str = "",
    low: float | None = None,
    high: float | None = None,
    choices: tuple[str, ...] = (),
) -> Any:
    """A field of a settings group: its default and what it means."""
    return dataclasses.field(default=default, metadata={"about": About(help, unit, low, high, choices)})


def group(cls: type[SettingsGroup]) -> Any:
    """A field that holds another group with its defaults."""
    return dataclasses.field(default_factory=cls)


@dataclass(frozen=True)
class SettingsGroup:
    """Base of every settings group: each value is checked once, on construction."""

    _known_hints: ClassVar[dict[str, Any]]

    def __post_init__(self) -> None:
        hints = self._hints()
        for field in dataclasses.fields(self):
            if "about" in field.metadata:
                value = _checked(getattr(self, field.name), hints[field.name], field.metadata["about"], field.name)
                object.__setattr__(self, field.name, value)

    @classmethod
    def from_dict(cls, values: Mapping[str, Any], path: str = "") -> Self:
        """Build the group from nested dictionaries; what is absent keeps its default.

        Raises:
            BadInput: a name that does not exist or a value outside its limits.
        """
        hints = cls._hints()
        fields = {field.name: field for field in dataclasses.fields(cls)}
        given: dict[str, Any] = {}
        for name, value in values.items():
            if name not in fields:
                raise BadInput(f"settings: {path}{name} does not exist; {_choices(name, list(fields))}")
            if "about" in fields[name].metadata:
                given[name] = _checked(value, hints[name], fields[name].metadata["about"], path + name)
            elif isinstance(value, Mapping):
                given[name] = hints[name].from_dict(value, f"{path}{name}.")
            else:
                raise BadInput(f"settings: {path}{name} is a group of settings, got {value!r}; set one of its members")
        return cls(**given)

    def to_dict(self) -> dict[str, Any]:
        """Nested dictionaries of plain values; a setting that is not set is left out."""
        result: dict[str, Any] = {}
        for field in dataclasses.fields(self):
            value = getattr(self, field.name)
            if isinstance(value, SettingsGroup):
                result[field.name] = value.to_dict()
            elif value is not None:
                result[field.name] = value
        return result

    def replace(self, **changes: Any) -> Self:
        """A copy with some fields changed, checked again."""
        return dataclasses.replace(self, **changes)

    def assign(self, path: str, text: str) -> Self:
        """A copy with the setting at ``path`` (names joined by dots) read from ``text``.

        Raises:
            BadInput: no such setting, or the text is no value for it.
        """
        return self.from_dict(_merge(self.to_dict(), _nest(path, self._parse(path.split("."), text, path))))

    @classmethod
    def walk(cls, path: str = "") -> Iterator[tuple[str, About, Any]]:
        """Every setting below: its path, what it means, its default; those of a group before those of its groups."""
        hints = cls._hints()
        # In TOML what follows the heading of a group belongs to it.
        for field in sorted(dataclasses.fields(cls), key=lambda field: "about" not in field.metadata):
            if "about" in field.metadata:
                yield path + field.name, field.metadata["about"], field.default
            else:
                yield from hints[field.name].walk(f"{path}{field.name}.")

    @classmethod
    def _hints(cls) -> dict[str, Any]:
        """The types of the fields; kept, since Python compiles them from their text each time it is asked."""
        if "_known_hints" not in cls.__dict__:
            cls._known_hints = typing.get_type_hints(cls)
        return cls._known_hints

    @classmethod
    def _parse(cls, names: list[str], text: str, path: str) -> Any:
        fields = {field.name: field for field in dataclasses.fields(cls)}
        hints = cls._hints()
        name, *rest = names
        if name in fields and bool(rest) == ("about" not in fields[name].metadata):
            if rest:
                return hints[name]._parse(rest, text, path)
            if str in _kinds(hints[name]):
                return text
            try:
                return tomllib.loads(f"value = {text}")["value"]
            except (ValueError, RecursionError):
                return text
        raise BadInput(f"settings: {path} does not exist; {_choices(name, [path for path, _, _ in cls.walk()])}")


def read_toml(tree: type[Tree], text: str) -> Tree:
    """Settings from TOML text.

    Raises:
        BadInput: the text is no TOML, or holds a setting that does not exist or is outside its limits.
    """
    try:
        values = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise BadInput(f'settings: not TOML ({error}); a text stands in quotes, as in name = "text"') from error
    return tree.from_dict(values)


def write_toml(tree: SettingsGroup) -> str:
    """The whole tree as TOML text: each group under what it is, each setting under its help, unit and limits."""
    import tomli_w

    lines: list[str] = []
    section: list[str] = []
    for path, about, _ in type(tree).walk():
        *groups, name = path.split(".")
        holder: Any = tree
        for part in groups:
            holder = getattr(holder, part)
        if groups != section:
            section = groups
            what = (type(holder).__doc__ or "").partition("\n")[0]
            lines += ["", f"# {what}", f"[{'.'.join(groups)}]"]
        value = getattr(holder, name)
        lines.append(f"# {about.help}{_limits(about)}")
        lines.append(f"# {name} = (not set)" if value is None else tomli_w.dumps({name: value}).strip())
    return "\n".join(lines).lstrip() + "\n"


def _limits(about: About) -> str:
    parts = [about.unit] if about.unit else []
    if about.choices:
        parts.append(" | ".join(about.choices))
    if about.low is not None and about.high is not None:
        parts.append(f"{about.low:g} to {about.high:g}")
    elif about.low is not None:
        parts.append(f"at least {about.low:g}")
    elif about.high is not None:
        parts.append(f"at most {about.high:g}")
    return f" [{', '.join(parts)}]" if parts else ""


def _kinds(hint: Any) -> tuple[Any, ...]:
    return typing.get_args(hint) if isinstance(hint, types.UnionType) else (hint,)


def _checked(value: Any, hint: Any, about: About, name: str) -> Any:
    kinds = _kinds(hint)
    if types.NoneType in kinds and (value is None or (value == AUTO and str not in kinds)):
        return None
    if isinstance(value, int) and abs(value) >= 2**63:
        raise BadInput(f"settings: {name} is a number of {len(str(abs(value)))} digits{_limits(about)}")
    if float in kinds and isinstance(value, int) and not isinstance(value, bool):
        value = float(value)
    if type(value) not in kinds:
        wanted = " or ".join(_WORDS[kind] for kind in kinds if kind is not types.NoneType)
        raise BadInput(f"settings: {name} = {value!r}, expected {wanted}{_limits(about)}")
    if not _within(value, about):
        allowed = _limits(about) or " what is finite"
        raise BadInput(f"settings: {name} = {value!r} is outside{allowed}{_near(value, about)}")
    return value


def _near(value: Scalar, about: About) -> str:
    close = difflib.get_close_matches(str(value).lower(), about.choices, n=1)
    return f"; did you mean {close[0]}?" if close else ""


def _within(value: Any, about: About) -> bool:
    if isinstance(value, str):
        return not about.choices or value in about.choices
    low, high = (-math.inf if about.low is None else about.low), (math.inf if about.high is None else about.high)
    return math.isfinite(value) and bool(low <= value <= high)


_WORDS = {bool: "true or false", int: "a whole number", float: "a number", str: "a text"}


def names_in(text: str, choices: Collection[str], where: str) -> tuple[str, ...]:
    """The names that a text holds, separated by commas, in its order; none for ``none`` or nothing.

    Args:
        text: of a setting that names several things.
        choices: the names that there are.
        where: of the setting, for the message.

    Raises:
        BadInput: a name that does not exist.
    """
    names = tuple(name.strip() for name in text.split(",") if name.strip() not in ("", NONE))
    for name in names:
        if name not in choices:
            raise BadInput(f"{where}: '{name}' does not exist; choose from {', '.join(choices)}, or {NONE}")
    return names


def _choices(name: str, names: list[str]) -> str:
    close = difflib.get_close_matches(name, names, n=3, cutoff=0.5)
    close = close or [other for other in names if other.endswith("." + name.rpartition(".")[2])]
    return f"did you mean {' or '.join(close)}?" if close else f"choose from {', '.join(names)}"


def _nest(path: str, value: Any) -> dict[str, Any]:
    for part in reversed(path.split(".")):
        value = {part: value}
    nested: dict[str, Any] = value
    return nested


def _merge(base: dict[str, Any], change: dict[str, Any]) -> dict[str, Any]:
    merged = dict(base)
    for key, value in change.items():
        inner = merged.get(key, {})
        merged[key] = _merge(inner, value) if isinstance(value, dict) and isinstance(inner, dict) else value
    return merged
