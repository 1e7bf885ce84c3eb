"""Faces with their boxes go in; they come out largest first, and how much two of them share."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from limner.types import Face, Floats


def largest_first(faces: Iterable[Face]) -> tuple[Face, ...]:
    """Sorted by the area of their boxes."""
    return tuple(sorted(faces, key=lambda face: -float(np.prod(face.box_px[2:] - face.box_px[:2]))))


def overlap(a: Floats, b: Floats) -> float:
    """Intersection over union of two boxes x0, y0, x1, y1."""
    shared = float(np.clip(np.minimum(a[2:], b[2:]) - np.maximum(a[:2], b[:2]), 0, None).prod())
    return shared / float((a[2:] - a[:2]).prod() + (b[2:] - b[:2]).prod() - shared)


def distinct(faces: Iterable[Face], most_shared: float) -> tuple[Face, ...]:
    """Of faces that share more than ``most_shared`` of their union that of the best score, largest first."""
    kept: list[Face] = []
    for face in sorted(faces, key=lambda face: -face.score):
        if all(overlap(face.box_px, other.box_px) <= most_shared for other in kept):
            kept.append(face)
    return largest_first(kept)
