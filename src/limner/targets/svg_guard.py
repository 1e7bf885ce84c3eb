"""An SVG file's bytes go in; an error comes out where reading it could be wrong, endless, or far too long."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any
from xml.parsers import expat

from limner.errors import BadInput

MAX_BYTES = 50 * 2**20
MAX_ELEMENTS = 200_000
MAX_DEPTH = 100

USED_TIMES, USED_MORE = 4, 20_000
"""By ``<use>`` a file may grow to so many times its own size, and by so much: a kilobyte cannot take minutes."""

_SIZE_BYTES = 20  # of attributes count as much as an element

_XLINK_HREF = "http://www.w3.org/1999/xlink href"


@dataclass
class _Node:
    children: list[_Node] = field(default_factory=list)
    reference: str = ""
    size: int = 1  # one, and more for long attributes
    expanded: int = 0  # elements in it once every <use> is replaced by what it refers to; 0: not counted yet
    grown: int = 0  # the sizes of these
    counting: bool = False


def check_svg(data: bytes, name: str) -> None:
    """Refuse what is no SVG, and what could exhaust the reader.

    Refused: no well-formed XML, a root that is not ``svg``, entities of its own, more than ``MAX_BYTES``, elements
    nested deeper than ``MAX_DEPTH``, and ``<use>`` that refers to itself or multiplies to over ``MAX_ELEMENTS`` or to
    more than ``USED_TIMES`` and ``USED_MORE`` allow.

    Raises:
        BadInput: with the file's name and the limit.
    """
    if len(data) > MAX_BYTES:
        raise BadInput(
            f"{name}: {len(data) / 2**20:.0f} MB is more than the {MAX_BYTES // 2**20} MB of an SVG that are read"
        )
    reader = _Reader(name)
    try:
        reader.parse(data)
    except (expat.ExpatError, ValueError, LookupError) as error:
        raise BadInput(f"{name}: is no SVG ({error})") from error
    reader.count(reader.root, 0)


class _Reader:
    """Collects of each element only what is needed to count."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.root = _Node()
        self.size = 0
        self.stack = [self.root]
        self.by_id: dict[str, _Node] = {}

    def parse(self, data: bytes) -> None:
        parser = expat.ParserCreate(namespace_separator=" ")
        parser.StartElementHandler = self._start
        parser.EndElementHandler = self._end
        parser.EntityDeclHandler = self._entity
        parser.Parse(data, True)

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        tag = tag.rpartition(" ")[2]
        if len(self.stack) == 1 and tag != "svg":
            raise BadInput(f"{self.name}: is no SVG; its outermost element is <{tag}>")
        if len(self.stack) > MAX_DEPTH:
            raise BadInput(f"{self.name}: has elements nested deeper than {MAX_DEPTH}; flatten its groups")
        node = _Node(reference=attributes.get("href", attributes.get(_XLINK_HREF, "")) if tag == "use" else "")
        node.size += sum(map(len, attributes.values())) // _SIZE_BYTES
        self.size += node.size
        if "id" in attributes:
            self.by_id[attributes["id"]] = node
        self.stack[-1].children.append(node)
        self.stack.append(node)

    def _end(self, tag: str) -> None:
        self.stack.pop()

    def _entity(self, *declaration: Any) -> None:
        raise BadInput(f"{self.name}: declares XML entities, which are not read; save it without them")

    def count(self, node: _Node, depth: int) -> int:
        if node.counting or depth > MAX_DEPTH:
            raise BadInput(f"{self.name}: has a <use> that refers to itself or is nested too deep; flatten it")
        if not node.expanded:
            node.counting = True
            parts = list(node.children)
            if node.reference[1:] in self.by_id and node.reference:
                parts.append(self.by_id[node.reference[1:]])
            node.expanded = 1 + sum(self.count(part, depth + 1) for part in parts)
            node.grown = node.size + sum(part.grown for part in parts)
            node.counting = False
        if node.expanded > MAX_ELEMENTS:
            raise BadInput(f"{self.name}: has more than {MAX_ELEMENTS} elements; simplify it")
        if node.grown > USED_TIMES * self.size + USED_MORE:
            raise BadInput(f"{self.name}: repeats too much by <use>; simplify it")
        return node.expanded
