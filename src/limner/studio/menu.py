"""The descriptions of the settings go in; what the page offers comes out: settings, sliders, presets, lists."""

from __future__ import annotations

import dataclasses
import typing
from typing import Any

from limner.motion.arm.robots import ROBOTS
from limner.motion.machine import MACHINES, load_machine
from limner.pipeline import Settings
from limner.settings import NONE
from limner.studio.exports import FORMATS
from limner.studio.wishes import FILES
from limner.units import PAGES_MM
from limner.vision.lines import MEASURED, PICTURES, STYLES
from limner.vision.refine import REFINEMENTS

SLIDERS: tuple[dict[str, Any], ...] = (
    {
        "name": "detail",
        "label": "Detail",
        "help": "fainter lines are drawn too",
        "default": 0.5,
        "sets": [
            {"path": "portrait.detail", "stops": [[0, 0.4], [0.5, 1.0], [1, 2.5]]},
            {"path": "canny.raise_high", "stops": [[0, 4.0], [0.5, 2.5], [1, 1.0]]},
            {"path": "gabor.high", "stops": [[0, 3.0], [0.5, 1.8], [1, 1.0]]},
            {"path": "gabor.low", "stops": [[0, 1.5], [0.5, 0.9], [1, 0.5]]},
            {"path": "gabor_pyramid.high", "stops": [[0, 3.3], [0.5, 2.0], [1, 1.1]]},
            {"path": "gabor_pyramid.low", "stops": [[0, 1.7], [0.5, 1.0], [1, 0.6]]},
        ],
    },
    {
        "name": "hair",
        "label": "Hair",
        "help": "strands of hair lie closer",
        "default": 0.5,
        "sets": [
            {"path": "portrait.hair_apart", "stops": [[0, 0.14], [0.5, 0.042], [1, 0.02]]},
            {"path": "regions.hair", "stops": [[0, 0.3], [0.5, 1.5], [1, 5.0]]},
        ],
    },
    {
        "name": "tone",
        "label": "Shading",
        "help": "from lines alone to a full drawing",
        "default": 0.0,
        "sets": [{"path": "tone.level", "steps": ["none", "light", "medium", "rich"]}],
    },
    {
        "name": "smoothness",
        "label": "Smoothness",
        "help": "fewer points, softer lines",
        "default": 0.5,
        "sets": [
            {"path": "clean.tolerance_mm", "stops": [[0, 0.03], [0.5, 0.15], [1, 0.6]]},
            {"path": "trace.smooth_px", "stops": [[0, 0.5], [0.5, 2.5], [1, 7.0]]},
            {"path": "portrait.flow.along_px", "stops": [[0, 3.0], [0.5, 5.0], [1, 10.0]]},
        ],
    },
)
"""Simple sliders from 0 to 1, and the settings that each sets: by straight lines through stops, or by equal steps."""

PRESETS: tuple[dict[str, Any], ...] = (
    {
        "name": "2-minutes",
        "label": "2 minutes",
        "help": "what a plotter draws while one waits",
        "settings": {"select.minutes": 2.0, "tone.level": "none"},
    },
    {
        "name": "8-minutes",
        "label": "8 minutes",
        "help": "all lines, and light shading",
        "settings": {"select.minutes": 8.0, "tone.level": "light"},
    },
    {
        "name": "rich",
        "label": "Rich",
        "help": "shaded from light to dark, as long as it takes",
        "settings": {"select.minutes": None, "tone.level": "rich"},
    },
)

STYLE_LABELS = {
    "portrait": ("Portrait", "lines chosen as a portraitist would"),
    "gabor": ("Gabor", "fine dark lines, the features closest"),
    "gabor-pyramid": ("Gabor, several sizes", "lines from fine to broad"),
    "canny": ("Canny", "edges between light and dark"),
    "splines": ("Splines", "the features alone, through the landmarks"),
    "cartoon": ("Cartoon", "edges and tones in a few inks, as comics have them"),
    "painterly": ("Painting", "lines along brush strokes, in a few inks"),
    "one-line": ("One line", "a single line that crosses itself nowhere"),
    "scribble": ("Scribble", "loops, dense where the face is dark"),
    "stipple": ("Dots", "as dense as the face is dark"),
}
"""Of each style, in the order in which they are shown; one without a label of its own goes by its name."""

