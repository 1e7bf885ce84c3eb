"""A cookie goes in; the visitor it belongs to comes out, with the photos and drawings that only he sees."""

from __future__ import annotations

import hashlib
import secrets
from collections import OrderedDict
from dataclasses import dataclass, field
from typing import Any, Generic, TypeVar

PHOTOS, DRAWINGS, VISITORS = 6, 24, 64
"""How many are held: photos and drawings of a visitor, and visitors; the oldest go."""

Item = TypeVar("Item")


@dataclass(frozen=True)
class HeldPhoto:
    """A photo as it came, and as it is shown.

    Attributes:
        name: under which it is asked for.
        data: bytes of the file, as it was sent unless that was long.
        jpeg: upright, for the page.
        about: what was found in it, as the page gets it.
    """

    name: str
    data: bytes
    jpeg: bytes
    about: dict[str, Any]


@dataclass(frozen=True)
class HeldDrawing:
    """A drawing that was kept.

    Attributes:
        name: under which it is asked for.
        photo: the name of its photo.
        npz: the drawing itself.
        about: its report and settings, as the page gets them.
    """

    name: str
    photo: str
    npz: bytes
    about: dict[str, Any]


class Recent(Generic[Item]):
    """The latest items by name; older ones are let go."""

    def __init__(self, most: int) -> None:
        self._most = most
        self._items: OrderedDict[str, Item] = OrderedDict()

    def add(self, name: str, item: Item) -> None:
        """Take an item in; the oldest go."""
        self._items[name] = item
        self._items.move_to_end(name)
        while len(self._items) > self._most:
            self._items.popitem(last=False)

    def get(self, name: str) -> Item | None:
        """The item, which is now the latest used."""
        if name in self._items:
            self._items.move_to_end(name)
        return self._items.get(name)

    def drop(self, name: str) -> bool:
        """Let an item go; whether there was one."""
        return self._items.pop(name, None) is not None

    def latest(self) -> list[Item]:
        """All of them, the latest used first."""
        return list(reversed(self._items.values()))


@dataclass
class Visitor:
    """One browser.

    Attributes:
        role: ``visitor`` or ``operator``.
        seal: SHA-256 of his cookie, by which a later server knows him again.
        photos: his.
        drawings: his.
    """

    role: str = "visitor"
    seal: str = ""
    photos: Recent[HeldPhoto] = field(default_factory=lambda: Recent(PHOTOS))
    drawings: Recent[HeldDrawing] = field(default_factory=lambda: Recent(DRAWINGS))


class Visitors:
    """All who have entered; in memory only."""

    def __init__(self, port: int) -> None:
        """Begin with nobody.

        Args:
            port: of the server: browsers send one cookie to all ports of a host.
        """
        self._port = port
        self._known: dict[str, Recent[Visitor]] = {}
        self._expected: dict[tuple[str, str], Visitor] = {}

    def cookie_name(self, role: str) -> str:
        """Under which a role's cookie stands."""
        return f"limner_{role}_{self._port}"

    def enter(self, role: str) -> str:
        """A new visitor; his cookie."""
        cookie = secrets.token_urlsafe(32)
        self._admit(cookie, Visitor(role, _seal(cookie)))
        return cookie

    def expect(self, visitor: Visitor) -> None:
        """Know a visitor of a server before this one again when he comes with his old cookie."""
        self._expected[visitor.role, visitor.seal] = visitor

    def _admit(self, cookie: str, visitor: Visitor) -> Visitor:
        self._known.setdefault(visitor.role, Recent(VISITORS)).add(cookie, visitor)
        return visitor

    def known(self, role: str, cookie: str) -> Visitor | None:
        """Whose cookie it is."""
        visitors = self._known.get(role)
        here = visitors.get(cookie) if visitors else None
        if here is not None or not cookie:
            return here
        before = self._expected.pop((role, _seal(cookie)), None)
        return before and self._admit(cookie, before)


def _seal(cookie: str) -> str:
    return hashlib.sha256(cookie.encode()).hexdigest()
