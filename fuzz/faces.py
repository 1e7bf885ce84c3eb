"""Bytes of a file of landmarks go in, to be read as faces."""

from __future__ import annotations

from fuzz.contract import Reader, file_of
from limner import storage
from limner.types import Face
from limner.vision.landmarks.annotation import read_faces


def _of(suffix: str) -> Reader:
    def read(data: bytes) -> None:
        with file_of(data, f"face{suffix}") as path:
            faces = read_faces(path)
        for face in faces:
            assert storage.from_json(Face, storage.to_json(face)) == face

    return read


HARNESSES = {f"faces-{suffix[1:]}": _of(suffix) for suffix in (".json", ".pts", ".csv")}
