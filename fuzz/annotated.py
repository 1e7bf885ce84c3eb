"""Bytes of annotated photos go in: the npz of their landmarks, a photo of them, a table of their people."""

from __future__ import annotations

import io

import numpy as np
from PIL import Image

from fuzz.contract import Reader, file_of
from limner.evaluate.corrections import read_truths
from limner.evaluate.likeness import read_groups
from limner.storage import pack_npz
from limner.vision.landmarks.fmp.dataset import read_folder
from limner.vision.photo import MAX_PIXELS, load_photo, photo_size

NAMES, SIZE = ("a_1.png", "b_2.png"), (12, 10)
"""The photos beside the landmarks, all of one size."""


def _picture() -> bytes:
    out = io.BytesIO()
    Image.new("RGB", SIZE).save(out, "PNG")
    return out.getvalue()


PICTURE = _picture()


def _labels(name: str) -> Reader:
    def read(data: bytes) -> None:
        with file_of(data, name) as path:
            (path.parent / "images").mkdir()
            for photo in NAMES:
                (path.parent / "images" / photo).write_bytes(PICTURE)
            if name == "landmarks.npz":
                read_truths(path.parent)
            for sample in read_folder(path, skip=True)[0]:
                assert np.isfinite([*sample.box_px, sample.yaw_deg]).all()

    return read


def sized(data: bytes) -> None:
    """A photo is as large as was said before it was decoded, perhaps turned: that may stand behind its pixels."""
    size = photo_size(data)
    assert size[0] * size[1] <= MAX_PIXELS
    photo = load_photo(data)
    assert sorted(photo.size_px) == sorted(size)
    points = np.linspace(0, 1, 136).reshape(1, 68, 2)
    arrays = {"names": np.array(["a_1.png"]), "size_wh": np.array([size]), "ibug68": points}
    with file_of(pack_npz(arrays), "landmarks.npz") as path:
        (path.parent / "images").mkdir()
        (path.parent / "images" / "a_1.png").write_bytes(data)
        assert len(read_folder(path)[0]) == 1


def people(data: bytes) -> None:
    """The table of the people in a set of photos."""
    with file_of(data, "info.csv") as path:
        read_groups(path)


HARNESSES = {
    "annotated": _labels("landmarks.npz"),
    "annotated-machine": _labels("landmarks_machine.npz"),
    "annotated-photo": sized,
    "people": people,
}