SLOW = (*MEASURED, *PICTURES)
"""Styles that take seconds: as candidates they are drawn beside the live preview, not before it."""


def options(base: Settings) -> dict[str, Any]:
    """All that the page offers."""
    return {
        "settings": settings_tree(base),
        "sliders": list(SLIDERS),
        "presets": list(PRESETS),
        "styles": [{"name": name, **_labels(name), "picture": name in PICTURES} for name in styles()],
        "refinements": [NONE, *REFINEMENTS],
        "machines": [_machine(name) for name in MACHINES],
        "robots": [{"name": name} for name in ROBOTS],
        "pages": [{"name": name, "width_mm": size[0], "height_mm": size[1]} for name, size in PAGES_MM.items()],
        "exports": list(FORMATS),
    }


def styles() -> list[str]:
    """All styles, those with labels first."""
    return [*(name for name in STYLE_LABELS if name in STYLES), *(name for name in STYLES if name not in STYLE_LABELS)]


def _labels(style: str) -> dict[str, str]:
    label, about = STYLE_LABELS.get(style, (style.replace("-", " ").capitalize(), ""))
    return {"label": label, "help": about}


def _machine(name: str) -> dict[str, Any]:
    machine = load_machine(name)
    return {"name": name, "width_mm": machine.width_mm, "height_mm": machine.height_mm, "home": machine.home}


def settings_tree(base: Settings) -> list[dict[str, Any]]:
    """Every setting that the page may change, in the order of the tree."""
    return [
        {
            "path": path,
            "type": _kind(path),
            "default": _value(base, path),
            **dataclasses.asdict(about),
            "choices": list(about.choices),
        }
        for path, about, _ in Settings.walk()
        if path not in FILES
    ]


def _value(base: Settings, path: str) -> Any:
    value: Any = base
    for name in path.split("."):
        value = getattr(value, name)
    return value


def _kind(path: str) -> str:
    *groups, name = path.split(".")
    group: Any = Settings
    for part in groups:
        group = typing.get_type_hints(group)[part]
    hint = typing.get_type_hints(group)[name]
    kinds = typing.get_args(hint) or (hint,)
    return next(word for kind, word in _KINDS.items() if kind in kinds) + ("?" if type(None) in kinds else "")


_KINDS = {bool: "bool", float: "float", int: "int", str: "text"}


def variants(kind: str, wish: dict[str, Any], base: Settings) -> list[dict[str, Any]]:
    """What stands side by side: of ``candidates`` the styles and other landmarks, of ``refinements`` each of them.

    A candidate is the same whichever of them is chosen now: what makes one of them, all of them say.
    """
    # Landmarks that were placed by hand are drawn as they are.
    by_hand = wish.get("points_px") is not None
    if kind == "refinements":
        names = () if by_hand else (NONE, *REFINEMENTS)
        return [{"name": name, "label": name, "settings": {"refine": name}} for name in names]
    found = [_style(name, base) for name in styles() if name not in SLOW]
    if not by_hand:
        found += [
            _candidate("landmarks-as-found", "Landmarks as found", base.style, NONE),
            _candidate("landmarks-average", "Landmarks nearer the average", base.style, "shape"),
        ]
    return found + [_style(name, base) | {"slow": True} for name in styles() if name in SLOW]


def _style(name: str, base: Settings) -> dict[str, Any]:
    return _candidate(name, _labels(name)["label"], name, base.refine)


def _candidate(name: str, label: str, style: str, refine: str) -> dict[str, Any]:
    return {"name": name, "label": label, "settings": {"style": style, "refine": refine}}
