"""The bytes of a URDF go in; its links and joints come out, or an error where reading it could be wrong or endless."""

from __future__ import annotations

from typing import Any
from xml.parsers import expat

from limner.errors import BadInput, MissingExtra

MAX_BYTES = 20 * 2**20
MAX_DEPTH = 50


def read_urdf(data: bytes, name: str) -> Any:
    """The robot as the URDF reader has it.

    Args:
        data: the file.
        name: for messages.

    Raises:
        BadInput: no URDF, or entities or nesting that could exhaust the reader.
        MissingExtra: the URDF reader is not installed.
    """
    _guard(data, name)
    try:
        from urdf_parser_py import urdf, xml_reflection
    except ImportError as error:
        raise MissingExtra(f"reading the robot {name}", "robot") from error
    # The library prints what it does not know, such as Gazebo's tags; that is no error.
    xml_reflection.core.on_error = lambda message: None
    try:
        return urdf.URDF.from_xml_string(data)
    except Exception as error:  # the reader raises whatever its fields raise
        raise BadInput(f"{name}: is no URDF ({' '.join(str(error).split())})") from error


def _guard(data: bytes, name: str) -> None:
    """Refuse what could exhaust an XML reader."""
    if len(data) > MAX_BYTES:
        raise BadInput(f"{name}: {len(data) / 2**20:.0f} MB is more than the {MAX_BYTES // 2**20} MB of a URDF")
    depth = [0]

    def start(tag: str, attributes: dict[str, str]) -> None:
        if not depth[0] and tag != "robot":
            raise BadInput(f"{name}: is no URDF; its outermost element is <{tag}>, expected <robot>")
        depth[0] += 1
        if depth[0] > MAX_DEPTH:
            raise BadInput(f"{name}: has elements nested deeper than {MAX_DEPTH}; this is no sane URDF")

    def end(tag: str) -> None:
        depth[0] -= 1

    def entity(*declaration: Any) -> None:
        raise BadInput(f"{name}: declares XML entities, which are not read; save it without them (run xacro first)")

    parser = expat.ParserCreate()
    parser.StartElementHandler, parser.EndElementHandler, parser.EntityDeclHandler = start, end, entity
    try:
        parser.Parse(data, True)
    except (expat.ExpatError, ValueError, LookupError) as error:
        raise BadInput(f"{name}: is no URDF ({error})") from error
