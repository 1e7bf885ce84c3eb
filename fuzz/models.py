"""Bytes of a model's file go in, to be read as that model."""

from __future__ import annotations

from pathlib import Path

from fuzz.contract import file_of
from limner.vision.landmarks.fmp import checkpoint
from limner.vision.landmarks.fmp.matlab import import_matlab
from limner.vision.landmarks.fmp.model import pack_model, unpack_model
from limner.vision.likeness.model import load_likeness
from limner.vision.refine.best import load_best
from limner.vision.refine.shape import load_shape


def fmp(data: bytes) -> None:
    """A flexible mixture of parts; what was read can be written and read again."""
    model = unpack_model(data)
    assert unpack_model(pack_model(model)) == model


def mat(data: bytes) -> None:
    """A model of Zhu & Ramanan."""
    with file_of(data, "model.mat") as path:
        import_matlab(path)


def checkpoints(data: bytes) -> None:
    """The state of a training."""
    with file_of(data, "state.npz") as path:
        checkpoint.load(path, OWNER)


OWNER = "owner"


def likeness(data: bytes) -> None:
    """A likeness model."""
    with file_of(data, "likeness.npz") as path:
        load_likeness(path)


def shape(data: bytes) -> None:
    """A shape model."""
    with file_of(data, "shape.npz") as path:
        load_shape.__wrapped__(path)


def best(data: bytes) -> None:
    """A cascade."""
    with file_of(data, "best.npz") as path:
        load_best.__wrapped__(str(Path(path)))


HARNESSES = {
    "fmp": fmp,
    "mat": mat,
    "checkpoint": checkpoints,
    "likeness": likeness,
    "shape": shape,
    "best": best,
}
