"""Measured corrections in; the thesis's tables 3.1 to 3.4 with ours beside its figures, out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from limner.evaluate.corrections import Measured
from limner.types import Floats
from limner.vision.landmarks.fmp.dataset import Sample

Indices = NDArray[np.signedinteger[Any]]

BROWS, CORNERS, JAW, INNER = np.arange(17, 27), np.array([36, 39, 42, 45]), np.arange(17), np.arange(17, 68)

THESIS_BROWS = (
    (14.84, 15.47, 15.48, 13.94, 12.40, 15.91, 15.52, 15.52, 19.06, 16.50),
    (8.02, 8.43, 8.05, 7.33, 6.71, 8.52, 8.04, 8.24, 11.41, 10.03),
)
THESIS_CORNERS = ((13.347, 5.895, 8.112, 10.075), (19.341, 6.167, 13.608, 10.241))
THESIS_ESTIMATES = (0.048, 0.045, 0.041, 0.044, 0.044, 0.051, 0.049, 0.047, 0.043, 0.060)
THESIS_JAW = tuple(
    zip(
        (17.93, 14.62, 14.40, 10.90, 11.45),
        (15.05, 12.30, 12.74, 11.08, 11.27),
        (15.40, 12.38, 11.08, 12.89, 12.71),
        (17.60, 10.17, 10.12, 11.14, 13.62),
        (19.56, 11.84, 10.90, 12.85, 15.15),
        (19.93, 12.11, 12.50, 16.16, 17.55),
        (20.19, 13.47, 13.95, 17.47, 16.13),
        (23.30, 17.89, 16.46, 20.21, 18.85),
        (20.22, 13.89, 15.03, 16.70, 14.81),
        (17.40, 11.94, 10.80, 16.47, 16.43),
        (15.54, 9.53, 9.87, 14.55, 15.15),
        (13.78, 12.24, 11.03, 11.06, 11.08),
        (12.41, 10.10, 10.20, 9.13, 8.06),
        (13.30, 9.72, 8.41, 10.89, 10.85),
        (12.58, 9.96, 9.27, 13.04, 13.02),
        (11.99, 9.73, 9.94, 8.61, 9.47),
        (13.74, 10.75, 10.50, 8.52, 8.12),
        strict=True,
    )
)
"""The thesis's figures [px], one tuple for each column."""


@dataclass(frozen=True)
class Grid:
    """A table of text.

    Attributes:
        title: what it is.
        columns: their heads; the first names the rows.
        rows: of cells.
        note: what must be known to read it; may be empty.
    """

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    note: str = ""

    def to_dict(self) -> dict[str, Any]:
        """The same, as it stands in JSON."""
        return {
            "title": self.title,
            "columns": list(self.columns),
            "rows": [list(r) for r in self.rows],
            "note": self.note,
        }


@dataclass(frozen=True)
class Layout:
    """How one of the thesis's tables is laid out.

    Attributes:
        title: of the table.
        row: what its rows are called.
        names: of the rows.
        landmarks: of each row.
        columns: heads, and the name of ``CORRECTIONS`` each shows.
        thesis: its figures [px], one tuple for each column but those it lacks.
    """

    title: str
    row: str
    names: tuple[str, ...]
    landmarks: Indices
    columns: tuple[tuple[str, str], ...]
    thesis: tuple[tuple[float, ...], ...]


TABLE_1 = Layout(
    "Table 3.1: eyebrows",
    "Eyebrow landmark",
    tuple(str(k) for k in range(1, 11)),
    BROWS,
    (("initial detection", "initial"), ("after correction", "brows"), ("to the upper edge", "brows-upper")),
    THESIS_BROWS,
)
_TO_LINE = "Distances to the line along the {} of the annotated brow."
TABLE_2 = Layout(
    "Table 3.2: eye corners",
    "Landmark",
    tuple(f"{side} eye corner {k}" for side in ("Right", "Left") for k in (1, 2)),
    CORNERS,
    (("initial detection", "initial"), ("corrected (FAST)", "fast"), ("corrected (Harris)", "harris")),
    THESIS_CORNERS,
)
TABLE_4 = Layout(
    "Table 3.4: jawline",
    "Landmark",
    tuple(str(k) for k in range(1, 18)),
    JAW,
    (
        ("initial detection", "initial"),
        ("gradient magnitude", "gradient"),
        ("regularized spline", "spline"),
        ("PCA 35", "shape35"),
        ("PCA 50", "shape50"),
    ),
    THESIS_JAW,
)


def tables(name: str, measured: Sequence[Measured]) -> list[Grid]:
    """Tables 3.1, 3.2 and 3.4 and a summary, of one set and one detector.

    Args:
        name: of the set and the detector.
        measured: its faces.
    """
    grids = [_grid(layout, name, measured, _note(layout, measured)) for layout in (TABLE_1, TABLE_2, TABLE_4)]
    lines = measured[0].brows_px if measured else ()
    grids[1:1] = [_grid(TABLE_1, f"{name}, {line}", _brows(measured, line), _TO_LINE.format(line)) for line in lines]
    return [*grids, summary(name, measured)]


