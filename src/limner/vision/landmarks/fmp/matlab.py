"""A model file of Zhu & Ramanan's release goes in (.mat), the same model as ours comes out."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from limner.errors import BadInput, MissingExtra
from limner.storage import read_bytes
from limner.vision.landmarks.fmp.model import Component, FmpModel

_FILE_LIMIT = 64 * 2**20

_DEMO_THRESHOLD = -0.65
"""What the release's own demonstration lowers the threshold to: the one in the files misses half of the faces."""

_FRONTAL = """
    34 33 32 35 36 31 30 29 28  40 41 42 39 38 37  18 19 20 21 22  43 48 47 44 45 46  27 26 25 24 23
    52 51 50 49 61 62 63 53 54 55 65 64  56 66 57 67 59 68 60 58  9 8 7 6 5 4 3 2 1 10 11 12 13 14 15 16 17
"""
_PROFILE = """
    6 5 4 3 2 1  14 15 11 12 13  10 9 8 7  16 17 18 19 20 21 22  25 24 23 26 27
    28 29 30 31 32 33 34 35 36 37 38 39
"""
_ORDER = {len(text.split()): np.array(text.split(), np.int64) - 1 for text in (_FRONTAL, _PROFILE)}
"""Landmark (0-based, iBUG-68 or MultiPIE-39) of each part, by the number of parts."""


def import_matlab(path: str | Path) -> FmpModel:
    """Read a model of the release ``face-release1.0-basic`` (CVPR 2012, doi:10.1109/CVPR.2012.6248014).

    Raises:
        BadInput: unreadable, or another kind of MATLAB file.
        MissingExtra: scipy is not installed.
    """
    try:
        from scipy.io import loadmat
    except ImportError as error:
        raise MissingExtra("importing a MATLAB model", "train") from error
    file: Any = io.BytesIO(read_bytes(path, _FILE_LIMIT))
    try:
        raw = loadmat(file, mat_dtype=True)["model"][0, 0]
        return _model(raw, Path(path).stem)
    except BadInput as error:
        raise BadInput(f"{path}: {error}") from error
    except Exception as error:  # a damaged file makes scipy raise errors of many kinds
        raise BadInput(f"{path}: not a face model of Zhu & Ramanan ({type(error).__name__}: {error})") from error


def _model(raw: Any, name: str) -> FmpModel:
    springs = [spring["w"].ravel() for spring in raw["defs"][0]]
    anchors = [spring["anchor"].ravel() for spring in raw["defs"][0]]
    components = tuple(
        _component(parts[0], springs, anchors, yaw_deg=90.0 - 15.0 * k) for k, parts in enumerate(raw["components"][0])
    )
    return FmpModel(
        filters=np.stack([each["w"] for each in raw["filters"][0]]).astype(np.float64),
        components=components,
        threshold=min(_DEMO_THRESHOLD, _scalar(raw["thresh"])),
        interval=int(_scalar(raw["interval"])),
        cell_px=int(_scalar(raw["sbin"])),
        name=name,
        meta={"source": "face-release1.0-basic, MIT, (C) 2012 Xiangxin Zhu, Deva Ramanan"},
    )


def _component(parts: NDArray[Any], springs: list[Any], anchors: list[Any], yaw_deg: float) -> Component:
    if len(parts) not in _ORDER:
        raise BadInput(f"a component of {len(parts)} parts; expected one of {', '.join(map(str, _ORDER))}")
    defs = [int(_scalar(part["defid"])) - 1 for part in parts]
    return Component(
        yaw_deg=yaw_deg,
        bias=_scalar(springs[defs[0]]),
        parents=np.array([int(_scalar(part["parent"])) - 1 for part in parts]),
        filters=np.array([int(_scalar(part["filterid"])) - 1 for part in parts]),
        springs=np.stack([np.zeros(4), *(springs[d] for d in defs[1:])]),
        anchors=np.stack([np.zeros(2, int), *((anchors[d][:2] - 1).astype(int) for d in defs[1:])]),
        landmarks=_ORDER[len(parts)],
    )


def _scalar(value: Any) -> float:
    return float(np.asarray(value).ravel()[0])
