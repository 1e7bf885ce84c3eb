"""A run's first rows with their tiles go in; a contact sheet, one HTML file that needs no other, comes out."""

from __future__ import annotations

import html
import os
from collections.abc import Iterator
from importlib import resources
from pathlib import Path

from limner.batch.run import Told
from limner.batch.summary import Summary
from limner.batch.tile import Tile, tile_of_svg, unpacked
from limner.errors import BadInput, LimnerError
from limner.storage import read_bytes

NAME = "contact-sheet.html"


def to_html(summary: Summary, folder: Path, store: str) -> bytes:
    """The sheet.

    Args:
        summary: of the run.
        folder: where the sheet will lie.
        store: where the drawings are; a drawing without a tile is read from there.
    """
    page = resources.files("limner.batch").joinpath("sheet.html").read_text(encoding="utf-8")
    parts = {
        "figures": "".join(_figures(summary)),
        "cards": "\n".join(_card(told, folder, store) for told in summary.shown),
        "errors": _errors(summary),
        "more": _more(summary),
    }
    for name, text in parts.items():
        page = page.replace(f"<!--{name}-->", text)
    return page.encode(errors="backslashreplace")


def _figures(summary: Summary) -> Iterator[str]:
    shown = [
        (f"{summary.photos:,}", "photos"),
        (f"{summary.photos - summary.failed:,}", "portraits"),
        (f"{summary.failed:,}", "without"),
        (f"{summary.strokes:,}", "strokes"),
        (f"{summary.ink_mm / 1000:,.0f} m", "of ink"),
    ]
    for value, name in shown:
        yield f"<div><b>{value}</b><span>{name}</span></div>"


def _card(told: Told, folder: Path, store: str) -> str:
    row, name = told.row, os.path.basename(told.row.photo) or told.row.photo
    tile = _tile(told, store)
    width, height = tile.width, tile.height
    photo = f'<img alt="" src="data:image/jpeg;base64,{tile.photo}">' if tile.photo else ""
    return (
        f'<figure data-name="{_text(row.photo.lower())}"><a href="{_text(_link(row.drawing, folder, store))}"'
        f' style="aspect-ratio:{width:g}/{height:g}">{photo}'
        f'<svg viewBox="0 0 {width:g} {height:g}" role="img" aria-label="{_text(name)}">'
        f'<path stroke-width="{tile.pen:g}" d="{_text(tile.path)}"/></svg></a>'
        f'<figcaption><b title="{_text(row.photo)}">{_text(name)}</b>'
        f"<span>{row.strokes} strokes · {row.points} points · {(row.ink_mm or 0) / 1000:.1f} m</span>"
        "</figcaption></figure>"
    )


def _tile(told: Told, store: str) -> Tile:
    """As it was kept; else from the drawing's file."""
    try:
        return unpacked(told.tile)
    except BadInput:
        return unpacked(_from_file(f"{store}/{told.row.drawing}"))


def _from_file(path: str) -> bytes:
    try:
        return tile_of_svg(read_bytes(path))
    except LimnerError:
        return tile_of_svg(b"")


def _link(drawing: str, folder: Path, store: str) -> str:
    """To the drawing, relative where it lies beside the sheet."""
    from urllib.parse import quote

    return quote(drawing) if store == str(folder) else f"{store}/{quote(drawing)}"


def _errors(summary: Summary) -> str:
    if not summary.broken:
        return ""
    kinds = "".join(f"<li><b>{count:,}</b> {_text(kind)}</li>" for kind, count in summary.errors.most_common(8))
    rows = "".join(
        f'<tr data-name="{_text(told.row.photo.lower())}"><td>{_text(told.row.photo)}</td>'
        f"<td>{_text(told.row.error)}</td></tr>"
        for told in summary.broken
    )
    return f"<section><h2>Without a portrait</h2><ul>{kinds}</ul><table>{rows}</table></section>"


def _more(summary: Summary) -> str:
    left = summary.photos - len(summary.shown) - len(summary.broken)
    return f"<p>{left:,} more are in manifest.csv.</p>" if left else ""


def _text(text: str) -> str:
    return html.escape(text)