def _brows(measured: Sequence[Measured], line: str) -> list[Measured]:
    """The distances of the brows to a line along them, as errors of their landmarks."""
    return [
        Measured(m.unit_px, {key: _only(BROWS, value) for key, value in m.brows_px[line].items()}) for m in measured
    ]


def _only(landmarks: Indices, values: Floats) -> Floats:
    errors = np.full(68, np.nan)
    errors[landmarks] = values
    return errors


def _note(layout: Layout, measured: Sequence[Measured]) -> str:
    if not measured or not measured[0].brows_px:
        return ""
    if layout is TABLE_1:
        return (
            "IMM's brow points lie on its upper edge; the thesis's correction leads to its darkest line, in its middle."
        )
    if layout is TABLE_4:
        return "Distances to the annotated curve, which begins at the ear lobes: landmarks above them are left out."
    return ""


def _grid(layout: Layout, name: str, measured: Sequence[Measured], note: str) -> Grid:
    keys = [key for _, key in layout.columns]
    units = np.array([m.unit_px for m in measured])
    errors = {
        key: np.array([m.errors_px[key][layout.landmarks] for m in measured]).reshape(-1, len(layout.names))
        for key in keys
    }
    rows = [
        (label, *(_pair(errors[key][:, k], units) for key in keys), *(f"{column[k]:.2f}" for column in layout.thesis))
        for k, label in enumerate(layout.names)
    ]
    rows.append(("mean", *(_pair(errors[key].T, units) for key in keys), *_means(layout.thesis)))
    shares = [_mean(errors[key].T / units) for key in keys]
    thesis = [float(np.mean(column)) for column in layout.thesis]
    rows.append(("change", *_changes(shares), *_changes(thesis)))
    heads = tuple(head for head, _ in layout.columns)
    columns = (layout.row, *heads, *(f"thesis: {head}" for head in heads[: len(layout.thesis)]))
    return Grid(f"{layout.title}, {name}", columns, tuple(rows), note)


def _pair(errors: Floats, units: Floats) -> str:
    """Mean in pixels / in per cent of the outer-eye distance."""
    if not np.isfinite(errors).any():
        return "-"
    return f"{_mean(errors):.2f} / {100 * _mean(errors / units):.2f} %"


def _mean(values: Floats) -> float:
    return float(np.nanmean(values)) if np.isfinite(values).any() else float("nan")


def _means(columns: Sequence[Sequence[float]]) -> list[str]:
    return [f"{np.mean(column):.2f}" for column in columns]


def _changes(means: Sequence[float]) -> list[str]:
    """From the first of them, in per cent; none where that is 0."""
    known = [bool(np.isfinite(mean) and means[0]) for mean in means]
    pairs = zip(means[1:], known[1:], strict=True)
    return ["", *(f"{100 * (mean / means[0] - 1):+.0f} %" if shown else "-" for mean, shown in pairs)]


def summary(name: str, measured: Sequence[Measured]) -> Grid:
    """Every correction over all landmarks, in per cent of the outer-eye distance."""
    parts = (
        ("all known", np.arange(68)),
        ("inner 51", INNER),
        ("eye corners", CORNERS),
        ("brows", BROWS),
        ("jaw", JAW[3:14]),
    )
    rows = []
    for key in measured[0].errors_px if measured else ():
        shares = np.array([m.errors_px[key] / m.unit_px for m in measured])
        before = np.nanmean([m.errors_px["initial"] / m.unit_px for m in measured], axis=1)
        worse = int((np.nanmean(shares, axis=1) > before + 1e-9).sum())
        rows.append(
            (key, *(f"{100 * _mean(shares[:, where]):.2f} %" for _, where in parts), f"{worse} of {len(measured)}")
        )
    columns = ("correction", *(label for label, _ in parts), "faces worse than initial")
    return Grid(f"Summary, {name}", columns, tuple(rows), "Jaw: landmarks 4 to 14.")


def estimate_table(name: str, samples: Sequence[Sample], errors: Sequence[float], components: int) -> Grid:
    """Table 3.3: what the shape model makes of true landmarks of people it never saw."""
    rows = tuple(
        (str(k + 1), f"{error:.4f}", f"{thesis:.3f}")
        for k, (error, thesis) in enumerate(zip(errors, THESIS_ESTIMATES, strict=False))
    )
    mean = ("mean", f"{np.mean(errors):.4f}", f"{np.mean(THESIS_ESTIMATES):.3f}")
    note = (
        f"Sum of squared distances in squared outer-eye distances; {components} components hold 99 % of the variance of"
        f" {len(samples) - len(errors)} faces and their mirror images (thesis: 57 of 110, in a unit it does not name)."
    )
    return Grid(f"Table 3.3: PCA estimation errors, {name}", ("Image", "Error", "thesis"), (*rows, mean), note)
