"""Headings, words, pictures and tables go in; one HTML page that needs no other file comes out."""

from __future__ import annotations

import base64
import html
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from limner.evaluate.tables import Grid

Rgb = NDArray[np.uint8]

_WIDEST_PX = 880
_QUALITY = 45

_STYLE = """
:root { color-scheme: light dark; --paper: #fbfaf7; --ink: #1d1f24; --faint: #686d78; --line: #dcd9d2; --mark: #a8401c }
@media (prefers-color-scheme: dark) {
  :root { --paper: #17181b; --ink: #e7e5e0; --faint: #9aa0ab; --line: #34363c; --mark: #f08a5d }
}
* { box-sizing: border-box }
body { margin: 0; background: var(--paper); color: var(--ink);
  font: 17px/1.6 Georgia, 'Iowan Old Style', 'Times New Roman', serif }
main { max-width: 62rem; margin: 0 auto; padding: 3rem 1.25rem 6rem }
h1 { font-size: 2.3rem; line-height: 1.15; margin: 0 0 1rem; text-wrap: balance }
h2 { font-size: 1.55rem; margin: 4rem 0 1rem; padding-top: 1.2rem; border-top: 1px solid var(--line) }
h3 { font-size: 1.15rem; margin: 2.4rem 0 .5rem }
p { max-width: 44rem; margin: .6rem 0 }
a { color: var(--mark) }
nav { columns: 16rem; margin: 2rem 0; font-size: .95rem }
nav a { display: block; padding: .12rem 0; text-decoration: none }
nav a:hover { text-decoration: underline }
figure { margin: 1.4rem 0 }
figure img { display: block; max-width: 100%; height: auto; background: #fff;
  border: 1px solid var(--line); border-radius: 4px }
figcaption, caption, .note { color: var(--faint); font: .9rem/1.45 system-ui, sans-serif }
figcaption { margin-top: .5rem; max-width: 46rem }
.pair { display: grid; grid-template-columns: repeat(auto-fit, minmax(17rem, 1fr)); gap: .2rem 2rem; max-width: 58rem }
.pair b { display: block; color: var(--mark); font: 600 .78rem/1.4 system-ui, sans-serif; letter-spacing: .06em;
  text-transform: uppercase; margin-top: .7rem }
.wide { overflow-x: auto; margin: 1.2rem 0 }
table { border-collapse: collapse; font: .86rem/1.4 system-ui, sans-serif; font-variant-numeric: tabular-nums }
caption { text-align: left; padding-bottom: .5rem }
th, td { padding: .3rem .75rem; text-align: right; white-space: nowrap; border-bottom: 1px solid var(--line) }
th { white-space: normal; vertical-align: bottom; font-weight: 600 }
th:first-child, td:first-child { text-align: left; padding-left: 0 }
"""


@dataclass(frozen=True)
class Section:
    """A part of the page.

    Attributes:
        number: of the thesis's section, figure or table; its anchor.
        title: its heading.
        theirs: what the thesis does or finds, in our words; may be empty.
        ours: what is done or found here, and what differs and why; may be empty.
        figures: (H, W, 3) RGB pictures with their captions.
        grids: tables.
        chapter: whether it begins a chapter.
    """

    number: str
    title: str
    theirs: str = ""
    ours: str = ""
    figures: tuple[tuple[Rgb, str], ...] = ()
    grids: tuple[Grid, ...] = ()
    chapter: bool = False


def to_html(title: str, lead: str, sections: Sequence[Section]) -> bytes:
    """The page, pictures and all.

    Args:
        title: of the page.
        lead: what stands under it.
        sections: in order.
    """
    said = html.escape
    links = "".join(f'<a href="#s{said(s.number)}">{said(s.number)} {said(s.title)}</a>' for s in sections if s.chapter)
    parts = [
        "<!doctype html>",
        '<html lang="en"><head><meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>{said(title)}</title><style>{_STYLE}</style></head><body><main>",
        f"<h1>{said(title)}</h1><p>{said(lead)}</p><nav>{links}</nav>",
        *(_section(section) for section in sections),
        "</main></body></html>\n",
    ]
    return "\n".join(parts).encode()


def _section(section: Section) -> str:
    level = "h2" if section.chapter else "h3"
    lines = [f'<section id="s{html.escape(section.number)}">']
    lines.append(f"<{level}>{html.escape(section.number)} {html.escape(section.title)}</{level}>")
    words = [(who, text) for who, text in (("the thesis", section.theirs), ("here", section.ours)) if text]
    if words:
        lines.append('<div class="pair">')
        lines += [f"<p><b>{who}</b>{html.escape(text)}</p>" for who, text in words]
        lines.append("</div>")
    lines += [_figure(picture, caption) for picture, caption in section.figures]
    lines += [_table(grid) for grid in section.grids]
    return "\n".join([*lines, "</section>"])


def _figure(picture: Rgb, caption: str) -> str:
    data = base64.b64encode(_webp(picture)).decode()
    said = html.escape(caption)
    return f'<figure><img alt="{said}" src="data:image/webp;base64,{data}"><figcaption>{said}</figcaption></figure>'


def _webp(picture: Rgb) -> bytes:
    height, width = picture.shape[:2]
    if width > _WIDEST_PX:
        size = (_WIDEST_PX, round(height * _WIDEST_PX / width))
        picture = np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), np.uint8)
    _, data = cv2.imencode(".webp", picture[..., ::-1], [cv2.IMWRITE_WEBP_QUALITY, _QUALITY])
    return bytes(data)


def _table(grid: Grid) -> str:
    head = "".join(f"<th>{html.escape(name)}</th>" for name in grid.columns)
    rows = "".join("<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>" for row in grid.rows)
    note = f'<p class="note">{html.escape(grid.note)}</p>' if grid.note else ""
    caption = f"<caption>{html.escape(grid.title)}</caption>"
    return f'<div class="wide"><table>{caption}<thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div>{note}'
