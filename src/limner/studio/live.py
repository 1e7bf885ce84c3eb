"""What one page wishes for comes in through its WebSocket; previews and what follows go out, the latest wish first."""

from __future__ import annotations

import asyncio
import contextlib
import json
from collections.abc import Awaitable, Mapping
from typing import Any

from limner.errors import BadInput, LimnerError
from limner.studio.computer import LATER, NOW, SOON
from limner.studio.hub import Say
from limner.studio.studio import Studio
from limner.studio.visitors import Visitor

WANTED = ("preview", "plan", "candidates", "refinements")
"""What a wish may want; in this order it comes."""


class Live:
    """One page's wishes: the draft of a wish is finished although a newer one is there, what follows it is not.

    If drafts were called off too, a slider that moves on and on would show nothing until it stands still.
    """

    def __init__(self, studio: Studio, visitor: Visitor, say: Say) -> None:
        """Nothing is wished for yet.

        Args:
            studio: that computes.
            visitor: whose page it is.
            say: sends a message and perhaps a frame after it.
        """
        self._studio, self._visitor, self._say = studio, visitor, say
        self._wish: dict[str, Any] | None = None
        self._newer = asyncio.Event()

    def wish(self, text: str) -> None:
        """Take a wish in; it takes the place of the one before.

        Raises:
            BadInput: it is no wish.
        """
        self._wish = parse_wish(text)
        self._newer.set()

    async def run(self) -> None:
        """Fulfil wishes until cancelled."""
        while True:
            await self._newer.wait()
            self._newer.clear()
            wish, self._wish = self._wish, None
            assert wish is not None
            drawn = await self._unless_newer(wish, self._draft(wish), keep_on=True)
            if drawn and not self._newer.is_set():
                await self._unless_newer(wish, self._follow(wish), keep_on=False)

    async def _unless_newer(self, wish: dict[str, Any], work: Awaitable[None], *, keep_on: bool) -> bool:
        """Do some work, called off when a newer wish comes; with ``keep_on`` only when that is of another photo.

        Returns:
            Whether it was done.
        """
        doing = asyncio.ensure_future(work)
        try:
            while not doing.done():
                newer = asyncio.ensure_future(self._newer.wait())
                await asyncio.wait({doing, newer}, return_when=asyncio.FIRST_COMPLETED)
                newer.cancel()
                if doing.done() or not self._newer.is_set():
                    continue
                if keep_on and self._wish is not None and self._wish["photo"] == wish["photo"]:
                    await asyncio.wait({doing})
                    break
                doing.cancel()
                with contextlib.suppress(asyncio.CancelledError):
                    await doing
            if not doing.cancelled():
                doing.result()
                return True
        except LimnerError as error:
            await self._say({"type": "error", "rev": wish["rev"], "error": str(error)}, None)
        finally:
            doing.cancel()
        return False

    async def _draft(self, wish: dict[str, Any]) -> None:
        if "preview" in wish["want"]:
            await self._drawn("preview", wish, NOW, {"final": False}, draft=True)

    async def _follow(self, wish: dict[str, Any]) -> None:
        if {"preview", "plan"} & set(wish["want"]):
            drawn = await self._drawn("preview", wish, SOON, {"final": True})
            if "plan" in wish["want"]:
                await self._planned(wish, drawn)
        for kind in ("candidates", "refinements"):
            if kind in wish["want"]:
                await self._variants(kind, wish)

    async def _variants(self, kind: str, wish: dict[str, Any]) -> None:
        variants = await self._studio.compute(self._visitor, "variants", wish, LATER, kind=kind)
        for place, variant in enumerate(variants):
            settings = {**wish["settings"], **variant["settings"]}
            changed = wish | {"settings": settings, "want": ["preview"]}
            about = {"name": variant["name"], "label": variant["label"], "settings": variant["settings"]}
            about |= {"place": place, "of": len(variants)}
            try:
                await self._drawn(kind.removesuffix("s"), changed, LATER, about, slow=variant.get("slow", False))
            except LimnerError as error:
                said = {"type": kind.removesuffix("s"), "rev": wish["rev"], "frame": 0, "error": str(error)}
                await self._say(said | about, None)

    async def _drawn(
        self,
        kind: str,
        wish: dict[str, Any],
        urgency: int,
        about: dict[str, Any],
        *,
        draft: bool = False,
        slow: bool = False,
    ) -> dict[str, Any]:
        drawn: dict[str, Any] = await self._studio.compute(self._visitor, "draw", wish, urgency, slow=slow, draft=draft)
        said = {"type": kind, "rev": wish["rev"], "frame": 1, "report": drawn["report"]}
        await self._say(said | about, drawn["frame"])
        return drawn

    async def _planned(self, wish: dict[str, Any], drawn: dict[str, Any]) -> None:
        by, rev = wish["plan"], wish["rev"]
        found = await self._studio.planner.ask(
            "plan", SOON, npz=drawn["npz"], by=by, settings=drawn["settings"], rev=rev
        )
        said = {"type": "plan", "rev": rev, "plan": found["plan"], "frame": int("frame" in found)}
        if "error" in found:
            said["error"] = found["error"]
        await self._say(said, found.get("frame"))


def parse_wish(text: str) -> dict[str, Any]:
    """A wish from JSON.

    Raises:
        BadInput: it is none.
    """
    try:
        return checked_wish(json.loads(text))
    except (ValueError, RecursionError) as error:
        raise BadInput(f"a wish is a JSON object, this is none ({error})") from error


def checked_wish(given: Any) -> dict[str, Any]:
    """A wish from what JSON held.

    Raises:
        BadInput: it is none.
    """
    if not isinstance(given, Mapping):
        raise BadInput("a wish is a JSON object with rev, photo, face, settings, points_px, want")
    rev, face, want = given.get("rev", 0), given.get("face") or 0, given.get("want") or ["preview"]
    if type(rev) is not int or not 0 <= rev < 2**32:
        raise BadInput("rev: expected a whole number from 0 below 4294967296")
    if type(face) is not int or not 0 <= face < 1000:
        raise BadInput("face: expected its place in the photo's faces, from 0")
    if not isinstance(want, list) or not set(map(str, want)) <= set(WANTED):
        raise BadInput(f"want: expected a list of some of {', '.join(WANTED)}")
    if not isinstance(given.get("photo"), str):
        raise BadInput("photo: expected the name that the photo was given")
    settings, plan = given.get("settings") or {}, given.get("plan") or {}
    if not isinstance(settings, Mapping) or not isinstance(plan, Mapping):
        raise BadInput("settings: expected an object of path: value; and plan: an object with machine or robot")
    return {
        "rev": rev,
        "photo": given["photo"],
        "face": face,
        "want": want,
        "settings": dict(settings),
        "plan": dict(plan),
        "points_px": given.get("points_px"),
    }
