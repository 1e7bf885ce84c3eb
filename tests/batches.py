"""Small photos with faces beside them for the tests of batches: drawn in milliseconds, without looking for a face."""

from __future__ import annotations

import csv
import json
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
from PIL import Image

from limner import Settings, draw, storage
from limner.batch.engine import Engine
from limner.batch.everything import draw_batch
from limner.batch.manifest import CSV
from limner.batch.run import Order
from limner.batch.summary import Summary
from limner.batch.work import Recipe
from portraits import ASTRONAUT, face_of

QUICK = Settings(style="splines")
FACE = face_of((ASTRONAUT - [150, 60]) * 0.8)


def put_photo(path, shade, sidecar=True):
    """A photo that differs by its shade, with the landmarks of a face beside it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    y, x = np.indices((130, 120))
    rgb = np.stack([x + shade, y + 2 * shade, x * 0 + 90], axis=2) % 256
    Image.fromarray(rgb.astype(np.uint8)).save(path, "PNG")
    if sidecar:
        path.with_suffix(".json").write_text(storage.to_json(FACE))
    return path


def put_photos(folder, count):
    """So many photos, their paths in order."""
    return [put_photo(folder / f"p{k:03}.png", k) for k in range(count)]


def expected_svg(path):
    """What drawing a photo of ``put_photo`` by itself gives."""
    return draw(path, QUICK, face=FACE).svg()


def order_for(out, settings=QUICK, **changes):
    """An order to draw into a folder, which is made."""
    out.mkdir(parents=True, exist_ok=True)
    formats = changes.pop("formats", ("svg",))
    place = None if changes.get("send") else str(out)
    return Order(Recipe(settings, formats, out=place), out, str(out), **{"sidecars": True, "tiles": 9} | changes)


def run_batch(photos, out, engine=None, watch=None, parquet=False, **changes):
    """Draw in this process, or by an engine: the summary and the rows of the manifest."""
    summary = Summary(9)
    with ThreadPoolExecutor(1) as here:
        order = order_for(Path(out), **changes)
        names = map(str, photos)
        draw_batch(names, engine or Engine(here, 1), order, summary, watch or (lambda told: None), parquet)
    return summary, rows_of(out)


def rows_of(out):
    """The manifest."""
    with open(Path(out) / CSV, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def files_of(out, suffix=".svg"):
    """Name -> bytes of the drawings."""
    return {path.name: path.read_bytes() for path in Path(out).iterdir() if path.name.endswith(suffix)}


def leftovers(out):
    """Hidden files but those that a batch keeps."""
    return {path.name for path in Path(out).glob(".*")} - {".lock", ".state.sqlite"}


def report_of(ran):
    """The one JSON object on stdout."""
    return json.loads(ran.stdout)
